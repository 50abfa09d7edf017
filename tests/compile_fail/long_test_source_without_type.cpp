// SPDX-License-Identifier: MIT
// must say: lightmesh: `LightMesh<Tracer>` finds long tests by rays, and with an adapter for them write
// `LightMesh<Tracer, Source>`, or no arguments of the template at all
#include "wrong.hpp"

struct Triangles {
    std::size_t triangle_count() const { return 0; }
    std::array<glm::vec3, 3> triangle(std::size_t) const { return {}; }
};

const lightmesh::LightMesh<Tracer> mesh{Tracer{}, Triangles{}, lights, lightmesh::Settings{}};
