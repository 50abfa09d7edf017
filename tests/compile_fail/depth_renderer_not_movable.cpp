// SPDX-License-Identifier: MIT
// must say: lightmesh: the DepthRenderer must be movable or copyable: the library keeps it
#include "wrong.hpp"

struct Wrong {
    Wrong() = default;
    Wrong(Wrong&&) = delete;
    void render_depth(const lightmesh::DepthView&, std::span<float>) {}
};

static_assert(lightmesh::check_depth_renderer<Wrong>());
