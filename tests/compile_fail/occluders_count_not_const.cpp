// SPDX-License-Identifier: MIT
// must say: lightmesh: the Occluders' triangle_count must be const and return std::size_t
#include "wrong.hpp"

struct Wrong {
    std::size_t triangle_count() { return 0; }
    std::array<glm::vec3, 3> triangle(std::size_t) const { return {}; }
};

const lightmesh::LightMesh mesh{Tracer{}, Wrong{}, lights, lightmesh::Settings{}};
