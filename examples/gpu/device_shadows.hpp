// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "render/embree_scene.hpp"
#include "scene/scene_change.hpp"

#include <lightmesh/statistics.hpp>
#include <lightmesh/surface_point.hpp>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace demo {

/// A round of a batch of pixels: of each at most one point waits to be shaded.
class Round {
public:
    struct Points {
        std::vector<lightmesh::SurfacePoint> points;
        std::vector<std::uint32_t> pixels;  ///< of the batch, which have them
    };
    /// Of every so many pixels those that have one.
    virtual Points points(std::uint32_t of_pixels = 1) const = 0;

    /// The kernel that shades them.
    virtual const ComputeKernel& kernel() const = 0;
    /// Runs it. Of a light mesh it asks at points that are so many roundings farther from their surfaces.
    virtual void shade(std::uint32_t roundings = 0) = 0;

    /// For kernels that see the same buffers: their push constants, and how many groups there are.
    virtual std::span<const std::byte> push() const = 0;
    virtual std::uint32_t groups() const = 0;

protected:
    ~Round() = default;
};

/// Shadows that the host has a hand in: shading waits for it, round by round.
class DeviceShadows {
public:
    /// Descriptor set where shaders see what they are found by.
    static constexpr std::uint32_t set = 1;

    virtual ~DeviceShadows() = default;

    /// What the shading kernel is made with; `shade` binds what has changed since.
    virtual std::vector<ComputeBinding> bindings() const = 0;

    /// Shades the points of a round. Throws `Cancelled`, and what `compute.hpp` throws; what was found before
    /// is kept.
    virtual void shade(Round& round, const std::atomic<bool>* cancel) = 0;

    /// After the scene that this was made for has changed, not into another one, and `scene` and its copy on
    /// the device were updated: forgets what is not true any more.
    virtual void update(const EmbreeScene& scene, const SceneChange& change) = 0;

    /// A new frame begins: what is over the memory budget of a mesh or a cache and has gone unused the
    /// longest is forgotten.
    virtual void begin_frame() {}

    /// Adds what another one's `snapshot` knows, of the scene as it is here and was there. Throws what the
    /// library's `merge` throws.
    virtual void merge(std::span<const std::byte> /*known*/) {}
    /// All that a mesh or a cache knows.
    virtual std::vector<std::byte> snapshot() const { return {}; }

    virtual std::optional<lightmesh::MeshStatistics> mesh() const { return std::nullopt; }
    virtual std::optional<lightmesh::CacheStatistics> cache() const { return std::nullopt; }
    /// On the host.
    virtual std::size_t bytes() const = 0;
    /// By shaders, but for shading.
    virtual DeviceFill spent() const { return {}; }
};

}  // namespace demo
