// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector's occluded must return bool: true if the segment is blocked
#include "wrong.hpp"

struct Wrong {
    float occluded(const lightmesh::Segment&) const { return 1.0f; }
};

const lightmesh::LightMesh mesh{Wrong{}, lights, lightmesh::Settings{}};
