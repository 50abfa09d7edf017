// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/support/rounded.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <cmath>

/// The ends of segments: off the surface they leave, and short of the light they reach. Both bounds
/// follow the size of the coordinates, since the rounding of an intersection point does (Waechter and Binder,
/// "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems ch. 6), and the step of the
/// grid, below which a light mesh sees nothing. Ends at light points need neither.

namespace lightmesh::detail {

/// Length by which the end of a segment at `point` is moved: |point|_inf * 2^-19 + step * 2^-11. World units.
inline float end_offset(const glm::vec3& point, float step) {
    return largest_component(point) * 0x1p-19f + step * 0x1p-11f;
}

/// The surface end of a segment: `point` moved along its unit normal.
inline glm::vec3 surface_end(const glm::vec3& point, const glm::vec3& unit_normal, float step) {
    return point + rounded(end_offset(point, step) * unit_normal);
}

/// The light's end of a segment: `light` moved towards `other`, at most half of the way.
inline glm::vec3 light_end(const glm::vec3& light, const glm::vec3& other, float step) {
    const glm::vec3 offset_to_other = other - light;
    const float distance = std::sqrt(rounded_dot(offset_to_other, offset_to_other));
    const float offset = end_offset(light, step);
    return distance > 2.0f * offset ? light + rounded(offset_to_other * (offset / distance))
                                    : light + 0.5f * offset_to_other;
}

}  // namespace lightmesh::detail
