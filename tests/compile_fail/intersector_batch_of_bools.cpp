// SPDX-License-Identifier: MIT
// must say: lightmesh: the Intersector's occluded for many segments must be `void occluded(std::span<const
// Segment>, std::span<std::uint8_t>) const`
#include "wrong.hpp"

struct Wrong {
    bool occluded(const lightmesh::Segment&) const { return false; }
    void occluded(std::span<const lightmesh::Segment>, std::span<bool>) const {}
};

const lightmesh::LightMesh mesh{Wrong{}, lights, lightmesh::Settings{}};
