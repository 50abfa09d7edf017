// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "gpu/gpu_scene.hpp"
#include "render/embree_scene.hpp"
#include "render/visibility.hpp"
#include "scene/scene_change.hpp"

#include <lightmesh/statistics.hpp>
#include <lightmesh/surface_point.hpp>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace demo {

/// A visibility cache on a device. As shaders ask for it the host finds the places of records and lists what
/// they lack; shaders trace the rays to lamps. Where these are of no record, the host answers for the point.
/// What records say by a light mesh the host finds.
class CacheShadows {
public:
    /// Descriptor set where shaders see the cache, the request buffer and the host's answers.
    static constexpr std::uint32_t set = 1;

    /// `algorithm`: cache or blur-cache. For batches of up to so many pixels. What the options know the cache
    /// begins with.
    CacheShadows(const ComputeDevice& device, const std::string& algorithm, const EmbreeScene& scene,
                 const GpuScene& copy, const VisibilityOptions& options, std::size_t pixels);
    ~CacheShadows();
    CacheShadows(const CacheShadows&) = delete;
    CacheShadows& operator=(const CacheShadows&) = delete;

    /// After the scene that this was made for has changed, not into another one, and `scene` and `copy` were
    /// updated: forgets what is not true any more.
    void update(const EmbreeScene& scene, const SceneChange& change);

    /// A new frame begins: what is over the memory budget of the options and has gone unused the longest is
    /// forgotten. Used is what was found since, and what points take that the host was told of.
    void begin_frame();
    /// True if the options have a memory budget.
    bool has_budget() const;
    /// Tells the host of points at which shaders have what they take. Throws as `fill`.
    void note_use(std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel);
    /// Adds what another one's `snapshot` knows, of the scene as it is here and was there. Throws what the
    /// library's `merge` throws.
    void merge(std::span<const std::byte> known);

    std::vector<ComputeBinding> bindings() const;
    /// Forgets the host's answers: the pixels have other points now.
    void begin_round();
    /// Uploads what has changed between pictures, lets a kernel see the cache as it is, and empties the
    /// request buffer.
    void bind(const ComputeKernel& kernel) const;
    /// Finds what shaders have asked for, and uploads it. False if nothing was asked. Throws `Cancelled`, and
    /// what `compute.hpp` throws; the cache then keeps what it had.
    bool fill(const std::atomic<bool>* cancel);

    lightmesh::CacheStatistics statistics() const;
    /// By shaders.
    DeviceFill spent() const;
    /// All that the cache knows.
    std::vector<std::byte> snapshot() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace demo
