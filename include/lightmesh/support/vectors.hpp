// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/support/rounded.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace lightmesh::detail {

inline bool is_finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

inline bool is_zero(const glm::vec3& v) {
    return v.x == 0.0f && v.y == 0.0f && v.z == 0.0f;
}

/// The greatest of the components' magnitudes.
inline float largest_component(const glm::vec3& v) {
    return (std::max)((std::max)(std::abs(v.x), std::abs(v.y)), std::abs(v.z));
}

/// The vector at length 1, however short or long it is; zero stays zero.
inline glm::vec3 unit_or_zero(const glm::vec3& v) {
    const float largest = largest_component(v);
    return largest > 0.0f ? rounded_unit(v / largest) : glm::vec3(0.0f);
}

/// floor(v), for values that fit; without std::floor, which is a call on targets that lack the instruction.
inline std::int32_t floor_to_int(double v) {
    const auto truncated = static_cast<std::int32_t>(v);
    return truncated - static_cast<std::int32_t>(static_cast<double>(truncated) > v);
}

}  // namespace lightmesh::detail
