// SPDX-License-Identifier: MIT
#include "render/follow_scene.hpp"
#include "render/lamps.hpp"
#include "render/scene_cache.hpp"
#include "render/stopwatch.hpp"
#include "render/visibility.hpp"

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/snapshot.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace demo {

namespace {

bool has_size_of(const lightmesh::Light& a, const lightmesh::Light& b) {
    return std::visit(
        [&](const auto& kind) {
            using Kind = std::remove_cvref_t<decltype(kind)>;
            const auto* other = std::get_if<Kind>(&b);
            if constexpr (std::is_same_v<Kind, lightmesh::DirectionalLight>)
                return other != nullptr && kind.angular_radius == other->angular_radius;
            else if constexpr (std::is_same_v<Kind, lightmesh::RectLight>)
                return other != nullptr;  // the file's size, always
            else
                return other != nullptr && kind.radius == other->radius;
        },
        a);
}

/// What was found of lamps of other sizes would be left out by a merge without a word.
void require_same_sizes(std::span<const std::byte> known, std::span<const lightmesh::Light> lamps) {
    const lightmesh::SnapshotView view(known);
    const auto lights = view.lights();
    if (view.is_cache() && !std::ranges::equal(lights, lamps, has_size_of))
        throw std::runtime_error("what --mesh names was found for lamps of size " + lamp_size_text(lights) +
                                 ", and these are of size " + lamp_size_text(lamps) +
                                 "; give --light-size, or -r, as it was");
}

/// The lights of a scene as a cache takes them, by their numbers in it.
using LightsOf =
    std::function<std::vector<lightmesh::Light>(const EmbreeScene& scene, const VisibilityOptions& options)>;

template <class Cache>
class CacheVisibility final : public Visibility {
public:
    /// The options are those for the lights.
    CacheVisibility(Cache cache, LightsOf lights, VisibilityOptions options)
        : cache_(std::move(cache)), lights_(std::move(lights)), options_(std::move(options)) {}

    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost& cost) const override {
        const Stopwatch watch;
        cache_.visibility(points.points, lit);
        cost.seconds += watch.seconds();
    }

    void update(const EmbreeScene& scene, const SceneChange& change) override {
        follow_scene(cache_, lights_(scene, options_), change);
    }
    bool set_lights(const std::vector<std::size_t>& numbers) override {
        options_.lights = numbers;
        return true;
    }
    void begin_frame() override { cache_.begin_frame(); }

    std::optional<lightmesh::CacheStatistics> cache() const override { return cache_.statistics(); }
    std::vector<std::byte> snapshot() const override { return cache_.snapshot(); }
    void merge(std::span<const std::byte> known) override { cache_.merge(known); }

private:
    Cache cache_;
    LightsOf lights_;
    VisibilityOptions options_;
};

}  // namespace

SceneCache begun_cache_of(const EmbreeScene& scene, const VisibilityOptions& options) {
    SceneCache cache = cache_of(scene, options);
    if (!options.known.empty()) {
        require_same_sizes(options.known, lamps_of(scene, options));
        cache.merge(options.known);
    }
    return cache;
}

std::unique_ptr<Visibility> make_cache(const EmbreeScene& scene, const VisibilityOptions& options) {
    return std::make_unique<CacheVisibility<SceneCache>>(begun_cache_of(scene, options), lamps_of,
                                                         lamp_options(options));
}

std::unique_ptr<Visibility> make_blur_cache(const EmbreeScene& scene, const VisibilityOptions& options) {
    lightmesh::VisibilityCache cache{lightmesh::LightMesh{scene.intersector(),
                                                          shapes_of_lights(scene.scene(), options.lights),
                                                          options.settings},
                                     cache_settings_of(options)};
    VisibilityOptions for_lights;
    for_lights.lights = options.lights;
    return std::make_unique<CacheVisibility<decltype(cache)>>(
        std::move(cache),
        [](const EmbreeScene& now, const VisibilityOptions& which) {
            return shapes_of_lights(now.scene(), which.lights);
        },
        std::move(for_lights));
}

}  // namespace demo
