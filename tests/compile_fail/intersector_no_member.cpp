// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector lacks the member `bool occluded(const Segment&) const`
#include "wrong.hpp"

struct Wrong {
    bool is_blocked(const lightmesh::Segment&) const { return false; }
};

const lightmesh::LightMesh mesh{Wrong{}, lights, lightmesh::Settings{}};
