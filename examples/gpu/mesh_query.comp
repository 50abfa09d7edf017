#version 450
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// S of all lights at many points, for mesh_queries.cpp; with FOOTPRINTS by those.
layout(local_size_x = 64) in;

#include <lightmesh/gpu/lightmesh.glsl>
#include "host_rays.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (!is_asked(i))
        return;
#ifdef FOOTPRINTS
    LightMeshBlend point = lightmesh_point(points[i].position.xyz, points[i].normal.xyz, points[i].position.w);
#else
    LightMeshPoint point = lightmesh_point(points[i].position.xyz, points[i].normal.xyz);
#endif
    float sum = 0.0;
    for (uint t = 0u; t < lightmesh_tile_count(); ++t) {
#ifdef FOOTPRINTS
        LightMeshBlendTile tile = lightmesh_tile(point, t);
#else
        LightMeshTile tile = lightmesh_tile(point, t);
#endif
        uint size = lightmesh_tile_size(t);
        for (uint first = 0u; first < size; first += 4u) {
            vec4 lit = lightmesh_visibility_of_four(tile, first);
            for (uint k = 0u; k < 4u && first + k < size; ++k) {
                uint l = first + k;
                float of_light = lightmesh_is_missing(tile, l) ? uintBitsToFloat(0x7fc00000u) : lit[k];
                if (kind == kind_sums) {
                    sum += of_light;
                    continue;
                }
                // Both ways to ask are held against the CPU.
                if ((first & 4u) != 0u && !lightmesh_is_missing(tile, l))
                    of_light = lightmesh_visibility(tile, l);
                values[i * lightmesh.light_count + lightmesh_light_at(t, l)] = of_light;
            }
        }
    }
    if (kind == kind_sums)
        values[i] = sum;
    else
        awaiting[i] = awaits_rays ? 1u : 0u;
}
