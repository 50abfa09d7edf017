// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector's occluded must take its segment as `const Segment&`
#include "wrong.hpp"

struct Wrong {
    bool occluded(lightmesh::Segment&) const { return false; }
};

const lightmesh::LightMesh mesh{Wrong{}, lights, lightmesh::Settings{}};
