#version 450
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// S of the first light at many points by lightmesh.glsl alone, without rays: it has to compile.
layout(local_size_x = 64) in;

#define LIGHTMESH_NO_RAYS
#include <lightmesh/gpu/lightmesh.glsl>

layout(std430, set = 1, binding = 0) buffer Points { vec4 points[]; };

void main() {
    uint i = 2u * gl_GlobalInvocationID.x;
    LightMeshPoint point = lightmesh_point(points[i].xyz, points[i + 1u].xyz);
    LightMeshTile tile = lightmesh_tile(point, 0u);
    points[i].w = lightmesh_is_missing(tile, 0u) ? -1.0 : lightmesh_visibility(tile, 0u);
}
