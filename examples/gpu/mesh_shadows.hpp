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
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace demo {

/// A light mesh on a device. As shaders ask for it the host lists what is missing; shaders trace links and
/// long tests. Where these are not by rays, the host finds them, and the links.
class MeshShadows {
public:
    /// Descriptor set where shaders see the mesh and the request buffer.
    static constexpr std::uint32_t set = 1;

    /// `algorithm`: one with a mesh; the short test is that of the options. What they know the mesh begins
    /// with.
    MeshShadows(const ComputeDevice& device, const std::string& algorithm, const EmbreeScene& scene,
                const GpuScene& copy, const VisibilityOptions& options);
    ~MeshShadows();
    MeshShadows(const MeshShadows&) = delete;
    MeshShadows& operator=(const MeshShadows&) = delete;

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
    /// Uploads what has changed between pictures, lets a kernel see the mesh as it is, and empties the
    /// request buffer.
    void bind(const ComputeKernel& kernel) const;
    enum class Asked { nothing, points, same_points };

    /// Fills the mesh where shaders have asked for it, and uploads what is new. Says whether they did, or
    /// asked what they had asked before the last `fill`: rays along an edge may be blocked for the device and
    /// open for the host, which then does not know that there is something to fill. Throws `Cancelled`, and
    /// what `compute.hpp` throws; the mesh then keeps what it had.
    Asked fill(const std::atomic<bool>* cancel);

    lightmesh::MeshStatistics statistics() const;
    /// By shaders.
    DeviceFill spent() const;
    /// All that the mesh knows.
    std::vector<std::byte> snapshot() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace demo
