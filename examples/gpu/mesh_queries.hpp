// SPDX-License-Identifier: MIT
#pragma once

#include "compute.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/surface_point.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace demo {

/// Sets hit[i] to 1 if something lies on segment i, else to 0.
using TraceSegments = std::function<void(std::span<const lightmesh::Segment>, std::span<std::uint8_t> hit)>;

/// Queries of a light mesh by the device, for tests and benchmarks: the rays are traced by the host.
class MeshQueries {
public:
    struct Answer {
        std::vector<float> values;                      ///< a row for each point; NaN: missing
        std::vector<lightmesh::SurfacePoint> requests;  ///< what `fill` is to be called with
        bool overflowed = false;                        ///< there were more requests than room for them
        double seconds = 0.0;                           ///< of the run in which all rays were known
        std::size_t points_without_rays = 0;            ///< that need more than `rays_per_point`
        std::size_t rays = 0;
    };

    explicit MeshQueries(const ComputeDevice& device, std::size_t request_capacity = 65536,
                         std::uint32_t rays_per_point = 24);

    /// Uploads a mesh's snapshot, or what has changed of it since the last time. Returns how many bytes that
    /// were. Throws what `lightmesh::SnapshotView` and `lightmesh::MeshUpload` throw.
    std::size_t upload(std::span<const std::byte> snapshot);

    /// S of all lights at points, without their footprints; no more at a time than fit into 2^27 bytes of
    /// values and of rays. `timed_runs`: then asks so many times more, with all rays known, and adds up
    /// instead of writing what it finds; the least time of these counts.
    Answer ask(std::span<const lightmesh::SurfacePoint> points, const TraceSegments& trace,
               int timed_runs = 0);

private:
    struct Batch;

    ComputeDevice device_;
    std::size_t request_capacity_;
    std::uint32_t rays_per_point_;
    std::size_t light_count_ = 0;
    std::optional<lightmesh::MeshUpload> upload_;
    std::vector<ComputeBuffer> buffers_;
    std::optional<ComputeBuffer> requests_;
    std::array<std::optional<ComputeKernel>, 2> kernels_;  ///< for q up to 4, and up to 16
};

}  // namespace demo
