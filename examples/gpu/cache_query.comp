#version 450
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// S of all lights at many points, for cache_queries.cpp.
layout(local_size_x = 64) in;

#include <lightmesh/gpu/cache.glsl>
#include "host_rays.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (!is_asked(i))
        return;
    LightMeshCachePoint at = lightmesh_cache_point(points[i].position.xyz, points[i].normal.xyz, points[i].position.w,
                                                   points[i].shading_normal.xyz);
    LightMeshCacheTile tile;
    float sum = 0.0;
    vec4 four = vec4(0.0);
    uint known = 0u;
    for (uint t = 0u; t < lightmesh_cache_tile_count(); ++t) {
        lightmesh_cache_find(at, t, uvec2(~0u), tile);
        uint size = lightmesh_cache_tile_size(t);
        for (uint l = 0u; l < size; ++l) {
            if ((l & 3u) == 0u) {
                four = lightmesh_cache_shares_of_four(tile, l);
                known = lightmesh_cache_known_of_four(tile, l);
            }
            float share = (known & 1u) != 0u ? four.x : uintBitsToFloat(0x7fc00000u);
            known >>= 1;
            four.xyz = four.yzw;
            if (kind != kind_sums)
                values[i * lightmesh_cache_light_count() + 64u * t + l] = share;
            else
                sum += share;
        }
    }
    if (kind == kind_sums)
        values[i] = sum;
    else
        awaiting[i] = awaits_rays ? 1u : 0u;
    if (at.lacks != 0u)
        lightmesh_cache_request(at, i);
}
