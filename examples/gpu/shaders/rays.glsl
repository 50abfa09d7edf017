// SPDX-License-Identifier: MIT

// Rays through a scene, for shaders that include scene.glsl: by ray queries with RAY_QUERIES defined, else through a BVH.
// scene.glsl has these two, which are asked only of triangles that light may pass:
//     bool ray_is_hole(uint triangle, float u, float v);      for closest_hit: whether a mask has a hole there
//     float ray_share(uint triangle, float u, float v);       for the others: the share of light that passes
// It has those functions that are asked for: RAY_CLOSEST, RAY_SHARE, RAY_OPEN.

struct RayHit {
    uint triangle;  // the scene's number; ~0: none
    float t, u, v;
};

// A walk along one ray:
//     void ray_begin(vec3 origin, vec3 way, float reach, bool is_any);
//     bool ray_walk(vec3 origin, vec3 way, bool is_any, bool from_target, inout RayHit hit, out RayHit next);
// Walks on. True: to `next`, a triangle that light may pass. False: to the end; or with `is_any` to an opaque triangle.
// `hit` is the nearest opaque triangle, or that one, once false is returned. `from_target`: the end that the rays of
// neighbours share is the far one.
//     void ray_take(RayHit next, inout RayHit hit);
// Counts `next` as opaque, in a walk that is not of `is_any`.
#ifdef RAY_QUERIES
#include "ray_queries.glsl"
#else
#include "bvh.glsl"
#endif

#ifdef RAY_CLOSEST
// The first surface on origin + t * way, 0 < t <= reach, that is no hole of a mask.
RayHit closest_hit(vec3 origin, vec3 way, float reach) {
    RayHit hit = RayHit(~0u, reach, 0.0, 0.0);
    RayHit next;
    ray_begin(origin, way, reach, false);
    while (ray_walk(origin, way, false, false, hit, next))
        if (!ray_is_hole(next.triangle, next.u, next.v))
            ray_take(next, hit);
    return hit;
}
#endif

#ifdef RAY_SHARE
// The product of what all surfaces between a point and a lamp let through.
float let_through(vec3 origin, vec3 target) {
    float share = 1.0;
    vec3 way = target - origin;
    RayHit hit = RayHit(~0u, 1.0, 0.0, 0.0);
    RayHit next;
    ray_begin(origin, way, 1.0, true);
    while (share > 0.0 && ray_walk(origin, way, true, true, hit, next))
        share *= ray_share(next.triangle, next.u, next.v);
    return hit.triangle == ~0u ? share : 0.0;
}
#endif

#ifdef RAY_OPEN
uint ray_mixed(uint hash, uint value) {
    hash = (hash ^ value) * 0x9e3779b1u;
    hash ^= hash >> 15;
    hash *= 0x85ebca77u;
    return hash ^ hash >> 13;
}

// As `EmbreeIntersector` has it: of a segment in either direction, and a surface.
uint ray_hash(vec3 origin, vec3 target, uint surface) {
    uvec3 a = floatBitsToUint(origin);
    uvec3 b = floatBitsToUint(target);
    bool is_turned = a.x != b.x ? a.x > b.x : a.y != b.y ? a.y > b.y : a.z > b.z;
    uvec3 ends[2] = uvec3[](is_turned ? b : a, is_turned ? a : b);
    uint hash = ray_mixed(0x2545f491u, surface);
    for (int end = 0; end < 2; ++end)
        for (int axis = 0; axis < 3; ++axis)
            hash = ray_mixed(hash, ends[end][axis]);
    return hash;
}

// True if nothing blocks a segment, whose origin is near to that of its neighbours; surfaces that let some of the light
// through do so by chance.
bool is_open(vec3 origin, vec3 target) {
    vec3 way = target - origin;
    RayHit hit = RayHit(~0u, 1.0, 0.0, 0.0);
    RayHit next;
    bool is_blocked = false;
    ray_begin(origin, way, 1.0, true);
    while (!is_blocked && ray_walk(origin, way, true, false, hit, next)) {
        float share = ray_share(next.triangle, next.u, next.v);
        float chance = float(ray_hash(origin, target, next.triangle)) * (1.0 / 4294967296.0);
        is_blocked = share < 1.0 && !(chance < share);
    }
    return !is_blocked && hit.triangle == ~0u;
}
#endif
