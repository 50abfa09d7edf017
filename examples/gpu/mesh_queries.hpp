// SPDX-License-Identifier: MIT
#pragma once

#include "compute.hpp"
#include "host_rays.hpp"
#include "uploaded.hpp"

#include <lightmesh/surface_point.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace demo {

/// Queries of a light mesh by the device, for tests and benchmarks: the rays are traced by the host.
class MeshQueries {
public:
    struct Answer : HostRayAnswer {
        std::vector<lightmesh::SurfacePoint> requests;  ///< what `fill` is to be called with
        bool overflowed = false;                        ///< there were more requests than room for them
    };

    explicit MeshQueries(const ComputeDevice& device, std::size_t request_capacity = 65536,
                         std::uint32_t rays_per_point = 512);

    /// Uploads a mesh's snapshot, or what has changed of it since the last time. Returns how many bytes that
    /// were. Throws what `lightmesh::SnapshotView` and `lightmesh::MeshUpload` throw.
    std::size_t upload(std::span<const std::byte> snapshot);

    /// As `HostRayQuery::ask`; by footprints if a point has one.
    Answer ask(std::span<const lightmesh::SurfacePoint> points, const TraceSegments& trace,
               bool is_timed = false);

private:
    ComputeDevice device_;
    std::uint32_t rays_per_point_;
    std::vector<std::byte> no_requests_;
    ComputeBuffer requests_;
    std::optional<UploadedMesh> mesh_;
    std::array<std::optional<ComputeKernel>, 5> kernels_;  ///< of each of the shaders
};

}  // namespace demo
