// SPDX-License-Identifier: MIT
#pragma once

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <cstddef>

/// The six faces of a cube around a light, of a quarter of a turn each: +x, -x, +y, -y, +z, -z.

namespace lightmesh::detail {

inline constexpr std::size_t cube_face_count = 6;

/// From the centre of the cube to that of a face; of length 1.
inline glm::vec3 cube_face_axis(std::size_t face) {
    glm::vec3 axis(0.0f);
    axis[static_cast<int>(face / 2)] = face % 2 == 0 ? 1.0f : -1.0f;
    return axis;
}

/// The face that a direction of any length passes through: that of its largest component, of equal ones the
/// first.
template <class Vector>
std::size_t cube_face_of(const Vector& direction) {
    const Vector size = glm::abs(direction);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    return static_cast<std::size_t>(2 * axis + (direction[axis] < 0 ? 1 : 0));
}

}  // namespace lightmesh::detail
