#version 460
// SPDX-License-Identifier: MIT

// The share of light that passes each segment of a list.

#extension GL_GOOGLE_include_directive : require
#define RAY_SHARE
#include "scene.glsl"
#include "rays.glsl"
#include "ray_list.glsl"

void main() {
    uint i = batch.first + gl_GlobalInvocationID.x;
    if (i >= batch.count)
        return;
    answers[i] = uvec4(floatBitsToUint(let_through(segments[2u * i].xyz, segments[2u * i + 1u].xyz)), 0u, 0u, 0u);
}
