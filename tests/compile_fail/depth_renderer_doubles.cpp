// SPDX-License-Identifier: MIT
// must say: lightmesh: the DepthRenderer's render_depth must take its distances as `std::span<float>`
#include "wrong.hpp"

struct Wrong {
    void render_depth(const lightmesh::DepthView&, std::span<double>) {}
};

const lightmesh::LightMesh mesh{Tracer{}, Wrong{}, lights, lightmesh::Settings{}};
