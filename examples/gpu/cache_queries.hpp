// SPDX-License-Identifier: MIT
#pragma once

#include "compute.hpp"
#include "host_rays.hpp"
#include "uploaded.hpp"

#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/surface_point.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace demo {

/// Queries of a visibility cache by the device, for tests and benchmarks: the rays are traced by the host.
class CacheQueries {
public:
    struct Answer : HostRayAnswer {
        std::vector<lightmesh::CacheRequest> requests;  ///< their ids are the numbers of points
        std::size_t asked = 0;                          ///< points that asked, also without room for them
    };

    explicit CacheQueries(const ComputeDevice& device, std::uint32_t rays_per_point = 48);

    /// Uploads a cache's snapshot, or what has changed of it since the last time. Returns how many bytes that
    /// were. Throws what `lightmesh::SnapshotView` and `lightmesh::CacheUpload` throw; then what was uploaded
    /// before stays.
    std::size_t upload(std::span<const std::byte> snapshot);

    /// As `HostRayQuery::ask`.
    Answer ask(std::span<const lightmesh::SurfacePoint> points, const TraceSegments& trace,
               bool is_timed = false, std::size_t request_capacity = 65536);

private:
    ComputeDevice device_;
    std::uint32_t rays_per_point_;
    std::optional<UploadedCache> cache_;
    std::optional<ComputeKernel> kernel_;
};

}  // namespace demo
