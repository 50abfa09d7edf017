// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/gpu_scene.hpp"

#include <lightmesh/segment.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace demo {

/// Lists of rays by shaders through a scene, for tests and benchmarks of it.
class GpuRays {
public:
    /// The surface that a segment meets first: t from 0 to 1 along it, weights of the triangle's second and
    /// third vertex.
    struct Closest {
        std::uint32_t triangle;  ///< the scene's number; ~0: none
        float t, u, v;
    };

    GpuRays(const ComputeDevice& device, const GpuScene& scene);

    std::vector<Closest> closest(std::span<const lightmesh::Segment> segments);
    /// The shares of light that pass, as `EmbreeIntersector::let_through`.
    std::vector<float> let_through(std::span<const lightmesh::Segment> segments);

    /// From now on lists are asked again and again: see `ComputeDevice::least_time`.
    void begin_timing() { is_timed_ = true; }
    /// The time that the device took for the last list.
    double seconds() const { return seconds_; }

private:
    std::vector<Closest> run(const ComputeKernel& kernel, std::span<const lightmesh::Segment> segments);

    ComputeDevice device_;
    ComputeKernel closest_;
    ComputeKernel occluded_;
    bool is_timed_ = false;
    double seconds_ = 0.0;
};

}  // namespace demo
