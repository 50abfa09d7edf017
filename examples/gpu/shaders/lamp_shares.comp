#version 460
// SPDX-License-Identifier: MIT

// Shares of lamps that a visibility cache asks for.

#extension GL_GOOGLE_include_directive : require
#define RAY_OPEN
#include "scene.glsl"
#include "rays.glsl"

layout(local_size_x = 64) in;

#define LIGHTMESH_LAMP_SET 1
#include <lightmesh/gpu/lamp_shares.glsl>

layout(push_constant) uniform Batch {
    uint first;
}
batch;

bool lightmesh_is_open(vec3 from, vec3 to) {
    return is_open(from, to);
}

void main() {
    lightmesh_find_lamp_shares(batch.first);
}
