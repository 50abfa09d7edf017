// SPDX-License-Identifier: MIT
// must say: lightmesh: the adapter for long tests must be a DepthRenderer, with the member `void
// render_depth(const DepthView&, std::span<float>)`, or Occluders, with the members `std::size_t
// triangle_count() const` and `std::array<glm::vec3, 3> triangle(std::size_t) const`
#include "wrong.hpp"

struct Wrong {};

const lightmesh::LightMesh mesh{Tracer{}, Wrong{}, lights, lightmesh::Settings{}};
