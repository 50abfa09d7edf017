#version 450
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// S of all lights at many points, for mesh_queries.cpp. Rays are traced by the host: what a point asks for is
// written down, and the point is asked again when the answers are there.
layout(local_size_x = 64) in;

#include <lightmesh/gpu/lightmesh.glsl>

layout(std430, set = 1, binding = 0) readonly buffer Points { float points[]; };  // position, normal
layout(std430, set = 1, binding = 1) buffer Values { float values[]; };
layout(std430, set = 1, binding = 2) buffer Rays { uvec4 rays[]; };  // where they end; 0, open, blocked, asked
layout(std430, set = 1, binding = 3) buffer Ends { vec4 ends[]; };   // where they begin; w: 1 if rays are awaited
layout(push_constant) uniform Work {
    uint point_count;
    uint rays_per_point;
    uint only_awaiting;  // leaves points alone whose rays were all known
    uint sums_only;      // one value a point: the sum over its lights
};

const uint open = 1u;
const uint blocked = 2u;
const uint asked = 3u;

uint ray_number = 0u;
bool awaits_rays = false;

// What is not known yet is taken as open, as most of it is.
bool lightmesh_is_open(vec3 from, vec3 to) {
    uint number = ray_number++;
    if (number >= rays_per_point) {
        awaits_rays = true;
        return true;
    }
    uint slot = gl_GlobalInvocationID.x * rays_per_point + number;
    uvec4 ray = rays[slot];
    uvec3 end = floatBitsToUint(to);
    if (ray.w != 0u && ray.w != asked && ray.xyz == end)
        return ray.w == open;
    rays[slot] = uvec4(end, asked);
    awaits_rays = true;
    return true;
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= point_count || (only_awaiting != 0u && ends[i].w == 0.0))
        return;
    vec3 position = vec3(points[6u * i], points[6u * i + 1u], points[6u * i + 2u]);
    vec3 normal = vec3(points[6u * i + 3u], points[6u * i + 4u], points[6u * i + 5u]);
    LightMeshPoint point = lightmesh_point(position, normal);
    float sum = 0.0;
    for (uint t = 0u; t < lightmesh_tile_count(); ++t) {
        LightMeshTile tile = lightmesh_tile(point, t);
        uint size = lightmesh_tile_size(t);
        for (uint l = 0u; l < size; ++l) {
            bool is_missing = lightmesh_is_missing(tile, l);
            float lit = is_missing ? uintBitsToFloat(0x7fc00000u) : lightmesh_visibility(tile, l);
            if (sums_only == 0u)
                values[i * lightmesh.light_count + lightmesh_light_at(t, l)] = lit;
            else
                sum += lit;
        }
    }
    if (sums_only != 0u)
        values[i] = sum;
    ends[i] = vec4(point.end, awaits_rays ? 1.0 : 0.0);
}
