// SPDX-License-Identifier: MIT
// must say: lightmesh: the DepthRenderer's bounds must be `lightmesh::Bounds bounds() const`
#include "wrong.hpp"

struct Wrong {
    void render_depth(const lightmesh::DepthView&, std::span<float>) {}
    lightmesh::Bounds bounds() { return {}; }
};

const lightmesh::LightMesh mesh{Tracer{}, Wrong{}, lights, lightmesh::Settings{}};
