#version 450
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// S of the first light at many points by cache.glsl without rays, beside a mesh: it has to compile.
layout(local_size_x = 64) in;

#define LIGHTMESH_NO_RAYS
#define LIGHTMESH_CACHE_SET 1
#define LIGHTMESH_CACHE_BINDING 2
#include <lightmesh/gpu/cache.glsl>
#include <lightmesh/gpu/lightmesh.glsl>

layout(std430, set = 0, binding = 0) buffer Points { vec4 points[]; };

void main() {
    uint i = 2u * gl_GlobalInvocationID.x;
    LightMeshCachePoint at = lightmesh_cache_point(points[i].xyz, points[i + 1u].xyz, 0.0, vec3(0.0));
    LightMeshCacheTile tile;
    lightmesh_cache_find(at, 0u, uvec2(1u, 0u), tile);
    float share = lightmesh_cache_is_known(tile, 0u) ? lightmesh_cache_share(tile, 0u) : -1.0;
    LightMeshPoint point = lightmesh_point(points[i].xyz, points[i + 1u].xyz);
    LightMeshTile of_mesh = lightmesh_tile(point, 0u);
    points[i].w = share + lightmesh_visibility(of_mesh, 0u);
}
