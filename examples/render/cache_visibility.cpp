// SPDX-License-Identifier: MIT
#include "render/visibility.hpp"

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <chrono>
#include <cmath>
#include <type_traits>
#include <utility>
#include <variant>
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

    std::optional<CacheReport> cache() const override {
        return CacheReport{cache_.settings().spacing, cache_.statistics()};
    }

private:
    Cache cache_;
};

/// The scene's lights as lamps of one size. Directional ones are as wide as such a lamp at half of the
/// scene's diagonal.
std::vector<lightmesh::Light> lamps_of(const EmbreeScene& scene, float size) {
    std::vector<lightmesh::Light> lamps = shapes_of_lights(scene.scene());
    for (lightmesh::Light& lamp : lamps)
        std::visit(
            [&](auto& kind) {
                using Kind = std::remove_cvref_t<decltype(kind)>;
                if constexpr (std::is_same_v<Kind, lightmesh::DirectionalLight>)
                    kind.angular_radius = std::atan(size / (0.5f * scene.diagonal()));
                else if constexpr (!std::is_same_v<Kind, lightmesh::RectLight>)
                    kind.radius = size;
            },
            lamp);
    return lamps;
}

lightmesh::CacheSettings settings_of(const VisibilityOptions& options) {
    return {.spacing = options.settings.radius / 4.0f};
}

}  // namespace

std::unique_ptr<Visibility> make_cache(const EmbreeScene& scene, const VisibilityOptions& options) {
    using Cache = lightmesh::VisibilityCache<EmbreeIntersector>;
    return std::make_unique<CacheVisibility<Cache>>(
        Cache(scene.intersector(), lamps_of(scene, lamp_size(options)), settings_of(options)));
}

std::unique_ptr<Visibility> make_blur_cache(const EmbreeScene& scene, const VisibilityOptions& options) {
    lightmesh::VisibilityCache cache{
        lightmesh::LightMesh{scene.intersector(), shapes_of_lights(scene.scene()), options.settings},
        settings_of(options)};
    return std::make_unique<CacheVisibility<decltype(cache)>>(std::move(cache));
}

}  // namespace demo
