// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector lacks the member `bool occluded(const Segment&) const`
#include "wrong.hpp"

constexpr auto wrong = [](const lightmesh::Segment&) {
    return false;
};
using Wrong = decltype(wrong);

static_assert(lightmesh::check_intersector<Wrong>());
