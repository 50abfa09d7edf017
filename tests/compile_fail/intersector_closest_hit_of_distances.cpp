// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector's closest_hit must be `std::optional<Hit> closest_hit(const Segment&)
// const`
#include "wrong.hpp"

struct Wrong {
    bool occluded(const lightmesh::Segment&) const { return false; }
    float closest_hit(const lightmesh::Segment&) const { return 1.0f; }
};

const lightmesh::VisibilityCache cache{Wrong{}, lights, lightmesh::CacheSettings{}};
