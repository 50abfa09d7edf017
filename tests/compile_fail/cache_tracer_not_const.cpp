// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector's occluded must be const: many threads call it at once
#include "wrong.hpp"

struct Wrong {
    bool occluded(const lightmesh::Segment&) { return false; }
};

const lightmesh::VisibilityCache cache{Wrong{}, lights, lightmesh::CacheSettings{}};
