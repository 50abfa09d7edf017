// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/device_fill.hpp"
#include "render/visibility.hpp"

#include <lightmesh/surface_point.hpp>

#include <glm/vec3.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace demo {

/// Asks the host on all threads how lit points are, and hands what each thread has found to
/// take(number of the first of its points, row-major: a row of all lights at each). What the shadows keep of
/// it, shaders can then be told. Throws `Cancelled`.
template <class Take>
void ask_host(const Visibility& shadows, std::size_t light_count,
              std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel, Take&& take) {
    constexpr std::size_t at_once = 256;
    const auto ask_part = [&](const tbb::blocked_range<std::size_t>& part) {
        check_cancelled(cancel);
        std::vector<glm::vec3> positions, normals, shading_normals;
        std::vector<float> footprints;
        for (std::size_t i = part.begin(); i < part.end(); ++i) {
            positions.push_back(points[i].position);
            normals.push_back(points[i].normal);
            shading_normals.push_back(points[i].shading_normal);
            footprints.push_back(points[i].footprint);
        }
        const std::vector<std::uint32_t> seeds(part.size());
        std::vector<float> lit(part.size() * light_count);
        VisibilityCost cost;
        shadows.find({positions, normals, seeds, shading_normals, footprints}, lit, cost);
        take(part.begin(), std::span<const float>(lit));
    };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), at_once), ask_part);
}

}  // namespace demo
