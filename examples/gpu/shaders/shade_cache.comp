#version 460
// SPDX-License-Identifier: MIT

// Shades each pixel's point by a visibility cache. What the cache lacks is written to the request buffer; the point
// waits until the cache has it, or the host has answered for the point.

#extension GL_GOOGLE_include_directive : require
#define RAY_OPEN
#include "scene.glsl"
#include "rays.glsl"
#include "paths.glsl"
#include "lights.glsl"

#define LIGHTMESH_CACHE_SET 1
#define LIGHTMESH_CACHE_BINDING 0
#include <lightmesh/gpu/cache.glsl>

layout(local_size_x = 64) in;

#define HOST_ROWS_BINDING 5
#include "host_rows.glsl"

bool lightmesh_is_open(vec3 from, vec3 to) {
    return is_open(from, to);
}

void main() {
    uint pixel = gl_GlobalInvocationID.x;
    if (pixel >= batch.count)
        return;
    uint to_do = paths[2u * pixel + 1u].w;
    if ((to_do & waits_for_shadows) == 0u)
        return;
    PathPoint point = read_point(pixel);
    uvec4 triangle = corners[point.triangle];
    uint at = material_at(triangle);
    Material material = read_material(at);
    Surface surface = surface_at(at, material, triangle, point.u, point.v);
    vec3 sum = frame.ambient.rgb * surface.diffuse +
               surface.alpha * emission_at(at, material, triangle, point.u, point.v);
    uint row = answer_rows[pixel];
    LightMeshCachePoint query =
        lightmesh_cache_point(point.position, point.normal, point.footprint, point.shading_normal);
    LightMeshCacheTile tile;
    for (uint t = 0u; t < lightmesh_cache_tile_count(); ++t) {
        if (row == 0u)
            lightmesh_cache_find(query, t, uvec2(~0u), tile);
        for (uint l = 0u; l < lightmesh_cache_tile_size(t); ++l) {
            uint light = 64u * t + l;
            float lit = 0.0;
            if (row != 0u)
                lit = answer_in(row, light);
            else if (lightmesh_cache_is_known(tile, l))
                lit = lightmesh_cache_share(tile, l);
            if (lit == 0.0)
                continue;
            Illumination found = illuminate(read_light(light), point.position);
            sum += lit * found.irradiance *
                   reflected_share(material, surface, point.shading_normal, point.ray_direction, found.to_light);
        }
    }
    if (row == 0u && query.lacks != 0u) {
        if ((query.lacks & lightmesh_cache_lacks_place) != 0u)
            this_round.is_failed = 1u;
        lightmesh_cache_request(query, pixel);
        return;
    }
    colours[pixel].rgb += point.weight * sum;
    paths[2u * pixel + 1u].w = to_do & ~waits_for_shadows;
}
