// SPDX-License-Identifier: MIT
#pragma once

#include "render/embree_scene.hpp"
#include "scene/scene_change.hpp"

#include <lightmesh/cache_settings.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/surface_point.hpp>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace demo {

/// Rays from surface points by kind, and the time of the queries.
struct VisibilityCost {
    std::uint64_t shadow_rays = 0;
    std::uint64_t short_rays = 0;
    double seconds = 0.0;  ///< summed over threads

    VisibilityCost& operator+=(const VisibilityCost& other) {
        shadow_rays += other.shadow_rays;
        short_rays += other.short_rays;
        seconds += other.seconds;
        return *this;
    }
};

/// Surface points to be lit.
struct SurfacePoints {
    std::span<const lightmesh::SurfacePoint> points;  ///< with geometric normals of unit length
    /// One for each point: random, but the same whenever the same picture is rendered.
    std::span<const std::uint32_t> seeds;
};

/// The share of light that surface points get: all that the algorithms of `lightmesh-render` differ in. Const
/// members may be used by any number of threads. The scene that it was made for must outlive it.
class Visibility {
public:
    virtual ~Visibility() = default;

    /// `lit` is row-major, a row of the lights asked for at each point: 0 in shadow to 1 lit.
    virtual void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost& cost) const = 0;

    /// After the scene that this was made for has changed, and `scene` was updated: finds from now on what a
    /// new one would. Not while another thread uses this; `change` must not be to another scene.
    virtual void update(const EmbreeScene& scene, const SceneChange& change) = 0;

    /// Asks for other lights of the scene from the next `update` on, in the way of
    /// `VisibilityOptions::lights`: at least as many as before. What was found of those that keep their place
    /// is kept. False where a new object must be made instead, and nothing has changed.
    virtual bool set_lights(const std::vector<std::size_t>& /*numbers*/) { return false; }

    /// Says that a new frame begins, after `update`: what is over the memory budgets of the options and went
    /// unused is forgotten. Nothing that `find` tells depends on it. Not while another thread uses this.
    virtual void begin_frame() {}

    /// Forgets what `snapshot` leaves out. Nothing that `find` tells depends on it. Not while another thread
    /// uses this.
    virtual void compact() {}

    /// Of the light mesh, if there is one.
    virtual std::optional<lightmesh::MeshStatistics> mesh() const { return std::nullopt; }
    /// Of the visibility cache, if there is one.
    virtual std::optional<lightmesh::CacheStatistics> cache() const { return std::nullopt; }
    /// Adds what the `snapshot` of another one knows, of the scene as it is here and was there. Not while
    /// another thread uses this. Throws what the library's `merge` throws.
    virtual void merge(std::span<const std::byte> /*known*/) {}
    /// Of shadow maps and volumes outside a mesh.
    virtual std::size_t bytes() const { return 0; }
    /// All that a light mesh or a cache of lamps knows, for `VisibilityOptions::known`; nothing where there
    /// is none that could be saved.
    virtual std::vector<std::byte> snapshot() const { return {}; }
};

enum class DepthSource { vulkan, embree };

constexpr std::size_t no_light = (std::numeric_limits<std::size_t>::max)();

/// Options of the command line for an algorithm.
struct VisibilityOptions {
    lightmesh::Settings settings;  ///< its short test is that of `lmm`
    int area_samples = 16;         ///< rays to each light, in [1, 1024]
    float light_size = 0.0f;       ///< radius of lamps in world units; 0: see `lamps_of`
    /// Of visibility caches; spacing 0: see `cache_settings_of`.
    lightmesh::CacheSettings cache{.spacing = 0.0f};
    DepthSource depth = DepthSource::vulkan;
    std::string device;  ///< of Vulkan: an index or a part of its name; empty: the best
    /// As `ComputeOptions::ray_queries`.
    std::optional<bool> ray_queries = std::nullopt;
    /// A snapshot that a light mesh with long tests by rays, or a cache of lamps, begins with; empty: none.
    std::vector<std::byte> known{};
    bool keep_snapshot = false;  ///< whether `Run::snapshot` is wanted
    /// Numbers of the scene's lights that are asked for, to which rows of visibilities belong; nullopt: all.
    /// `no_light` in the place of one that is gone: what is found there means nothing.
    std::optional<std::vector<std::size_t>> lights{};
};

