// SPDX-License-Identifier: MIT
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cmath>

namespace demo {

/// Two directions across a third and each other, all of length 1.
inline std::array<glm::vec3, 2> across(const glm::vec3& axis) {
    const glm::vec3 other = std::abs(axis.z) < 0.9f ? glm::vec3(0, 0, 1) : glm::vec3(1, 0, 0);
    const glm::vec3 right = glm::normalize(glm::cross(axis, other));
    return {right, glm::cross(right, axis)};
}

}  // namespace demo
