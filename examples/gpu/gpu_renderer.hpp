// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "image/image.hpp"
#include "render/embree_scene.hpp"
#include "render/renderer.hpp"
#include "render/visibility.hpp"
#include "scene/scene_change.hpp"

#include <lightmesh/statistics.hpp>

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace demo {

/// A picture that shaders have made.
struct GpuPicture {
    Image linear;                 ///< as `render` gives it
    Image toned;                  ///< by `RenderOptions::tone`
    double seconds_device = 0.0;  ///< of it in shaders
};

/// Whole pictures by compute shaders: rays through a BVH of Embree's builder, shading as renderer.cpp does
/// it, shadows by one of `algorithms()`. The pictures are those of `render`, but for the rounding of another
/// processor.
class GpuRenderer {
public:
    /// Names of the algorithms that there are shaders for.
    static const std::vector<std::string>& algorithms();

    /// Throws std::invalid_argument that names the option for what there are no shaders for.
    static void check(const std::string& algorithm, const VisibilityOptions& visibility,
                      const RenderOptions& options);

    /// Copies the scene to the device; the scene must outlive this. Throws as `check`, and what `compute.hpp`
    /// throws.
    GpuRenderer(const ComputeDevice& device, const std::string& algorithm, const EmbreeScene& scene,
                const VisibilityOptions& visibility, const RenderOptions& options);
    GpuRenderer(const GpuRenderer&) = delete;
    GpuRenderer& operator=(const GpuRenderer&) = delete;
    ~GpuRenderer();

    /// After the scene has changed, not into another one, and the `EmbreeScene` was updated: renders from now
    /// on what a new one would. Throws what `compute.hpp` throws.
    void update(const EmbreeScene& scene, const SceneChange& change);

    /// Also counts the rays. What was not rendered when `cancel` was set stays black.
    GpuPicture render(RenderStatistics& statistics, const Progress& progress = {},
                      const std::atomic<bool>* cancel = nullptr);

    /// Of the light mesh, if there is one.
    std::optional<lightmesh::MeshStatistics> mesh() const;

    /// All that shaders have found for the light mesh or the cache.
    DeviceFill filled() const;

    /// Of the visibility cache, if there is one.
    std::optional<lightmesh::CacheStatistics> cache() const;

    /// All that the light mesh or the cache knows; nothing where there is none.
    std::vector<std::byte> snapshot() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace demo
