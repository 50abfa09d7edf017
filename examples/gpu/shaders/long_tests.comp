#version 460
// SPDX-License-Identifier: MIT

// Long tests of a light mesh that the host lists: the light points of a word.

#extension GL_GOOGLE_include_directive : require
#include "listed_words.glsl"

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

shared uint found[8];

uint size_of(uvec2 bits) {
    return uint(bitCount(bits.x) + bitCount(bits.y));
}

void main() {
    uint lane = lane_of_word();
    uint of_group = word_of_group();
    uint i = word_number();
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
