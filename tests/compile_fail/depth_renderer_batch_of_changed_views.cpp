// SPDX-License-Identifier: MIT
// must say: lightmesh: the DepthRenderer's render_depth for many views must be `void
// render_depth(std::span<const DepthView>, std::span<const std::span<float>>)`
#include "wrong.hpp"

struct Wrong {
    void render_depth(const lightmesh::DepthView&, std::span<float>) {}
    void render_depth(std::span<lightmesh::DepthView>, std::span<std::span<float>>) {}
};

const lightmesh::LightMesh mesh{Tracer{}, Wrong{}, lights, lightmesh::Settings{}};
