#version 460
// SPDX-License-Identifier: MIT

// Links of a light mesh that the host lists: of each light point of a word's cells one along x, y and z.

#extension GL_GOOGLE_include_directive : require
#include "listed_words.glsl"

// As `LinkWord`: the brick; the level, and 16 bits higher the cells.
struct Word {
    ivec3 brick;
    uint level_and_cells;
};
layout(std430, set = 2, binding = 0) readonly buffer Words {
    Word words[];
};
// Of each word six, as `OpenLinks`: two along x, two along y and two along z.
layout(std430, set = 2, binding = 1) writeonly buffer Open {
    uint open_links[];
};

shared uint found[24];

void main() {
    uint lane = lane_of_word();
    uint first = 6u * word_of_group();
    uint i = word_number();
    if (lane < 6u)
        found[first + lane] = 0u;
    barrier();
    if (i < batch.count) {
        Word word = words[i];
        uint cells = word.level_and_cells >> 16;
        uint points = 8u * uint(bitCount(cells));
        for (uint n = lane; n < 3u * points; n += lanes) {
            uint axis = n / points;
            uint p = 8u * place_of(cells, n % points / 8u) + (n & 7u);
            if (lightmesh_is_linked(word.level_and_cells & 0xffffu, word.brick, p, axis))
                atomicOr(found[first + 2u * axis + (p >> 5)], 1u << (p & 31u));
        }
    }
    barrier();
    if (i < batch.count && lane < 6u)
        open_links[6u * i + lane] = found[first + lane];
}
