// SPDX-License-Identifier: MIT

// Rays through a WideBvh (wide_bvh.hpp). Whoever includes this has `bvh_nodes` and `bvh_triangles`, arrays of uvec4,
// and these two, which are asked only of triangles that light may pass:
//     bool bvh_is_hole(uint triangle, float u, float v);      for closest_hit: whether a mask has a hole there
//     float bvh_share(uint triangle, float u, float v);       for the others: the share of light that passes
// Of the functions at the end it has those that it asks for: BVH_CLOSEST, BVH_SHARE, BVH_OPEN.

#define MOST_BVH_DEPTH 48

struct BvhHit {
    uint triangle;  // the scene's number; ~0: none
    float t, u, v;
};

// Away from 0, so that no box test divides by it.
vec3 bvh_inverse(vec3 way) {
    vec3 least = mix(vec3(1e-18), vec3(-1e-18), lessThan(way, vec3(0.0)));
    return 1.0 / mix(way, least, lessThan(abs(way), vec3(1e-18)));
}

// Of 4 bytes in a word, as floats.
vec4 bvh_bytes(uint word) {
    return vec4(uvec4(word, word >> 8, word >> 16, word >> 24) & 255u);
}

// Which children a ray meets from 0 to `reach`: for nodes bit 24 + slot ^ order, for leaves the bits of their
// triangles. Four slots of a node: `kinds` has their bytes.
uint bvh_children(uint kinds, vec4 low_x, vec4 low_y, vec4 low_z, vec4 high_x, vec4 high_y, vec4 high_z, vec3 start,
                  vec3 step, float reach, uint order) {
    vec4 x0 = low_x * step.x + start.x;
    vec4 x1 = high_x * step.x + start.x;
    vec4 y0 = low_y * step.y + start.y;
    vec4 y1 = high_y * step.y + start.y;
    vec4 z0 = low_z * step.z + start.z;
    vec4 z1 = high_z * step.z + start.z;
    vec4 near = max(max(min(x0, x1), min(y0, y1)), max(min(z0, z1), vec4(0.0)));
    vec4 far = min(min(max(x0, x1), max(y0, y1)), min(max(z0, z1), vec4(reach)));
    // By some roundings of a product and a sum.
    bvec4 meets = lessThanEqual(near, far * 1.000001);
    uint found = 0u;
    for (int i = 0; i < 4; ++i) {
        uint kind = kinds >> 8 * i & 255u;
        uint place = kind & 31u;
        uint is_node = place >= 24u ? 7u : 0u;
        if (meets[i])
            found |= (kind >> 5) << (place ^ (order & is_node));
    }
    return found;
}

// The children of a node that a ray meets, and where they are: x the first child node, y the bits of nodes with the
// slots that have nodes below, z the first triangle, w the bits of triangles.
uvec4 bvh_open(uint node, vec3 origin, vec3 inverse, float reach, uint order) {
    uvec4 a = bvh_nodes[5u * node];
    uvec4 b = bvh_nodes[5u * node + 1u];
    uvec4 c = bvh_nodes[5u * node + 2u];
    uvec4 d = bvh_nodes[5u * node + 3u];
    uvec4 e = bvh_nodes[5u * node + 4u];
    vec3 start = (uintBitsToFloat(a.xyz) - origin) * inverse;
    vec3 step = uintBitsToFloat((uvec3(a.w, a.w >> 8, a.w >> 16) & 255u) << 23) * inverse;
    uint found = bvh_children(b.z, bvh_bytes(c.x), bvh_bytes(c.z), bvh_bytes(d.x), bvh_bytes(d.z), bvh_bytes(e.x),
                              bvh_bytes(e.z), start, step, reach, order) |
                 bvh_children(b.w, bvh_bytes(c.y), bvh_bytes(c.w), bvh_bytes(d.y), bvh_bytes(d.w), bvh_bytes(e.y),
                              bvh_bytes(e.w), start, step, reach, order);
    return uvec4(b.x, (found & 0xff000000u) | a.w >> 24, b.y, found & 0x00ffffffu);
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
    found = vec3(t, u, v) / size;
    return size > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= size && t > 0.0 && t <= 1.000001 * size * reach;
}

// The walk of one ray: nodes and triangles that wait. What to ask of the triangles that light may pass is left to
// whoever walks, between steps: code that few rays need is not on the way of all.
uvec2 bvh_waiting[MOST_BVH_DEPTH];
uint bvh_waiting_count;
uvec4 bvh_now;  // as bvh_open gives it
vec3 bvh_inverse_way;
uint bvh_order;

void bvh_begin(vec3 origin, vec3 way, float reach) {
    bvh_inverse_way = bvh_inverse(way);
    uvec3 signs = uvec3(greaterThan(bvh_inverse_way, vec3(0.0)));
    bvh_order = signs.x | signs.y << 1 | signs.z << 2;
    bvh_waiting_count = 0u;
    bvh_now = bvh_open(0u, origin, bvh_inverse_way, reach, bvh_order);
}

