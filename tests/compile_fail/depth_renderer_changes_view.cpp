// SPDX-License-Identifier: MIT
// must say: lightmesh: the DepthRenderer's render_depth must take its view as `const DepthView&`
#include "wrong.hpp"

struct Wrong {
    void render_depth(lightmesh::DepthView&, std::span<float>) {}
};

const lightmesh::LightMesh mesh{Tracer{}, Wrong{}, lights, lightmesh::Settings{}};
