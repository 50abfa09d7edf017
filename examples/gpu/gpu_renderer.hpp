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
#include <span>
#include <string>
#include <vector>

namespace demo {

/// A picture that shaders have made.
struct GpuPicture {
    Image linear;                 ///< as `render` gives it
    Image toned;                  ///< by `RenderOptions::tone`
    double seconds_device = 0.0;  ///< of it in shaders
};

/// A part of a picture: pixels by their numbers, row by row.
struct PixelRange {
    std::size_t first;
    std::size_t end;
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

    /// A new frame begins, after `update`: what is over the memory budgets of the options and has gone unused
    /// the longest, as one in some points tells, is forgotten. Pictures do not depend on it, but for the
    /// roundings of the host, which answers where a cache that is full keeps nothing. Throws what
    /// `compute.hpp` throws.
    void begin_frame();

    /// Also counts the rays. What was not rendered when `cancel` was set stays black.
    GpuPicture render(RenderStatistics& statistics, const Progress& progress = {},
                      const std::atomic<bool>* cancel = nullptr);
    /// The same of a part; all else is black.
    GpuPicture render(const PixelRange& part, RenderStatistics& statistics, const Progress& progress = {},
                      const std::atomic<bool>* cancel = nullptr);

    /// Of the light mesh, if there is one.
    std::optional<lightmesh::MeshStatistics> mesh() const;

    /// All that shaders have found of shadows, but for what they find while they shade.
    DeviceFill filled() const;

    /// Of the visibility cache, if there is one.
    std::optional<lightmesh::CacheStatistics> cache() const;

    /// All that the light mesh or the cache knows; nothing where there is none.
    std::vector<std::byte> snapshot() const;
    /// Adds what another one's `snapshot` knows, of the scene as it is here and was there; the device
    /// gets it before the next picture. Throws what the library's `merge` throws.
    void merge(std::span<const std::byte> known);

    /// Of the mesh, the cache, or maps and volumes, on the host.
    std::size_t bytes() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace demo
