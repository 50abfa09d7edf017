// SPDX-License-Identifier: MIT
#pragma once

#include "compute.hpp"
#include "mesh_queries.hpp"

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
    struct Answer {
        std::vector<float> values;                      ///< a row for each point; NaN: not known
        std::vector<lightmesh::CacheRequest> requests;  ///< their ids are the numbers of points
        std::size_t asked = 0;                          ///< points that asked, also without room for them
        double seconds = 0.0;                           ///< of the run in which all rays were known
        std::size_t points_without_rays = 0;            ///< that need more than `rays_per_point`
        std::size_t rays = 0;
    };

    explicit CacheQueries(const ComputeDevice& device, std::uint32_t rays_per_point = 48);

    /// Uploads a cache's snapshot. Returns how many bytes that were. Throws what `lightmesh::SnapshotView`
    /// and `lightmesh::CacheUpload` throw; then what was uploaded before stays.
    std::size_t upload(std::span<const std::byte> snapshot);

    /// S of all lights at points, no more at a time than fit into 2^27 bytes of values and of rays.
    /// `timed_runs`: then asks so many times more, with all rays known, and adds up instead of writing what
    /// it finds; the least time of these counts.
    Answer ask(std::span<const lightmesh::SurfacePoint> points, const TraceSegments& trace,
               int timed_runs = 0, std::size_t request_capacity = 65536);

private:
    struct Batch;

    ComputeDevice device_;
    std::uint32_t rays_per_point_;
    std::size_t light_count_ = 0;
    std::vector<ComputeBuffer> buffers_;
    std::optional<ComputeKernel> kernel_;
};

}  // namespace demo
