// SPDX-License-Identifier: MIT
// must say: lightmesh: the DepthRenderer lacks the member `void render_depth(const DepthView&,
// std::span<float>)`
#include "wrong.hpp"

struct Wrong {};

const lightmesh::ShadowMap map{Wrong{}, lights[0], lightmesh::ShadowMapSettings{}};
