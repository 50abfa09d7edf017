// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "shading_points.hpp"

#include <lightmesh/surface_point.hpp>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

/// What benchmarks of shaders have in common.

namespace bench {

/// The main function of NAME [--device DEVICE]. `run` returns whether all is right.
int run_on_device(const char* name, int argc, char** argv,
                  const std::function<bool(const demo::ComputeDevice&)>& run);

/// All points, tile by tile.
std::vector<lightmesh::SurfacePoint> surface_points(const ShadingPoints& points);

/// S of all lights of a mesh or a cache, on all threads.
template <class Subject>
std::vector<float> ask_on_cpu(const Subject& subject, std::span<const lightmesh::SurfacePoint> points) {
    constexpr std::size_t block = 1024;
    const std::size_t lights = subject.light_count();
    std::vector<float> all(points.size() * lights);
    tbb::parallel_for(std::size_t{0}, (points.size() + block - 1) / block, [&](std::size_t b) {
        const std::size_t first = b * block;
        const std::size_t size = (std::min)(block, points.size() - first);
        subject.visibility(points.subspan(first, size),
                           std::span(all).subspan(first * lights, size * lights));
    });
    return all;
}

inline bool same_bits(float a, float b) {
    return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

}  // namespace bench
