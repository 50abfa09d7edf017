// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "gpu/gpu_scene.hpp"
#include "gpu/long_tests.hpp"
#include "render/embree_scene.hpp"
#include "render/visibility.hpp"
#include "scene/scene_change.hpp"

#include <lightmesh/statistics.hpp>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace demo {

/// The levels of a light mesh on a device: each a mesh of its own, of radius 2^k r. As shaders ask for it the
/// host lists what is missing and links light points; shaders trace the long tests.
class MeshLevels {
public:
    /// Descriptor set where shaders see a level and the request buffer.
    static constexpr std::uint32_t set = 1;

    MeshLevels(const ComputeDevice& device, const EmbreeScene& scene, const GpuScene& copy,
               const VisibilityOptions& options);
    ~MeshLevels();
    MeshLevels(const MeshLevels&) = delete;
    MeshLevels& operator=(const MeshLevels&) = delete;

    /// After the scene that this was made for has changed, not into another one, and `scene` and `copy` were
    /// updated: forgets what is not true any more.
    void update(const SceneChange& change);

    /// Bindings for kernels: placeholders, until `bind`.
    std::vector<ComputeBinding> bindings() const;
    /// Lets a kernel see a level, and empties the request buffer.
    void bind(const ComputeKernel& kernel, int level);
    enum class Asked { nothing, points, same_points };

    /// Fills a level where shaders have asked for it, and uploads what is new. Says whether they did, or
    /// asked what they had asked before the last `fill`: rays along an edge may be blocked for the device and
    /// open for the host, which then does not know that there is something to fill. Throws `Cancelled`, and
    /// what `compute.hpp` throws; levels then keep what they had.
    Asked fill(int level, const std::atomic<bool>* cancel);

    /// Of all levels, as if they were one mesh.
    lightmesh::MeshStatistics statistics() const;
    /// By shaders.
    const DeviceFill& spent() const { return long_tests_.spent(); }

private:
    struct Level;
    Level& at(int level);

    ComputeDevice device_;
    const EmbreeScene& scene_;
    VisibilityOptions options_;
    LongTests long_tests_;
    std::vector<std::unique_ptr<Level>> levels_;  ///< null: not asked for so far
    ComputeBuffer nothing_;
    ComputeBuffer requests_;
    std::vector<std::array<float, 6>> asked_before_;  ///< positions and normals, sorted
};

}  // namespace demo
