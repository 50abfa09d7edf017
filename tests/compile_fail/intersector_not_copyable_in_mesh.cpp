// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector must be copyable: the mesh keeps a copy
#include "wrong.hpp"

struct Wrong {
    Wrong() = default;
    Wrong(Wrong&&) = default;
    bool occluded(const lightmesh::Segment&) const { return false; }
};

const lightmesh::LightMesh mesh{Wrong{}, lights, lightmesh::Settings{}};
