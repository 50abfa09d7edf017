// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "gpu/gpu_scene.hpp"

#include <lightmesh/segment.hpp>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>

namespace demo {

/// Segments by shaders through a scene: a `SegmentTracer`, for any number of threads. They take
/// turns.
class SegmentRays {
public:
    SegmentRays(const ComputeDevice& device, const GpuScene& scene);

    /// Throws `Cancelled` between two dispatches if that is set, and what `compute.hpp` throws.
    void operator()(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit,
                    const std::atomic<bool>* cancel);

    DeviceFill spent() const;

private:
    ComputeDevice device_;
    std::size_t at_once_;  ///< segments
    ComputeBuffer segments_;
    ComputeBuffer blocked_;
    ComputeKernel kernel_;
    mutable std::mutex busy_;
    DeviceFill spent_;
};

}  // namespace demo
