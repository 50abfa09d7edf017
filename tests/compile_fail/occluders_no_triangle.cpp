// SPDX-License-Identifier: MIT
// must say: lightmesh: the Occluders lack the member `std::array<glm::vec3, 3> triangle(std::size_t) const`
#include "wrong.hpp"

struct Wrong {
    std::size_t triangle_count() const { return 0; }
};

const lightmesh::LightMesh mesh{Tracer{}, Wrong{}, lights, lightmesh::Settings{}};
