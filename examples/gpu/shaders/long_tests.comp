#version 450
// SPDX-License-Identifier: MIT

// Long tests of a light mesh that the host lists: 16 lanes trace the light points of a word, each one in turn.

#extension GL_GOOGLE_include_directive : require
#define BVH_OPEN
#include "scene.glsl"
#include "bvh.glsl"

#define LIGHTMESH_SET 1
#define LIGHTMESH_BINDING 0
#include <lightmesh/gpu/lightmesh.glsl>

layout(push_constant) uniform Batch {
    uint count;
}
batch;

// As `LongTestWord`: the brick and the light's number; its place, the level and the light points.
struct Word {
    ivec3 brick;
    uint light;
    uint light_slot;
    uint level;
    uvec2 points;
};
layout(std430, set = 2, binding = 0) readonly buffer Words {
    Word words[];
};
layout(std430, set = 2, binding = 1) writeonly buffer Seen {
    uvec2 seen[];
};

const uint lanes = 16u;

layout(local_size_x = 64) in;

shared uint found[8];

bool lightmesh_is_open(vec3 from, vec3 to) {
    return is_open(from, to);
}

uint size_of(uvec2 bits) {
    return uint(bitCount(bits.x) + bitCount(bits.y));
}

// The place of the n-th bit that is set, of more than n.
uint place_of(uvec2 bits, uint n) {
    uint below = uint(bitCount(bits.x));
    bool is_high = n >= below;
    uint word = is_high ? bits.y : bits.x;
    uint rest = is_high ? n - below : n;
    uint place = 0u;
    for (uint size = 16u; size != 0u; size >>= 1) {
        uint count = uint(bitCount(word >> place & (1u << size) - 1u));
        if (rest >= count) {
            rest -= count;
            place += size;
        }
    }
    return place + (is_high ? 32u : 0u);
}

void main() {
    uint lane = gl_LocalInvocationID.x % lanes;
    uint of_group = gl_LocalInvocationID.x / lanes;
    uint i = 64u / lanes * gl_WorkGroupID.x + of_group;
    if (lane < 2u)
        found[2u * of_group + lane] = 0u;
    barrier();
    if (i < batch.count) {
        Word word = words[i];
        for (uint n = lane; n < size_of(word.points); n += lanes) {
            uint p = place_of(word.points, n);
            if (lightmesh_sees_light(word.level, word.brick, p, word.light_slot))
                atomicOr(found[2u * of_group + (p >> 5)], 1u << (p & 31u));
        }
    }
    barrier();
    if (i < batch.count && lane == 0u)
        seen[i] = uvec2(found[2u * of_group], found[2u * of_group + 1u]);
}
