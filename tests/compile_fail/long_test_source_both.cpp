// SPDX-License-Identifier: MIT
// must say: lightmesh: the adapter for long tests must be either a DepthRenderer, for shadow maps, or
// Occluders, for shadow volumes: it has render_depth and triangles as well
#include "wrong.hpp"

struct Wrong {
    void render_depth(const lightmesh::DepthView&, std::span<float>) {}
    std::size_t triangle_count() const { return 0; }
    std::array<glm::vec3, 3> triangle(std::size_t) const { return {}; }
};

const lightmesh::LightMesh mesh{Tracer{}, Wrong{}, lights, lightmesh::Settings{}};
