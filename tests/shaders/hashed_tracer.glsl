// SPDX-License-Identifier: MIT

// A tracer that goes by the bits of a ray's ends: hashed_tracer.hpp has the same.

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
