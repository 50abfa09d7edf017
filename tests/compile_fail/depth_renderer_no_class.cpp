// SPDX-License-Identifier: MIT
// must say: lightmesh: the DepthRenderer must be a class with a member `void render_depth(const DepthView&,
// std::span<float>)`
#include "wrong.hpp"

using Wrong = int;

static_assert(lightmesh::check_depth_renderer<Wrong>());