/// With the radius and the quality that suit the scene.
inline VisibilityOptions options_of(const Scene& scene) {
    VisibilityOptions options;
    options.settings.radius = scene.radius;
    options.settings.quality = scene.quality;
    return options;
}

/// Numbers of the lights that are asked for.
std::vector<std::size_t> numbers_of_lights(const Scene& scene, const VisibilityOptions& options);
/// The shapes of some lights, or of all, as a light mesh takes them.
std::vector<lightmesh::Light> shapes_of_lights(const Scene& scene,
                                               const std::optional<std::vector<std::size_t>>& numbers);

/// `options.cache`, with a quarter of r for a spacing that nobody chose.
inline lightmesh::CacheSettings cache_settings_of(const VisibilityOptions& options) {
    lightmesh::CacheSettings settings = options.cache;
    if (settings.spacing == 0.0f)
        settings.spacing = options.settings.radius / 4.0f;
    return settings;
}

/// `options.settings` for a light mesh. Those of the exact short test, the references that others are held
/// against, have no levels, as published.
inline lightmesh::Settings mesh_settings_of(const VisibilityOptions& options) {
    lightmesh::Settings settings = options.settings;
    if (settings.short_test == lightmesh::ShortTest::exact)
        settings.footprint_scale = 0.0f;
    return settings;
}

/// Rays that were traced for what a mesh or a cache keeps, so far; 0 where there is none. `Shadows`: a
/// `Visibility`, or what else has statistics of both.
template <class Shadows>
std::uint64_t kept_rays(const Shadows& shadows) {
    const auto mesh = shadows.mesh();
    const auto cache = shadows.cache();
    return (mesh ? mesh->kept_rays() : 0) + (cache ? cache->kept_rays() : 0);
}

/// A way to find visibility, by the name that the command line knows it by.
struct Algorithm {
    std::string name;
    std::string description;
};

/// True if what an algorithm finds can be saved and be begun with: that of light meshes with long tests by
/// rays, and of the cache of lamps.
bool keeps_snapshot(const std::string& algorithm);

/// cache, blur-cache, whitted, area, shadow-map, shadow-volume; lmm, linked, express, each also with +map and
/// +volume.
const std::vector<Algorithm>& algorithms();

/// Throws std::runtime_error that names the algorithm and lists those there are, and what the algorithm
/// throws for options that do not fit.
std::unique_ptr<Visibility> make_visibility(const std::string& algorithm, const EmbreeScene& scene,
                                            const VisibilityOptions& options);

// The families behind `make_visibility`.

/// One shadow ray per point and facing light.
std::unique_ptr<Visibility> make_hard_shadows(const EmbreeScene& scene,
                                              const VisibilityOptions& options = {});
/// Rays to stratified points of lamps with sizes.
std::unique_ptr<Visibility> make_area_shadows(const EmbreeScene& scene, const VisibilityOptions& options);
/// Hard shadows by a look-up in a shadow map for each light.
std::unique_ptr<Visibility> make_shadow_maps(const EmbreeScene& scene, const VisibilityOptions& options);
/// Hard shadows by shadow volumes.
std::unique_ptr<Visibility> make_shadow_volumes(const EmbreeScene& scene);

/// A light mesh with the short test of options.settings, which also say whether maps are refined.
std::unique_ptr<Visibility> make_light_mesh(const EmbreeScene& scene, const VisibilityOptions& options,
                                            lightmesh::LongTest long_test);

/// Penumbrae of lamps with sizes by a visibility cache.
std::unique_ptr<Visibility> make_cache(const EmbreeScene& scene, const VisibilityOptions& options);
/// The blur of a light mesh by a visibility cache.
std::unique_ptr<Visibility> make_blur_cache(const EmbreeScene& scene, const VisibilityOptions& options);

}  // namespace demo
