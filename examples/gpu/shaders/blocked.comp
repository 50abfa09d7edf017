#version 460
// SPDX-License-Identifier: MIT

// Which segments of a list are blocked: a bit each.

#extension GL_GOOGLE_include_directive : require
#define RAY_OPEN
#include "scene.glsl"
#include "rays.glsl"

layout(push_constant) uniform Batch {
    uint count;
}
batch;

// Six words each: the ends.
layout(std430, set = 1, binding = 0) readonly buffer Segments {
    float segments[];
};
layout(std430, set = 1, binding = 1) writeonly buffer Blocked {
    uint blocked[];
};

layout(local_size_x = 64) in;

shared uint found[2];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint i = gl_GlobalInvocationID.x;
    if (lane < 2u)
        found[lane] = 0u;
    barrier();
    if (i < batch.count) {
        vec3 from = vec3(segments[6u * i], segments[6u * i + 1u], segments[6u * i + 2u]);
        vec3 to = vec3(segments[6u * i + 3u], segments[6u * i + 4u], segments[6u * i + 5u]);
        if (!is_open(from, to))
            atomicOr(found[lane >> 5], 1u << (lane & 31u));
    }
    barrier();
    if (lane < 2u)
        blocked[2u * gl_WorkGroupID.x + lane] = found[lane];
}
