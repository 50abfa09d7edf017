// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector's closest_hit must be `std::optional<Hit> closest_hit(const Segment&)
// const`
#include "wrong.hpp"

#include <optional>

struct Wrong {
    bool occluded(const lightmesh::Segment&) const { return false; }
    std::optional<lightmesh::Hit> closest_hit(const lightmesh::Segment&) { return std::nullopt; }
};

static_assert(lightmesh::check_intersector<Wrong>());
