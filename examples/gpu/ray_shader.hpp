// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"

#include <cstdint>
#include <span>

namespace demo {

/// A shader that traces rays, compiled for both ways that there are; a `GpuScene` is made for one of them, as
/// its device has ray queries or not.
struct RayShader {
    std::span<const std::uint32_t> by_bvh;
    std::span<const std::uint32_t> by_ray_queries;

    std::span<const std::uint32_t> on(const ComputeDevice& device) const {
        return device.has_ray_queries() ? by_ray_queries : by_bvh;
    }
};

}  // namespace demo
