// SPDX-License-Identifier: MIT

// Rays through a WideBvh (wide_bvh.hpp). Whoever includes this has `bvh_nodes` and `bvh_triangles`, arrays of uvec4,
// and these two, which are asked only of triangles that light may pass:
//     bool bvh_is_hole(uint triangle, float u, float v);      for closest_hit: whether a mask has a hole there
//     float bvh_share(uint triangle, float u, float v);       for let_through: the share of light that passes

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

// Embree's test, after Moeller and Trumbore: where the ray meets a triangle, if it does for 0 < t <= reach.
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
    return size > 0.0 && u >= 0.0 && v >= 0.0 && u + v <= size && t > 0.0 && t <= size * reach;
}

// Walks the tree; `act` is done for each triangle that is met, with `triangle`, `is_translucent`, `found` (t, u, v), and
// may shorten `reach` or set `is_done`. A macro, since GLSL has no functions as arguments.
#define BVH_WALK(origin, way, reach, act)                                                        \
    {                                                                                             \
        vec3 inverse = bvh_inverse(way);                                                          \
        uint order = (inverse.x > 0.0 ? 1u : 0u) | (inverse.y > 0.0 ? 2u : 0u) | (inverse.z > 0.0 ? 4u : 0u); \
        uvec2 waiting[MOST_BVH_DEPTH];                                                            \
        int count = 0;                                                                            \
        bool is_done = false;                                                                     \
        uvec4 open = bvh_open(0u, origin, inverse, reach, order);                                \
        while (!is_done) {                                                                        \
            while (open.w != 0u && !is_done) {                                                    \
                uint bit = uint(findLSB(open.w));                                                 \
                open.w &= open.w - 1u;                                                            \
                uint first_word = 3u * (open.z + bit);                                            \
                uvec4 corner_a = bvh_triangles[first_word];                                       \
                uvec4 corner_b = bvh_triangles[first_word + 1u];                                  \
                uvec4 corner_c = bvh_triangles[first_word + 2u];                                  \
                vec3 found;                                                                       \
                if (bvh_meets(corner_a, corner_b, corner_c, origin, way, reach, found)) {        \
                    uint triangle = corner_a.w;                                                   \
                    bool is_translucent = corner_b.w != 0u;                                       \
                    act                                                                           \
                }                                                                                 \
            }                                                                                     \
            if (open.y <= 0x00ffffffu) {                                                          \
                if (count == 0)                                                                   \
                    break;                                                                        \
                open.xy = waiting[--count];                                                       \
            }                                                                                     \
            uint child = uint(findMSB(open.y));                                                   \
            open.y &= ~(1u << child);                                                             \
            if (open.y > 0x00ffffffu)                                                             \
                waiting[count++] = open.xy;                                                       \
            uint slot = child - 24u ^ order;                                                      \
            uint before = uint(bitCount(open.y & 255u & (1u << slot) - 1u));                      \
            open = bvh_open(open.x + before, origin, inverse, reach, order);                     \
        }                                                                                         \
    }

#ifdef BVH_CLOSEST
// The first surface on origin + t * way, 0 < t <= reach, that is no hole of a mask.
BvhHit closest_hit(vec3 origin, vec3 way, float reach) {
    BvhHit hit = BvhHit(~0u, reach, 0.0, 0.0);
    BVH_WALK(origin, way, hit.t,
             if (!is_translucent || !bvh_is_hole(triangle, found.y, found.z))
                 hit = BvhHit(triangle, found.x, found.y, found.z);)
    return hit;
}
#endif

#ifdef BVH_SHARE
// The product of what all surfaces between two points let through.
float let_through(vec3 origin, vec3 target) {
    float share = 1.0;
    vec3 way = target - origin;
    BVH_WALK(origin, way, 1.0,
             share *= is_translucent ? bvh_share(triangle, found.y, found.z) : 0.0;
             is_done = share == 0.0;)
    return share;
}
#endif
