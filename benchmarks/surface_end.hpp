// SPDX-License-Identifier: MIT
#pragma once

#include <glm/common.hpp>
#include <glm/vec3.hpp>

namespace bench {

/// Where shadow rays start: off the surface by 4e-6 of the largest coordinate, some times its rounding.
inline glm::vec3 surface_end(const glm::vec3& point, const glm::vec3& unit_normal) {
    const glm::vec3 size = glm::abs(point);
    return point + (4e-6f * glm::max(glm::max(size.x, size.y), glm::max(size.z, 1.0f))) * unit_normal;
}

}  // namespace bench
