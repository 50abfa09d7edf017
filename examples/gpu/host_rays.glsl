// SPDX-License-Identifier: MIT

// Points that are asked about, and the rays that this takes, for host_rays.cpp: the host traces them. What a point asks
// for is written down, and the point is asked again when the answers are there. Set 1; to be included once.

const uint kind_all = 0u;
const uint kind_awaiting = 1u;  // points whose rays were not all known
const uint kind_settled = 2u;   // the others
const uint kind_sums = 3u;      // all points, of which all rays are known; one value a point: the sum over its lights

struct Point {
    vec4 position;  // w: footprint
    vec4 normal;
    vec4 shading_normal;
};
struct Ray {
    vec4 from;
    vec3 to;
    uint state;  // 0, open, blocked, asked
};
layout(std430, set = 1, binding = 0) readonly buffer Points { Point points[]; };
layout(std430, set = 1, binding = 1) buffer Values { float values[]; };
layout(std430, set = 1, binding = 2) buffer Rays { Ray rays[]; };
layout(std430, set = 1, binding = 3) buffer Awaiting { uint awaiting[]; };  // 1 if rays are awaited
// For sums, a bit for each ray of a point: whether it is open.
layout(std430, set = 1, binding = 4) readonly buffer Answers { uint answers[]; };
layout(push_constant) uniform Work {
    uint point_count;
    uint rays_per_point;
    uint kind;
};

const uint ray_is_open = 1u;
const uint ray_is_blocked = 2u;
const uint ray_is_asked = 3u;

uint ray_number = 0u;
bool awaits_rays = false;

// What is not known yet is taken as open, as most of it is.
bool lightmesh_is_open(vec3 from, vec3 to) {
    uint number = ray_number++;
    awaits_rays = awaits_rays || number >= rays_per_point;
    if (number >= rays_per_point)
        return true;
    if (kind == kind_sums) {
        uint word = gl_GlobalInvocationID.x * ((rays_per_point + 31u) >> 5) + (number >> 5);
        return (answers[word] >> (number & 31u) & 1u) != 0u;
    }
    uint slot = gl_GlobalInvocationID.x * rays_per_point + number;
    uint state = rays[slot].state;
    bool is_known = (state == ray_is_open || state == ray_is_blocked) && rays[slot].from.xyz == from && rays[slot].to == to;
    if (!is_known) {
        rays[slot] = Ray(vec4(from, 0.0), to, ray_is_asked);
        awaits_rays = true;
    }
    return !is_known || state == ray_is_open;
}

// True if point i is to be asked about.
bool is_asked(uint i) {
    if (i >= point_count)
        return false;
    return kind == kind_awaiting ? awaiting[i] != 0u : kind != kind_settled || awaiting[i] == 0u;
}
