// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace demo {

/// Adds the triangles of a polygon to `indices`, which may have notches: ears are cut off one after the
/// other. `corners` number `positions`.
void add_polygon(std::span<const std::uint32_t> corners, const std::vector<glm::dvec3>& positions,
                 std::vector<std::uint32_t>& indices);

}  // namespace demo
