#version 460
// SPDX-License-Identifier: MIT

// Shades each pixel's point, with shadows by rays: one to each light, or with AREA to stratified points of lamps with
// sizes, as ray_visibility.cpp has them. With HOST_ROWS the host has found the shadows.

#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"
#ifdef HOST_ROWS
#define HOST_ROWS_BINDING 0
#include "host_rows.glsl"
#else
#define RAY_SHARE
#include "rays.glsl"
#endif
#include "paths.glsl"
#include "random.glsl"
#include "lights.glsl"

layout(local_size_x = 64) in;

#ifdef AREA
// Two directions across a third and each other, all of length 1.
void across(vec3 axis, out vec3 right, out vec3 up) {
    right = normalize(cross(axis, abs(axis.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0)));
    up = cross(right, axis);
}

// The end of ray s to a light: the disc of a lamp's sphere that faces the point ring by ring, a rectangle row by row,
// in strata of equal area.
vec3 end_of_sample(LightData light, vec3 origin, vec3 middle, uint s, inout uvec2 random) {
    uint samples = frame.numbers.z;
    uint rings = frame.numbers.w;
    uint ring = s * rings / samples;
    uint first = (ring * samples + rings - 1u) / rings;
    float count = float(((ring + 1u) * samples + rings - 1u) / rings - first);
    float outwards = random_uniform(random);
    float around = (float(s - first) + random_uniform(random)) / count;
    float share = (float(first) + count * outwards) / float(samples);
    if (light.kind == light_rect)
        return middle + (2.0 * around - 1.0) * light.half_u + (2.0 * share - 1.0) * light.half_v;
    vec3 way = middle - origin;
    float far = length(way);
    vec3 right;
    vec3 up;
    across(way / far, right, up);
    vec2 turned = circle_point(around);
    vec3 target = middle + light.size * sqrt(share) * (turned.x * right + turned.y * up);
    // A fixture does not hide its own lamp.
    return origin + max(0.3, 1.0 - 1.15 * light.size / far) * (target - origin);
}
#endif

void main() {
    uint pixel = gl_GlobalInvocationID.x;
    if (pixel >= batch.count)
        return;
    uvec4 counts = paths[2u * pixel + 1u];
    if (counts.w == 0u)
        return;
    PathPoint point = read_point(pixel);
    uvec4 triangle = corners[point.triangle];
    uint at = material_at(triangle);
    Material material = read_material(at);
    Surface surface = surface_at(at, material, triangle, point.u, point.v);
    vec3 sum = frame.ambient.rgb * surface.diffuse +
               surface.alpha * emission_at(at, material, triangle, point.u, point.v);
    vec3 origin = point.position + frame.ambient.w * point.normal;
#ifdef HOST_ROWS
    uint row = answer_rows[pixel];
#endif
    for (uint l = 0u; l < frame.numbers.x; ++l) {
        LightData light = read_light(l);
        Illumination found = illuminate(light, point.position);
        if (dot(point.normal, found.to_light) < 0.0 || found.irradiance == vec3(0.0))
            continue;
        vec3 reflected =
            reflected_share(material, surface, point.shading_normal, point.ray_direction, found.to_light);
        if (reflected == vec3(0.0))
            continue;
#ifdef HOST_ROWS
        float lit = answer_in(row, l);
#else
        vec3 middle = end_of_ray(light, origin);
#ifdef AREA
        uvec2 random = random_of(uvec2(point.seed ^ l * 0x9e3779b9u, 0u));
        float lit = 0.0;
        for (uint s = 0u; s < frame.numbers.z; ++s)
            lit += let_through(origin, end_of_sample(light, origin, middle, s, random));
        lit /= float(frame.numbers.z);
        counts.z += frame.numbers.z;
#else
        float lit = let_through(origin, middle);
        ++counts.z;
#endif
#endif
        sum += lit * reflected * found.irradiance;
    }
    colours[pixel].rgb += point.weight * sum;
    paths[2u * pixel + 1u].z = counts.z;
}
