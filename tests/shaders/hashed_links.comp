#version 450
// SPDX-License-Identifier: MIT

// Links by a tracer that goes by the bits of a ray's ends, all 192 of a brick.

#extension GL_GOOGLE_include_directive : require

layout(local_size_x = 64) in;

#include <lightmesh/gpu/lightmesh.glsl>

#include "hashed_tracer.glsl"

layout(push_constant) uniform Batch {
    uint count;
}
batch;

// As `LinkWord`.
layout(std430, set = 1, binding = 0) readonly buffer Words {
    ivec4 words[];
};
// As `OpenLinks`.
layout(std430, set = 1, binding = 1) writeonly buffer Open {
    uvec2 open_links[];
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= batch.count)
        return;
    for (uint axis = 0u; axis < 3u; ++axis) {
        uvec2 open = uvec2(0u);
        for (uint p = 0u; p < 64u; ++p)
            if (lightmesh_is_linked(uint(words[i].w) & 0xffffu, words[i].xyz, p, axis))
                open[p >> 5] |= 1u << (p & 31u);
        open_links[3u * i + axis] = open;
    }
}
