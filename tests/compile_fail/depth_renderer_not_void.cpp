// SPDX-License-Identifier: MIT
// must say: lightmesh: the DepthRenderer's render_depth must return void: it reports failure by an exception
#include "wrong.hpp"

struct Wrong {
    bool render_depth(const lightmesh::DepthView&, std::span<float>) { return true; }
};

const lightmesh::LightMesh mesh{Tracer{}, Wrong{}, lights, lightmesh::Settings{}};
