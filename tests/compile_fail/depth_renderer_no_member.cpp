// SPDX-License-Identifier: MIT
// must say: lightmesh: the DepthRenderer lacks the member `void render_depth(const DepthView&,
// std::span<float>)`
#include "wrong.hpp"

struct Wrong {
    void draw_depth(const lightmesh::DepthView&, std::span<float>) {}
};

static_assert(lightmesh::check_depth_renderer<Wrong>());
