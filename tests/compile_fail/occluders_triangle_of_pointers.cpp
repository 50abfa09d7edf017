// SPDX-License-Identifier: MIT
// must say: lightmesh: the Occluders' triangle must return std::array<glm::vec3, 3>
#include "wrong.hpp"

struct Wrong {
    std::size_t triangle_count() const { return 0; }
    const float* triangle(std::size_t) const { return nullptr; }
};

const lightmesh::LightMesh mesh{Tracer{}, Wrong{}, lights, lightmesh::Settings{}};
