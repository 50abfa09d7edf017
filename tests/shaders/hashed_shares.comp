#version 450
// SPDX-License-Identifier: MIT

// Shares of lamps by a tracer that goes by the bits of a ray's ends.

#extension GL_GOOGLE_include_directive : require

layout(local_size_x = 64) in;

#include <lightmesh/gpu/lamp_shares.glsl>

layout(push_constant) uniform Batch {
    uint first;
}
batch;

#include "hashed_tracer.glsl"

void main() {
    lightmesh_find_lamp_shares(batch.first);
}
