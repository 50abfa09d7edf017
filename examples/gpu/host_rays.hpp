// SPDX-License-Identifier: MIT
#pragma once

#include "compute.hpp"

#include <lightmesh/segment.hpp>
#include <lightmesh/surface_point.hpp>

#include <tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace demo {

/// Sets hit[i] to 1 if something lies on segment i, else to 0.
using TraceSegments = std::function<void(std::span<const lightmesh::Segment>, std::span<std::uint8_t> hit)>;

/// Segment by segment, on all threads.
template <class Tracer>
TraceSegments trace_by(Tracer tracer) {
    return [tracer](std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) {
        tbb::parallel_for(std::size_t{0}, segments.size(),
                          [&](std::size_t i) { hit[i] = tracer.occluded(segments[i]) ? 1 : 0; });
    };
}

/// A device's answer about points, by rays that the host traced.
struct HostRayAnswer {
    std::vector<float> values;            ///< a row for each point; NaN: not known
    double seconds = 0.0;                 ///< of a run in which all rays are known
    std::size_t points_without_rays = 0;  ///< that need more than `rays_per_point`
    std::size_t rays = 0;
};

/// Queries by a shader that includes host_rays.glsl, for tests and benchmarks.
struct HostRayQuery {
    std::span<const std::uint32_t> shader;
    std::optional<ComputeKernel>& kernel;  ///< made of `shader` when it is asked for the first time
    std::vector<ComputeBinding> bindings;  ///< of set 0
    ComputeBuffer requests;                ///< one of these
    std::span<const std::byte> no_requests;
    std::size_t light_count;
    std::uint32_t rays_per_point;

    /// Gets the bytes of the request buffer, and which points the numbers in it are of.
    using TakeRequests =
        std::function<void(std::span<const std::uint32_t> points, std::span<const std::byte> requests)>;

    /// S of all lights at points, no more at a time than fit into 2^27 bytes of values and of rays. First
    /// with room for few rays a point; those that need more are asked again with all the room.
    /// `is_timed`: then asks again and again, all points at once, with all rays known, and adds up instead of
    /// writing what it finds: see `ComputeDevice::least_time`.
    HostRayAnswer ask(const ComputeDevice& device, std::span<const lightmesh::SurfacePoint> points,
                      const TraceSegments& trace, bool is_timed, const TakeRequests& take_requests) const;
};

}  // namespace demo
