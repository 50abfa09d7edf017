// S of all lights at many points, for gpu_cache_test.cpp: binding 0 the points, 1 a row of S for each, 2 the lights
// that are not known.
layout(local_size_x = 64) in;

#include <lightmesh/gpu/cache.glsl>

struct Point {
    vec4 position;  // w: footprint
    vec4 normal;
    vec4 shading_normal;
};
layout(std430, set = 1, binding = 0) readonly buffer Points { Point points[]; };
layout(std430, set = 1, binding = 1) writeonly buffer Shares { float shares[]; };
layout(std430, set = 1, binding = 2) writeonly buffer Unknown { uvec2 unknown[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(points.length()))
        return;
    LightmeshCachePoint at = lightmesh_cache_point(points[i].position.xyz, points[i].normal.xyz, points[i].position.w,
                                                   points[i].shading_normal.xyz);
    LightmeshCacheTile found;
    for (uint tile = 0u; tile < lightmesh_cache_tile_count(); ++tile) {
        lightmesh_cache_find(at, tile, uvec2(~0u), found);
        for (uint l = 0u; l < lightmesh_cache_tile_size(tile); ++l)
            shares[i * lightmesh_cache_light_count() + 64u * tile + l] =
                lightmesh_cache_is_known(found, l) ? lightmesh_cache_share(found, l) : -1.0;
        unknown[i * lightmesh_cache_tile_count() + tile] = found.unknown;
    }
    if (at.lacks != 0u)
        lightmesh_cache_request(at, i);
}
