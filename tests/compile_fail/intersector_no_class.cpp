// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector must be a class with a member `bool occluded(const Segment&) const`
#include "wrong.hpp"

using Wrong = int;

const lightmesh::LightMesh mesh{Wrong{}, lights, lightmesh::Settings{}};
