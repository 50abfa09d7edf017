#version 450
// SPDX-License-Identifier: MIT

// Shares of lamps by a tracer that goes by the bits of a ray's ends: gpu_shares_test.cpp has the same.

#extension GL_GOOGLE_include_directive : require

layout(local_size_x = 64) in;

#include <lightmesh/gpu/lamp_shares.glsl>

layout(push_constant) uniform Batch {
    uint first;
}
batch;

uint mixed(uint hash, uint value) {
    hash = (hash ^ value) * 0x9e3779b1u;
    return hash ^ hash >> 15;
}

uint mixed(uint hash, vec3 place) {
    for (int axis = 0; axis < 3; ++axis)
        hash = mixed(hash, place[axis] == 0.0 ? 0u : floatBitsToUint(place[axis]));
    return hash;
}

// All open, all closed, half of them, and nearly all open: from one half of a cube or the other.
bool lightmesh_is_open(vec3 from, vec3 to) {
    uint hash = mixed(mixed(1u, from), to) >> 8;
    uint kind = mixed(2u, floor(2.0 * from)) >> 8 & 7u;
    return kind < 2u || (kind >= 4u && (kind < 6u ? (hash & 1u) != 0u : (hash & 31u) != 0u));
}

void main() {
    lightmesh_find_lamp_shares(batch.first);
}
