// SPDX-License-Identifier: MIT
// must say: lightmesh: the Occluders must be a class with the members `std::size_t triangle_count() const`
// and `std::array<glm::vec3, 3> triangle(std::size_t) const`
#include "wrong.hpp"

using Wrong = int;

static_assert(lightmesh::check_occluders<Wrong>());
