// SPDX-License-Identifier: MIT

// Walks through a WideBvh (wide_bvh.hpp), for rays.glsl.

layout(std430, set = 0, binding = 1) readonly buffer BvhNodes {
    uvec4 bvh_nodes[];
};
layout(std430, set = 0, binding = 2) readonly buffer BvhTriangles {
    uvec4 bvh_triangles[];
};

#define MOST_BVH_DEPTH 32

// Away from 0, so that no box test divides by it.
vec3 bvh_inverse(vec3 way) {
    vec3 least = mix(vec3(1e-18), vec3(-1e-18), lessThan(way, vec3(0.0)));
    return 1.0 / mix(way, least, lessThan(abs(way), vec3(1e-18)));
}

// Embree's test, after Moeller and Trumbore: where the ray meets a triangle, if it does for 0 < t <= reach, or by some
// roundings more.
bool bvh_meets(uvec4 a, uvec4 b, uvec4 c, vec3 origin, vec3 way, float reach, out vec3 found) {
    vec3 corner = uintBitsToFloat(a.xyz);
    vec3 first = corner - uintBitsToFloat(b.xyz);
    vec3 second = uintBitsToFloat(c.xyz) - corner;
    vec3 normal = cross(second, first);
    vec3 to_corner = corner - origin;
    vec3 turned = cross(to_corner, way);
    float along = dot(normal, way);
    float size = abs(along);
    float side = along < 0.0 ? -1.0 : 1.0;
    float u = dot(turned, second) * side;
    float v = dot(turned, first) * side;
    float t = dot(normal, to_corner) * side;
    bool is_met = size > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= size && t > 0.0 && t <= 1.000001 * size * reach;
    if (is_met)
        found = vec3(t, u, v) / size;
    return is_met;
}

const uint bvh_leaf = 0x80000000u;
const uint bvh_end = 0xffffffffu;

// The walk of one ray: the child that is next, as nodes name their children, and those that wait. What to ask of the
// triangles that light may pass is left to whoever walks, between steps: code that few rays need is not on the way of
// all.
uint bvh_next;
uint bvh_waiting[3 * MOST_BVH_DEPTH + 1];
float bvh_waiting_from[3 * MOST_BVH_DEPTH + 1];  // where the ray enters them; of the first surface only
uint bvh_waiting_count;
// Where it meets a side of a box: side * bvh_scale + bvh_shift. And where in a node the sides are that it meets first.
vec3 bvh_scale;
vec3 bvh_shift;
uvec3 bvh_near;
uvec3 bvh_far;

void ray_begin(vec3 origin, vec3 way, float reach, bool is_any) {
    bvh_scale = bvh_inverse(way);
    bvh_shift = -origin * bvh_scale;
    uvec3 is_down = uvec3(lessThan(bvh_scale, vec3(0.0)));
    bvh_near = uvec3(0u, 2u, 4u) + is_down;
    bvh_far = uvec3(1u, 3u, 5u) - is_down;
    bvh_next = 0u;
    bvh_waiting[0] = bvh_end;
    bvh_waiting_from[0] = 0.0;
    bvh_waiting_count = 1u;
}

void bvh_wait(uvec2 child, bool is_any) {
    bvh_waiting[bvh_waiting_count] = child.y;
    if (!is_any)
        bvh_waiting_from[bvh_waiting_count] = uintBitsToFloat(child.x);
    ++bvh_waiting_count;
}

void bvh_take_waiting(float reach, bool is_any) {
    do {
        --bvh_waiting_count;
        bvh_next = bvh_waiting[bvh_waiting_count];
    } while (!is_any && bvh_waiting_from[bvh_waiting_count] > 1.000001 * reach);
}

void bvh_sort(inout uvec2 a, inout uvec2 b) {
    bool is_turned = b.x < a.x;
    uvec2 first = is_turned ? b : a;
    b = is_turned ? a : b;
    a = first;
}

vec4 bvh_sides(uint at, uint axis) {
    return uintBitsToFloat(bvh_nodes[at]) * bvh_scale[axis] + bvh_shift[axis];
}

// From a node to one of the children that the ray meets from 0 to `reach`, the first or the last one; the others wait.
void bvh_open(float reach, bool is_any, bool from_target) {
    uvec4 children = bvh_nodes[bvh_next + 6u];
    vec4 from = max(max(bvh_sides(bvh_next + bvh_near.x, 0u), bvh_sides(bvh_next + bvh_near.y, 1u)),
                    max(bvh_sides(bvh_next + bvh_near.z, 2u), vec4(0.0)));
    vec4 to = min(min(bvh_sides(bvh_next + bvh_far.x, 0u), bvh_sides(bvh_next + bvh_far.y, 1u)),
                  min(bvh_sides(bvh_next + bvh_far.z, 2u), vec4(reach)));
    // By some roundings of a product and a sum.
    bvec4 meets = lessThanEqual(from, to * 1.000001);
    // Floats of no sign are in the order of their bits.
    uvec4 keys = from_target ? floatBitsToUint(to) ^ 0x7fffffffu : floatBitsToUint(from);
    uvec2 first = uvec2(meets.x ? keys.x : bvh_end, children.x);
    uvec2 second = uvec2(meets.y ? keys.y : bvh_end, children.y);
    uvec2 third = uvec2(meets.z ? keys.z : bvh_end, children.z);
    uvec2 fourth = uvec2(meets.w ? keys.w : bvh_end, children.w);
    bvh_sort(first, second);
    bvh_sort(third, fourth);
    bvh_sort(first, third);
    bvh_sort(second, fourth);
    bvh_sort(second, third);
    if (fourth.x != bvh_end)
        bvh_wait(fourth, is_any);
    if (third.x != bvh_end)
        bvh_wait(third, is_any);
    if (second.x != bvh_end)
        bvh_wait(second, is_any);
    bvh_next = first.y;
    if (first.x == bvh_end)
        bvh_take_waiting(reach, is_any);
}

// Of triangles that a ray meets in one place the one of the least number counts, whatever the shape of the tree. With
// `is_any` it is faster to begin at the end that the rays of neighbours share: lanes of a GPU that take one way do it at
// the price of one.
bool ray_walk(vec3 origin, vec3 way, bool is_any, bool from_target, inout RayHit hit, out RayHit next) {
    // A node and then a triangle in each round: lanes that look for a triangle do not wait for each other.
    while (bvh_next != bvh_end) {
        if (bvh_next < bvh_leaf)
            bvh_open(hit.t, is_any, from_target);
        if (bvh_next < bvh_leaf || bvh_next == bvh_end)
            continue;
        uint first_word = 3u * ((bvh_next & ~bvh_leaf) >> 2);
        uvec4 a = bvh_triangles[first_word];
        uvec4 b = bvh_triangles[first_word + 1u];
        uvec4 c = bvh_triangles[first_word + 2u];
        vec3 found;
        bool meets = bvh_meets(a, b, c, origin, way, hit.t, found) &&
                     (found.x < hit.t || found.x == hit.t && a.w < hit.triangle);
        bool is_opaque = b.w == 0u;
        if (meets)
            next = RayHit(a.w, found.x, found.y, found.z);
        if (meets && is_opaque)
            hit = next;
        bvh_next += 3u;  // one triangle on, one less
        if ((bvh_next & 3u) == 0u)
            bvh_take_waiting(hit.t, is_any);
        if (meets && (is_any || !is_opaque))
            return !is_opaque;
    }
    return false;
}

void ray_take(RayHit next, inout RayHit hit) {
    hit = next;
}
