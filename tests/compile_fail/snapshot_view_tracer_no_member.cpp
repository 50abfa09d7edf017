// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector lacks the member `bool occluded(const Segment&) const`
#include "wrong.hpp"

struct Wrong {};

void ask(const lightmesh::SnapshotView& view, std::span<float> all) {
    view.visibility(Wrong{}, lightmesh::SurfacePoint{}, all);
}
