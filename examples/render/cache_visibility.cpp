// SPDX-License-Identifier: MIT
#include "render/lamps.hpp"
#include "render/visibility.hpp"

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <chrono>
#include <utility>
#include <vector>

namespace demo {

namespace {

template <class Cache>
class CacheVisibility final : public Visibility {
public:
    explicit CacheVisibility(Cache cache) : cache_(std::move(cache)) {}

    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost& cost) const override {
        const auto start = std::chrono::steady_clock::now();
        std::vector<lightmesh::SurfacePoint> known(points.positions.size());
        for (std::size_t i = 0; i < known.size(); ++i) {
            known[i].position = points.positions[i];
            known[i].normal = points.normals[i];
            if (!points.footprints.empty())
                known[i].footprint = points.footprints[i];
            if (!points.shading_normals.empty())
                known[i].shading_normal = points.shading_normals[i];
        }
        cache_.visibility(known, lit);
        cost.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }

    std::optional<lightmesh::CacheStatistics> cache() const override { return cache_.statistics(); }
    std::vector<std::byte> snapshot() const override { return cache_.snapshot(); }

private:
    Cache cache_;
};

}  // namespace

std::unique_ptr<Visibility> make_cache(const EmbreeScene& scene, const VisibilityOptions& options) {
    using Cache = lightmesh::VisibilityCache<EmbreeIntersector>;
    Cache cache(scene.intersector(), lamps_of(scene, options), cache_settings_of(options));
    if (!options.known.empty())
        cache.merge(options.known);
    return std::make_unique<CacheVisibility<Cache>>(std::move(cache));
}

std::unique_ptr<Visibility> make_blur_cache(const EmbreeScene& scene, const VisibilityOptions& options) {
    lightmesh::VisibilityCache cache{
        lightmesh::LightMesh{scene.intersector(), shapes_of_lights(scene.scene()), options.settings},
        cache_settings_of(options)};
    return std::make_unique<CacheVisibility<decltype(cache)>>(std::move(cache));
}

}  // namespace demo
