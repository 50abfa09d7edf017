// SPDX-License-Identifier: MIT

// Rays on their way: the state of each pixel of a batch, and the surface point that it waits with. Set 0.

layout(push_constant) uniform Batch {
    uint first;  // pixel of the picture, row by row
    uint count;
    uint is_first_round;
    uint attempt;  // to ask a light mesh: by how many roundings points lie off their surface
}
batch;

// Two words of four each pixel: of its random numbers, the next sample, rays that wait; then counts of all rounds:
// surface points, mirrored and refracted rays, shadow rays, and what there is to do now: some of the two below.
layout(std430, set = 0, binding = 7) buffer Paths {
    uvec4 paths[];
};
// Rays that wait, three words of four each, those of all pixels beside each other.
layout(std430, set = 0, binding = 8) buffer Waiting {
    uvec4 waiting_rays[];
};
// Five words of four each point, those of all pixels beside each other.
layout(std430, set = 0, binding = 9) buffer Points {
    uvec4 points[];
};
layout(std430, set = 0, binding = 10) buffer Colours {
    vec4 colours[];
};
layout(std430, set = 0, binding = 12) buffer Round {
    uint point_count;
    uint is_failed;  // whether a point lies where a mesh has none
}
this_round;

const uint has_point = 1u;
const uint waits_for_shadows = 2u;

struct PathRay {
    vec3 origin;
    vec3 direction;
    vec3 weight;  // the share of a pixel that it brings
    uint depth;
    float width;  // of the pixel's cone at the origin
};

struct PathPoint {
    vec3 position;
    vec3 normal;          // geometric, towards where the ray came from
    vec3 shading_normal;  // on the same side
    vec3 ray_direction;
    vec3 weight;
    float footprint;
    uint triangle;
    float u;
    float v;
    uint seed;
};

void write_point(uint pixel, PathPoint point) {
    points[pixel] = floatBitsToUint(vec4(point.position, point.footprint));
    points[batch.count + pixel] = uvec4(floatBitsToUint(point.normal), point.triangle);
    points[2u * batch.count + pixel] = floatBitsToUint(vec4(point.shading_normal, point.u));
    points[3u * batch.count + pixel] = floatBitsToUint(vec4(point.ray_direction, point.v));
    points[4u * batch.count + pixel] = uvec4(floatBitsToUint(point.weight), point.seed);
}

PathPoint read_point(uint pixel) {
    vec4 a = uintBitsToFloat(points[pixel]);
    uvec4 b = points[batch.count + pixel];
    vec4 c = uintBitsToFloat(points[2u * batch.count + pixel]);
    vec4 d = uintBitsToFloat(points[3u * batch.count + pixel]);
    uvec4 e = points[4u * batch.count + pixel];
    return PathPoint(a.xyz, uintBitsToFloat(b.xyz), c.xyz, d.xyz, uintBitsToFloat(e.xyz), a.w, b.w, c.w, d.w, e.w);
}
