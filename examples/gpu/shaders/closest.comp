#version 460
// SPDX-License-Identifier: MIT

// The first surface along each segment of a list: its triangle, and t, u and v.

#extension GL_GOOGLE_include_directive : require
#define RAY_CLOSEST
#include "scene.glsl"
#include "rays.glsl"
#include "ray_list.glsl"

void main() {
    uint i = batch.first + gl_GlobalInvocationID.x;
    if (i >= batch.count)
        return;
    vec3 origin = segments[2u * i].xyz;
    RayHit hit = closest_hit(origin, segments[2u * i + 1u].xyz - origin, 1.0);
    answers[i] = uvec4(hit.triangle, floatBitsToUint(vec3(hit.t, hit.u, hit.v)));
}