// Walks on. True: to `next`, a triangle that light may pass. False: to the end; or with `is_any` to an opaque triangle.
// Opaque triangles shorten `hit`. Of triangles that a ray meets in one place the one of the least number counts,
// whatever the shape of the tree.
bool bvh_walk(vec3 origin, vec3 way, bool is_any, inout BvhHit hit, out BvhHit next) {
    bool has_next = false;
    bool is_done = false;
    while (!has_next && !is_done) {
        while (bvh_now.w != 0u && !has_next) {
            uint first_word = 3u * (bvh_now.z + uint(findLSB(bvh_now.w)));
            bvh_now.w &= bvh_now.w - 1u;
            uvec4 a = bvh_triangles[first_word];
            uvec4 b = bvh_triangles[first_word + 1u];
            uvec4 c = bvh_triangles[first_word + 2u];
            vec3 found;
            if (bvh_meets(a, b, c, origin, way, hit.t, found) &&
                (found.x < hit.t || found.x == hit.t && a.w < hit.triangle)) {
                has_next = b.w != 0u;
                next = BvhHit(a.w, found.x, found.y, found.z);
                if (!has_next)
                    hit = next;
            }
        }
        if (has_next)
            break;
        is_done = bvh_now.y <= 0x00ffffffu && bvh_waiting_count == 0u || is_any && hit.triangle != ~0u;
        if (is_done)
            break;
        if (bvh_now.y <= 0x00ffffffu)
            bvh_now.xy = bvh_waiting[--bvh_waiting_count];
        uint child = uint(findMSB(bvh_now.y));
        bvh_now.y &= ~(1u << child);
        if (bvh_now.y > 0x00ffffffu)
            bvh_waiting[bvh_waiting_count++] = bvh_now.xy;
        uint slot = child - 24u ^ bvh_order;
        uint before = uint(bitCount(bvh_now.y & 255u & (1u << slot) - 1u));
        bvh_now = bvh_open(bvh_now.x + before, origin, bvh_inverse_way, hit.t, bvh_order);
    }
    return has_next;
}

#ifdef BVH_CLOSEST
// The first surface on origin + t * way, 0 < t <= reach, that is no hole of a mask.
BvhHit closest_hit(vec3 origin, vec3 way, float reach) {
    BvhHit hit = BvhHit(~0u, reach, 0.0, 0.0);
    BvhHit next;
    bvh_begin(origin, way, reach);
    while (bvh_walk(origin, way, false, hit, next))
        if (!bvh_is_hole(next.triangle, next.u, next.v))
            hit = next;
    return hit;
}
#endif

#ifdef BVH_SHARE
// The product of what all surfaces between two points let through.
float let_through(vec3 origin, vec3 target) {
    float share = 1.0;
    vec3 way = target - origin;
    BvhHit hit = BvhHit(~0u, 1.0, 0.0, 0.0);
    BvhHit next;
    bvh_begin(origin, way, 1.0);
    while (share > 0.0 && bvh_walk(origin, way, true, hit, next))
        share *= bvh_share(next.triangle, next.u, next.v);
    return hit.triangle == ~0u ? share : 0.0;
}
#endif

#ifdef BVH_OPEN
uint bvh_mixed(uint hash, uint value) {
    hash = (hash ^ value) * 0x9e3779b1u;
    hash ^= hash >> 15;
    hash *= 0x85ebca77u;
    return hash ^ hash >> 13;
}

// As `EmbreeIntersector` has it: of a segment in either direction, and a surface.
uint bvh_hash(vec3 origin, vec3 target, uint surface) {
    uvec3 a = floatBitsToUint(origin);
    uvec3 b = floatBitsToUint(target);
    bool is_turned = a.x != b.x ? a.x > b.x : a.y != b.y ? a.y > b.y : a.z > b.z;
    uvec3 ends[2] = uvec3[](is_turned ? b : a, is_turned ? a : b);
    uint hash = bvh_mixed(0x2545f491u, surface);
    for (int end = 0; end < 2; ++end)
        for (int axis = 0; axis < 3; ++axis)
            hash = bvh_mixed(hash, ends[end][axis]);
    return hash;
}

// Whether nothing blocks a segment; surfaces that let some of the light through do so by chance.
bool is_open(vec3 origin, vec3 target) {
    vec3 way = target - origin;
    BvhHit hit = BvhHit(~0u, 1.0, 0.0, 0.0);
    BvhHit next;
    bool is_blocked = false;
    bvh_begin(origin, way, 1.0);
    while (!is_blocked && bvh_walk(origin, way, true, hit, next)) {
        float share = bvh_share(next.triangle, next.u, next.v);
        float chance = float(bvh_hash(origin, target, next.triangle)) * (1.0 / 4294967296.0);
        is_blocked = share < 1.0 && !(chance < share);
    }
    return !is_blocked && hit.triangle == ~0u;
}
#endif
