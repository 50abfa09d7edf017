// SPDX-License-Identifier: MIT

// Rays of a light mesh that the host lists in words, for ListedWords (listed_words.hpp): 16 lanes trace those of a word,
// each one in turn. Whoever includes this has the words at binding 0 of set 2, and their answers at binding 1.

#define RAY_OPEN
#include "scene.glsl"
#include "rays.glsl"

#define LIGHTMESH_SET 1
#define LIGHTMESH_BINDING 0
#include <lightmesh/gpu/lightmesh.glsl>

layout(push_constant) uniform Batch {
    uint count;
}
batch;

const uint lanes = 16u;

layout(local_size_x = 64) in;

bool lightmesh_is_open(vec3 from, vec3 to) {
    return is_open(from, to);
}

uint lane_of_word() {
    return gl_LocalInvocationID.x % lanes;
}
// Of the words of this group.
uint word_of_group() {
    return gl_LocalInvocationID.x / lanes;
}
uint word_number() {
    return 64u / lanes * gl_WorkGroupID.x + word_of_group();
}

// The place of the n-th bit that is set, of more than n.
uint place_of(uint bits, uint n) {
    uint place = 0u;
    for (uint size = 16u; size != 0u; size >>= 1) {
        uint count = uint(bitCount(bits >> place & (1u << size) - 1u));
        if (n >= count) {
            n -= count;
            place += size;
        }
    }
    return place;
}
uint place_of(uvec2 bits, uint n) {
    uint below = uint(bitCount(bits.x));
    return n < below ? place_of(bits.x, n) : 32u + place_of(bits.y, n - below);
}
