// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <lightmesh/bounds.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace demo {

using lightmesh::Bounds;

/// The box around two others.
inline Bounds common(const Bounds& a, const Bounds& b) {
    return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

/// The box around at least one point.
inline Bounds around(std::span<const glm::vec3> points) {
    Bounds box{points[0], points[0]};
    for (const glm::vec3& point : points)
        box = common(box, {point, point});
    return box;
}

inline glm::vec3 centre_of(const Bounds& box) {
    return 0.5f * (box.low + box.high);
}

inline float diagonal_of(const Bounds& box) {
    return glm::length(box.high - box.low);
}

/// The corners of a triangle, where it lies.
inline std::array<glm::vec3, 3> corners_of(const Scene& scene, const Triangle& triangle) {
    std::array<glm::vec3, 3> corners;
    for (std::size_t i = 0; i < 3; ++i)
        corners[i] = scene.positions[triangle.vertex[i]];
    return corners;
}

/// A box around what lies in a box of the instance's part.
Bounds placed(const Instance& instance, const Bounds& box);

/// The boxes around the vertices of each part.
std::vector<Bounds> boxes_of_parts(const Scene& scene);

/// The box around all that is drawn; of no size, at 0, if nothing is.
Bounds bounds_of(const Scene& scene);

}  // namespace demo
