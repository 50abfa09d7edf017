// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector must be copyable: the mesh keeps a copy
#include "wrong.hpp"

struct Wrong {
    Wrong() = default;
    Wrong(const Wrong&) = delete;
    bool occluded(const lightmesh::Segment&) const { return false; }
};

static_assert(lightmesh::check_intersector<Wrong>());
