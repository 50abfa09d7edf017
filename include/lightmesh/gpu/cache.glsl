// SPDX-License-Identifier: MIT
// S of a visibility cache in shaders: what `SnapshotView::visibility` says of a cache's snapshot, to the bit.
//
//     #define LIGHTMESH_CACHE_SET 0
//     #define LIGHTMESH_CACHE_BINDING 0          // this storage buffer and the four after it
//     #include <lightmesh/gpu/cache.glsl>
//     bool lightmesh_is_open(vec3 from, vec3 to) { return !...; }    // rays: yours
//
//     LightMeshCachePoint at = lightmesh_cache_point(P, n, footprint, shading_normal);    // 0, vec3(0.0): none
//     LightMeshCacheTile tile;
//     for (uint t = 0u; t < lightmesh_cache_tile_count(); ++t) {     // 64 lights at a time
//         lightmesh_cache_find(at, t, uvec2(~0u), tile);
//         for (uint l = 0u; l < lightmesh_cache_tile_size(t); ++l)
//             if (lightmesh_cache_is_known(tile, l))
//                 color += light[64u * t + l] * lightmesh_cache_share(tile, l);
//     }
//     if (at.lacks != 0u)
//         lightmesh_cache_request(at, pixel);
//
// What is not known is told apart from dark. `at.lacks` says why:
//     lightmesh_cache_lacks_values  the snapshot has no record or no value for it. `VisibilityCache::fill` of the
//                                   requested points finds it for the next snapshot.
//     lightmesh_cache_lacks_rays    it takes rays that no cache keeps: to lamps from the point itself, where no
//                                   record serves it, or where a smooth surface bends away from its facets. And
//                                   against leaks, without lightmesh_is_open. `VisibilityCache::visibility` of the
//                                   requested points has the answer.
//     lightmesh_cache_lacks_place   the point or its normal is not finite, or lies outside the lattice. No request is
//                                   made.
//
// lightmesh_cache_known_of_four and lightmesh_cache_shares_of_four say it of four lights at once.
//
// lightmesh_is_open says whether nothing lies on the segment between two points, as the cache's tracer sees it. It is
// asked for few points, up to eight times for each level of the cache.
//
// Macros, to be defined before the include:
//     LIGHTMESH_CACHE_SET, LIGHTMESH_CACHE_BINDING   where the buffers are bound; 0 and 0
//     LIGHTMESH_NO_RAYS                              there is no lightmesh_is_open: what needs a ray is not known
//
// GLSL 4.5 for Vulkan 1.0: no 64-bit types, no subgroups, no shared memory; in any stage that can write to storage
// buffers. Sums, products and floats of integers must round to nearest, as they do on all GPUs. What decides anything
// is an integer, such a float, or a float with a bound of its error; where that cannot tell, and that is seldom, a double
// by integers (doubles.glsl). One query at a time: it works in variables of this file, where S of a tile stands until
// the next one is asked for.
#ifndef LIGHTMESH_CACHE_GLSL
#define LIGHTMESH_CACHE_GLSL

#include "doubles.glsl"

#ifndef LIGHTMESH_CACHE_SET
#define LIGHTMESH_CACHE_SET 0
#endif
#ifndef LIGHTMESH_CACHE_BINDING
#define LIGHTMESH_CACHE_BINDING 0
#endif

#ifndef LIGHTMESH_NO_RAYS
bool lightmesh_is_open(vec3 from, vec3 to);
#endif

// As `CacheUpload` lays them out. The head:
//     number of lights | number of tiles | number of slots less one | finest level, and 256 with exact edges, 512
//                                          with shaft rows, 1024 if the levels' origins in steps are there
//     how far the lattice reaches from its origin: a double | where lights begin | 0
//     for each level five, and for each one more: see `lightmesh_cache_level_*`
//     lights, six each: see `lightmesh_cache_light_*`
// Slots, of which a key's hash says the first that it may be in, two or more free ones at the end:
//          the three words of a key | where its record stands; 0: free
// Records: position | x and y of the normal
//          z of the normal and links | lattice index and whether it is on a surface | 0 | number of its tiles, that
//          follow: number of the tile and, 24 bits higher, which octets it has | first octet | known lights
// Octets: values of eight lights, a byte each
layout(std430, set = LIGHTMESH_CACHE_SET, binding = LIGHTMESH_CACHE_BINDING) readonly buffer LightMeshCacheHead {
    uvec4 lightmesh_cache_head[];
};
layout(std430, set = LIGHTMESH_CACHE_SET, binding = LIGHTMESH_CACHE_BINDING + 1) readonly buffer LightMeshCacheSlots {
    uvec4 lightmesh_cache_slots[];
};
layout(std430, set = LIGHTMESH_CACHE_SET, binding = LIGHTMESH_CACHE_BINDING + 2) readonly buffer LightMeshCacheRecords {
    uvec4 lightmesh_cache_records[];
};
layout(std430, set = LIGHTMESH_CACHE_SET, binding = LIGHTMESH_CACHE_BINDING + 3) readonly buffer LightMeshCacheOctets {
    uvec2 lightmesh_cache_octets[];
};

struct LightMeshCacheRequest {
    vec4 position;        // w: footprint
    vec4 normal;          // w: bits of the number that the shader gave
    vec4 shading_normal;  // w: bits of what the point lacks
};
layout(std430, set = LIGHTMESH_CACHE_SET, binding = LIGHTMESH_CACHE_BINDING + 4) buffer LightMeshCacheRequests {
    uint lightmesh_cache_request_count;  // of points that asked, also those for which there was no room
    uint lightmesh_cache_request_room;
    uvec2 lightmesh_cache_request_unused;
    LightMeshCacheRequest lightmesh_cache_requests[];
};

const uint lightmesh_cache_lacks_values = 1u;
const uint lightmesh_cache_lacks_rays = 2u;
const uint lightmesh_cache_lacks_place = 4u;

// A surface point with what is the same for all tiles of lights.
struct LightMeshCachePoint {
    vec3 position;
    vec3 normal;  // of length 1, or 0
    float footprint;
    vec3 shading_normal;
    uint lacks;  // so far; 0: all that was asked is known
    // What follows is for the functions here.
    vec3 given_normal;
    vec3 smooth_normal;
    bool is_smooth;
    int full_level;  // the finest level that the footprint lets say all
    int part;        // how much the next one may say, of 2^15
    int first_level;
    int facing_count;
    ivec3 facings;         // 2 axis + (1 if the normal points down)
    ivec3 facing_weights;  // sum to 2^15
    uvec3 traced;       // for each facing: a bit for each level whose rays were traced
    uvec3 seen;         // and four bits: which lattice points the point sees
};

// S of a tile of 64 lights, of which the values stand in variables of this file until the next tile is asked for.
struct LightMeshCacheTile {
    uvec2 unknown;  // lights whose S is not known
    bool is_float;  // whether the values are
};
// Four lights each: of the tile, and in work for the other facings.
uvec4 lightmesh_cache_values[48];

uint lightmesh_cache_light_count() {
    return lightmesh_cache_head[0].x;
}
uint lightmesh_cache_tile_count() {
    return lightmesh_cache_head[0].y;
}
// Lights of a tile.
uint lightmesh_cache_tile_size(uint tile) {
    return min(64u, lightmesh_cache_light_count() - 64u * tile);
}

// True if S of the l-th light of a tile is known.
bool lightmesh_cache_is_known(LightMeshCacheTile tile, uint l) {
    return (((l < 32u ? tile.unknown.x : tile.unknown.y) >> (l & 31u)) & 1u) == 0u;
}

// S of the l-th light of a tile, 0 to 1; without meaning where it is not known.
float lightmesh_cache_share(LightMeshCacheTile tile, uint l) {
    uint value = lightmesh_cache_values[l >> 2][l & 3u];
    precise float share = float(value) * uintBitsToFloat(0x30008081u);  // 2^-23 / 255
    return tile.is_float ? uintBitsToFloat(value) : share;
}

// The same of four lights from the l-th on, a multiple of four: bits of those of which S is known, and S.
uint lightmesh_cache_known_of_four(LightMeshCacheTile tile, uint l) {
    return ~((l < 32u ? tile.unknown.x : tile.unknown.y) >> (l & 31u)) & 15u;
}
vec4 lightmesh_cache_shares_of_four(LightMeshCacheTile tile, uint l) {
    uvec4 values = lightmesh_cache_values[l >> 2];
    precise vec4 shares = vec4(values) * uintBitsToFloat(0x30008081u);  // 2^-23 / 255
    return tile.is_float ? uintBitsToFloat(values) : shares;
}

// Asks for a point. `id` comes back with it.
void lightmesh_cache_request(LightMeshCachePoint at, uint id) {
    if ((at.lacks & ~lightmesh_cache_lacks_place) == 0u)
        return;
    uint i = atomicAdd(lightmesh_cache_request_count, 1u);
    if (i >= lightmesh_cache_request_room)
        return;
    lightmesh_cache_requests[i].position = vec4(at.position, at.footprint);
    lightmesh_cache_requests[i].normal = vec4(at.given_normal, uintBitsToFloat(id));
    lightmesh_cache_requests[i].shading_normal = vec4(at.shading_normal, uintBitsToFloat(at.lacks));
}

// ---- settings

int lightmesh_cache_finest() {
    return int(lightmesh_cache_head[0].w & 255u);
}
bool lightmesh_cache_has_exact_edges() {
    return (lightmesh_cache_head[0].w & 256u) != 0u;
}
bool lightmesh_cache_has_shaft_rows() {
    return (lightmesh_cache_head[0].w & 512u) != 0u;
}
uvec2 lightmesh_cache_level_step(int level) {
    return lightmesh_cache_head[2 + 5 * level].xy;
}
uvec2 lightmesh_cache_level_per_step(int level) {
    return lightmesh_cache_head[2 + 5 * level].zw;
}
uvec2 lightmesh_cache_level_origin(int level, int axis) {
    uvec4 two = lightmesh_cache_head[3 + 5 * level + (axis >> 1)];
    return (axis & 1) == 0 ? two.xy : two.zw;
}
// .45 steps: where records no longer fit; 5 / step; .003 steps.
uvec2 lightmesh_cache_level_near(int level) {
    return lightmesh_cache_head[4 + 5 * level].zw;
}
uvec2 lightmesh_cache_level_per_fifth(int level) {
    return lightmesh_cache_head[5 + 5 * level].xy;
}
uvec2 lightmesh_cache_level_least(int level) {
    return lightmesh_cache_head[5 + 5 * level].zw;
}
// Floats: .002 steps; 2^-14 steps.
vec2 lightmesh_cache_level_floats(int level) {
    return uintBitsToFloat(lightmesh_cache_head[6 + 5 * level].xy);
}
// The origin in steps, of 2^32: 64 bits, the lower word first.
uvec2 lightmesh_cache_level_origin_in_steps(int level, int axis) {
    uvec4 two = lightmesh_cache_head[axis == 0 ? 6 + 5 * level : 82 + level];
    return axis == 1 ? two.xy : two.zw;
}

// ---- vectors

// Three, which a compiler does not know: what is large, and stands in a loop of three turns, stays in there once.
int lightmesh_cache_three() {
    return 3 + int(lightmesh_cache_head[1].w);
}

const uvec2 lightmesh_cache_one = uvec2(0u, 0x3ff00000u);
const uvec2 lightmesh_cache_nine_tenths = uvec2(0xcccccccdu, 0x3fecccccu);

bool lightmesh_cache_is_finite(vec3 v) {
    uvec3 exponents = floatBitsToUint(v) & 0x7f800000u;
    return max(max(exponents.x, exponents.y), exponents.z) != 0x7f800000u;
}

bool lightmesh_cache_is_zero(vec3 v) {
    uvec3 magnitudes = floatBitsToUint(v) & 0x7fffffffu;
    return (magnitudes.x | magnitudes.y | magnitudes.z) == 0u;
}

float lightmesh_cache_largest(vec3 v) {
    return max(max(abs(v.x), abs(v.y)), abs(v.z));
}

float lightmesh_cache_dot(vec3 a, vec3 b) {
    precise float sum = (a.x * b.x + a.y * b.y) + a.z * b.z;
    return sum;
}

struct LightMeshCacheDoubles {
    uvec2 x, y, z;
};

LightMeshCacheDoubles lightmesh_cache_doubles(vec3 v) {
    return LightMeshCacheDoubles(lightmesh_double_of(v.x), lightmesh_double_of(v.y), lightmesh_double_of(v.z));
}

uvec2 lightmesh_cache_pick(LightMeshCacheDoubles v, int i) {
    return i == 0 ? v.x : i == 1 ? v.y : v.z;
}

// a . b, added from the first component to the last.
uvec2 lightmesh_cache_double_dot(LightMeshCacheDoubles a, LightMeshCacheDoubles b) {
    uvec2 sum = uvec2(0u);
    for (int i = 0; i < lightmesh_cache_three(); ++i)
        sum = lightmesh_double_add(sum,
                                   lightmesh_double_multiply(lightmesh_cache_pick(a, i), lightmesh_cache_pick(b, i)));
    return sum;
}

// a - b, by turning: each difference enters behind the others.
LightMeshCacheDoubles lightmesh_cache_double_differences(LightMeshCacheDoubles a, LightMeshCacheDoubles b) {
    LightMeshCacheDoubles differences = a;
    for (int i = 0; i < lightmesh_cache_three(); ++i)
        differences = LightMeshCacheDoubles(
            differences.y, differences.z,
            lightmesh_double_subtract(lightmesh_cache_pick(a, i), lightmesh_cache_pick(b, i)));
    return differences;
}

LightMeshCacheDoubles lightmesh_cache_double_cross(LightMeshCacheDoubles a, LightMeshCacheDoubles b) {
    LightMeshCacheDoubles across = a;
    for (int i = 0; i < lightmesh_cache_three(); ++i) {
        int u = i == 2 ? 0 : i + 1, v = i == 0 ? 2 : i - 1;
        across = LightMeshCacheDoubles(
            across.y, across.z,
            lightmesh_double_subtract(
                lightmesh_double_multiply(lightmesh_cache_pick(a, u), lightmesh_cache_pick(b, v)),
                lightmesh_double_multiply(lightmesh_cache_pick(b, u), lightmesh_cache_pick(a, v))));
    }
    return across;
}

// The vector at length 1, with every step rounded as a processor does; zero stays zero.
vec3 lightmesh_cache_unit(vec3 v) {
    float largest = lightmesh_cache_largest(v);
    if (!(largest > 0.0))
        return vec3(0.0);
    vec3 parts = vec3(lightmesh_float_divide(v.x, largest), lightmesh_float_divide(v.y, largest),
                      lightmesh_float_divide(v.z, largest));
    float scale = lightmesh_float_divide(1.0, lightmesh_float_sqrt(lightmesh_cache_dot(parts, parts)));
    precise vec3 unit = parts * scale;
    return unit;
}

// True if the length of a vector is 1 but for rounding.
bool lightmesh_cache_is_unit(vec3 v) {
    float about = lightmesh_cache_dot(v, v) - 1.0;
    if (!(abs(about) < 1e-5))
        return false;
    if (abs(about) < 1e-7)
        return true;
    // The sum of the squares, of 2^62, less one.
    uvec3 sizes = uvec3(abs(v) * 2147483648.0), high, low;
    umulExtended(sizes, sizes, high, low);
    uint sum = low.x + low.y;
    uint more = sum < low.x ? 1u : 0u;
    sum += low.z;
    more += sum < low.z ? 1u : 0u;
    int over = int(high.x + high.y + high.z + more - 0x40000000u);
    float off = abs(float(over) + float(sum) * uintBitsToFloat(0x2f800000u)) * uintBitsToFloat(0x30800000u);
    if (abs(off - 3e-7) > 2e-10)
        return off < 3e-7;
    LightMeshCacheDoubles doubles = lightmesh_cache_doubles(v);
    uvec2 exact = lightmesh_double_subtract(lightmesh_cache_double_dot(doubles, doubles), lightmesh_cache_one);
    return lightmesh_double_less(lightmesh_double_abs(exact), uvec2(0xf40d8376u, 0x3e9421f5u));  // 3e-7
}

// Four vectors, by their components.
struct LightMeshCacheFour {
    vec4 x, y, z;
};

vec4 lightmesh_cache_dots(LightMeshCacheFour a, LightMeshCacheFour b) {
    precise vec4 sums = (a.x * b.x + a.y * b.y) + a.z * b.z;
    return sums;
}

LightMeshCacheFour lightmesh_cache_four(vec3 v) {
    return LightMeshCacheFour(vec4(v.x), vec4(v.y), vec4(v.z));
}

LightMeshCacheFour lightmesh_cache_differences(LightMeshCacheFour a, LightMeshCacheFour b) {
    precise vec4 x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
    return LightMeshCacheFour(x, y, z);
}

// The lowest bits of four words.
uint lightmesh_cache_bits(uvec4 words) {
    return (words.x & 1u) | (words.y & 1u) << 1 | (words.z & 1u) << 2 | (words.w & 1u) << 3;
}

// A position moved off its surface.
vec3 lightmesh_cache_off_surface(vec3 position, vec3 normal, int level) {
    precise vec3 moved = position + (lightmesh_cache_largest(position) * uintBitsToFloat(0x35800000u) +
                                  lightmesh_cache_level_floats(level).y) * normal;
    return moved;
}

// ---- which records serve a point

float lightmesh_cache_pick(vec3 v, int i) {
    return i == 0 ? v.x : i == 1 ? v.y : v.z;
}
uint lightmesh_cache_pick(uvec4 v, int i) {
    return i == 0 ? v.x : i == 1 ? v.y : i == 2 ? v.z : v.w;
}
int lightmesh_cache_pick(ivec4 v, int i) {
    return i == 0 ? v.x : i == 1 ? v.y : i == 2 ? v.z : v.w;
}

// Weights are of 2^15.
int lightmesh_cache_weight_of(uvec2 share) {
    if (lightmesh_double_is_negative(share))
        return 0;
    if (!lightmesh_double_less(share, lightmesh_cache_one))
        return 32768;
    return lightmesh_double_floor(lightmesh_double_add(lightmesh_double_scale(share, 15), uvec2(0u, 0x3fe00000u)));
}

// The weight of (a / b - less) / by.
int lightmesh_cache_weight_of_quotient(uvec2 a, uvec2 b, uvec2 less, uvec2 by) {
    uvec2 share = a;
    for (int i = 1; i < lightmesh_cache_three(); ++i) {
        share = lightmesh_double_divide(share, i == 1 ? b : by);
        if (i == 1)
            share = lightmesh_double_subtract(share, less);
    }
    return lightmesh_cache_weight_of(share);
}

// The weights of levels, by the footprint: less within the last fifth of an octave, which is one level at most.
void lightmesh_cache_find_levels(inout LightMeshCachePoint at) {
    at.full_level = 15;
    at.part = 0;
    at.first_level = 9;
    if (!(at.footprint > 0.0))
        return;
    uvec2 footprint = lightmesh_double_of(at.footprint);
    uvec2 more = lightmesh_double_multiply(uvec2(0x66666666u, 0x3ff26666u), footprint);  // 1.15
    // The finest level of a greater step; each has half the step of the one before.
    uvec2 coarsest = lightmesh_cache_level_step(0);
    uvec2 aligned = uvec2(more.x, (more.y & 0x000fffffu) | (coarsest.y & 0xfff00000u));
    at.full_level = clamp(lightmesh_double_exponent(coarsest) - lightmesh_double_exponent(more) -
                              (lightmesh_double_less(aligned, coarsest) ? 0 : 1),
                          -1, 15);
    at.first_level = clamp(at.full_level, 0, 9);
    if (at.full_level == 15)
        return;
    uvec2 step = lightmesh_cache_level_step(at.full_level + 1);
    if (!lightmesh_double_less(footprint, step))
        return;
    // (step / footprint - 1) / .1487, first in floats: a step has 24 bits, and is less than twice the footprint.
    uint of_step = lightmesh_double_bits(step).y >> 8, of_footprint = lightmesh_double_bits(footprint).y >> 8;
    if (((step.y ^ footprint.y) & 0x00100000u) != 0u)
        of_step <<= 1;
    float weight = 220363.1473 * (float(of_step - of_footprint) / float(of_footprint)) + 0.5;
    int least = int(min(weight - 0.03, 32768.0));
    at.part = int(min(weight + 0.03, 32768.0));
    if (at.part != least)
        at.part = lightmesh_cache_weight_of_quotient(step, footprint, lightmesh_cache_one,
                                                     uvec2(0x02752546u, 0x3fc3089au));
    // So near to the whole that it is rounded to it.
    if (at.part == 32768) {
        at.first_level = min(++at.full_level, 9);
        at.part = 0;
    }
}

int lightmesh_cache_share_of(LightMeshCachePoint at, int level) {
    return level <= at.full_level ? 32768 : level == at.full_level + 1 ? at.part : 0;
}

// The weight of (component / largest - .9) / .1, 0 to 2^15: one less ten times what is missing, by integers. A
// component has at least .899 of the largest.
int lightmesh_cache_facing_weight(float component, float largest) {
    uint c = floatBitsToUint(component), l = floatBitsToUint(largest);
    uint of_largest = ((l & 0x7fffffu) | 0x800000u) << ((l >> 23) - (c >> 23));
    uint missing = of_largest - ((c & 0x7fffffu) | 0x800000u);
    float by = float(of_largest);
    uint less = uint(327680.0 * float(missing) / by);
    int rest = int(327680u * missing - less * of_largest);
    if (rest < 0) {
        --less;
        rest += int(of_largest);
    } else if (rest >= int(of_largest)) {
        ++less;
        rest -= int(of_largest);
    }
    float over = 0.5 - float(rest) / by;
    if (abs(over) < 1e-5)
        return lightmesh_cache_weight_of_quotient(lightmesh_double_of(component), lightmesh_double_of(largest),
                                                  lightmesh_cache_nine_tenths, uvec2(0x9999999au, 0x3fb99999u));
    return max(32768 - int(less) - (over < 0.0 ? 1 : 0), 0);
}

// The facings of records.
void lightmesh_cache_find_ways(inout LightMeshCachePoint at) {
    at.facing_count = 0;
    if (lightmesh_cache_is_zero(at.normal))
        return;
    float largest = lightmesh_cache_largest(at.normal);
    int sum = 0;
    for (int axis = 0; axis < lightmesh_cache_three(); ++axis) {
        float signed_component = lightmesh_cache_pick(at.normal, axis), component = abs(signed_component);
        int weight = component == largest ? 32768 : 0;
        if (component != largest && component >= 0.899 * largest)
            weight = lightmesh_cache_facing_weight(component, largest);
        if (weight == 0)
            continue;
        int facing = 2 * axis + (signed_component < 0.0 ? 1 : 0);
        if (at.facing_count == 0) {
            at.facings.x = facing;
            at.facing_weights.x = weight;
        } else if (at.facing_count == 1) {
            at.facings.y = facing;
            at.facing_weights.y = weight;
        } else {
            at.facings.z = facing;
            at.facing_weights.z = weight;
        }
        ++at.facing_count;
        sum += weight;
    }
    uint y = (uint(at.facing_weights.y) << 15) / uint(sum), z = (uint(at.facing_weights.z) << 15) / uint(sum);
    at.facing_weights = ivec3(32768u - y - z, y, z);
}

// True if lattice points around the point have indices.
bool lightmesh_cache_is_inside(vec3 position) {
    int finest = lightmesh_cache_finest();
    uvec2 limit = lightmesh_cache_head[1].xy;
    float farthest = 0.0;
    for (int axis = 0; axis < 3; ++axis)
        farthest = max(farthest, abs(position[axis]) +
                                     abs(lightmesh_double_to_float(lightmesh_cache_level_origin(finest, axis))));
    if (farthest < 0.99 * lightmesh_double_to_float(limit))
        return true;
    bool is_inside = true;
    for (int axis = 0; axis < lightmesh_cache_three(); ++axis) {
        uvec2 offset = lightmesh_double_subtract(lightmesh_double_of(lightmesh_cache_pick(position, axis)),
                                                 lightmesh_cache_level_origin(finest, axis));
        is_inside = is_inside && lightmesh_double_less(lightmesh_double_abs(offset), limit);
    }
    return is_inside;
}

// A point to ask for. The normal is the geometric one, on the side that is shaded. Footprint and shading normal as in
// `SurfacePoint`: 0 if there is none.
LightMeshCachePoint lightmesh_cache_point(vec3 position, vec3 normal, float footprint, vec3 shading_normal) {
    LightMeshCachePoint at;
    at.position = position;
    at.given_normal = normal;
    at.footprint = footprint > 0.0 ? footprint : 0.0;
    at.shading_normal = shading_normal;
    at.normal = normal;
    at.smooth_normal = vec3(0.0);
    at.is_smooth = false;
    at.facing_count = 0;
    at.facings = at.facing_weights = ivec3(0);
    at.traced = at.seen = uvec3(0u);
    at.lacks = 0u;
    lightmesh_cache_find_levels(at);
    if (!lightmesh_cache_is_finite(position) || !lightmesh_cache_is_finite(normal) ||
        !lightmesh_cache_is_inside(position)) {
        at.lacks = lightmesh_cache_lacks_place;
        return at;
    }
    bool has_smooth = lightmesh_cache_is_finite(shading_normal) && !lightmesh_cache_is_zero(shading_normal);
    for (int i = 1; i < lightmesh_cache_three(); ++i) {
        if (i == 1 ? lightmesh_cache_is_unit(normal) : !has_smooth)
            continue;
        vec3 unit = lightmesh_cache_unit(i == 1 ? normal : shading_normal);
        if (i == 1)
            at.normal = unit;
        else
            at.smooth_normal = unit;
    }
    float cosine = lightmesh_cache_dot(at.smooth_normal, at.normal);
    at.is_smooth = cosine > 0.0 && cosine < uintBitsToFloat(0x3f7fffefu);  // .999999
    lightmesh_cache_find_ways(at);
    return at;
}

// ---- lights: at, bits of the kind | range, 0, extent | axis of the cone (doubles), squared tangent | half sides

const uint lightmesh_cache_directional = 1u;
const uint lightmesh_cache_has_cone = 2u;
const uint lightmesh_cache_wide_cone = 4u;
const uint lightmesh_cache_rectangle = 8u;
const uint lightmesh_cache_has_range = 16u;

uvec4 lightmesh_cache_light(uint light, uint part) {
    return lightmesh_cache_head[lightmesh_cache_head[1].z + 6u * light + part];
}

uvec2 lightmesh_cache_double_square(uvec2 a) {
    return lightmesh_double_multiply(a, a);
}

// In floats where those are sure, else in doubles.
bool lightmesh_cache_faces(vec3 at, bool is_directional, vec3 point, vec3 normal) {
    precise vec3 offset = at - (is_directional ? vec3(0.0) : point);
    precise vec3 products = normal * offset;
    precise float sum = products.x + products.y + products.z;
    float size = abs(products.x) + abs(products.y) + abs(products.z);
    float far = lightmesh_cache_largest(at) + (is_directional ? 0.0 : lightmesh_cache_largest(point));
    if (abs(sum) > 1e-6 * size + 1e-14 * far + 1e-36)
        return sum > 0.0;
    uvec2 of_light = uvec2(0u), of_point = uvec2(0u);
    for (int i = 1; i < lightmesh_cache_three(); ++i) {
        of_light = of_point;
        of_point = lightmesh_cache_double_dot(
            lightmesh_cache_doubles(i == 1 ? at : is_directional ? vec3(0.0) : point), lightmesh_cache_doubles(normal));
    }
    return !lightmesh_double_less(of_light, of_point);
}

bool lightmesh_cache_in_range(vec3 at, float range, vec3 point) {
    if (range < 0.0)
        return false;
    precise vec3 offset = at - point;
    float squared = dot(offset, offset), limit = range * range;
    if (abs(squared - limit) > 1e-6 * limit + 1e-36)
        return squared < limit;
    LightMeshCacheDoubles doubles = lightmesh_cache_doubles(offset);
    return !lightmesh_double_less(lightmesh_cache_double_square(lightmesh_double_of(range)),
                                  lightmesh_cache_double_dot(doubles, doubles));
}

// In floats where those are sure, else in doubles.
bool lightmesh_cache_in_cone(uint light, bool is_wide, vec3 offset) {
    uvec4 first = lightmesh_cache_light(light, 2u), second = lightmesh_cache_light(light, 3u);
    vec3 about = vec3(lightmesh_double_to_float(first.xy), lightmesh_double_to_float(first.zw),
                      lightmesh_double_to_float(second.xy));
    float slope = lightmesh_double_to_float(second.zw);
    float before = dot(about, offset);
    vec3 beside = cross(about, offset);
    float over = dot(beside, beside) - slope * before * before;
    bool is_front = before > 2e-6 * (abs(offset.x) + abs(offset.y) + abs(offset.z)) + 1e-30;
    bool is_back = before < -2e-6 * (abs(offset.x) + abs(offset.y) + abs(offset.z)) - 1e-30;
    if (is_wide ? is_front : is_back)
        return is_wide;
    if ((is_wide ? is_back : is_front) && abs(over) > (1e-5 * dot(offset, offset) + 1e-30) * (1.0 + slope))
        return (over < 0.0) != is_wide;
    LightMeshCacheDoubles axis = LightMeshCacheDoubles(first.xy, first.zw, second.xy);
    LightMeshCacheDoubles w = lightmesh_cache_doubles(offset);
    uvec2 along = lightmesh_cache_double_dot(axis, w);
    bool is_before = !lightmesh_double_less(along, uvec2(0u));
    if (is_before == is_wide)
        return is_wide;
    LightMeshCacheDoubles across = lightmesh_cache_double_cross(axis, w);
    uvec2 squared = lightmesh_cache_double_dot(across, across);
    uvec2 limit = second.zw;
    for (int i = 1; i < lightmesh_cache_three(); ++i)
        limit = lightmesh_double_multiply(limit, along);
    return is_wide ? !lightmesh_double_less(squared, limit) : !lightmesh_double_less(limit, squared);
}

bool lightmesh_cache_can_reach(uint light, vec3 point, vec3 normal) {
    uvec4 head = lightmesh_cache_light(light, 0u);
    vec3 at = uintBitsToFloat(head.xyz);
    uint kind = head.w;
    if (!lightmesh_cache_faces(at, (kind & lightmesh_cache_directional) != 0u, point, normal))
        return false;
    if ((kind & lightmesh_cache_has_range) != 0u &&
        !lightmesh_cache_in_range(at, uintBitsToFloat(lightmesh_cache_light(light, 1u).x), point))
        return false;
    precise vec3 offset = point - at;
    return (kind & lightmesh_cache_has_cone) == 0u ||
           lightmesh_cache_in_cone(light, (kind & lightmesh_cache_wide_cone) != 0u, offset);
}

bool lightmesh_cache_has(uvec2 lights, uint l) {
    return (((l < 32u ? lights.x : lights.y) >> (l & 31u)) & 1u) != 0u;
}
void lightmesh_cache_add(inout uvec2 lights, uint l) {
    if (l < 32u)
        lights.x |= 1u << l;
    else
        lights.y |= 1u << (l - 32u);
}

// Which of four lights can reach the point, as far as floats tell; in the four bits above, of which they do not, or
// cones have a say.
uint lightmesh_cache_four_reaching(uint light, uint last, vec3 point, float size_of_point, vec3 normal) {
    uint first = lightmesh_cache_head[1].z;
    uvec4 at = first + 6u * min(light + uvec4(0u, 1u, 2u, 3u), uvec4(last));
    uvec4 x = lightmesh_cache_head[at.x], y = lightmesh_cache_head[at.y], z = lightmesh_cache_head[at.z],
          w = lightmesh_cache_head[at.w];
    uvec4 kinds = uvec4(x.w, y.w, z.w, w.w);
    LightMeshCacheFour places = LightMeshCacheFour(uintBitsToFloat(uvec4(x.x, y.x, z.x, w.x)),
                                                   uintBitsToFloat(uvec4(x.y, y.y, z.y, w.y)),
                                                   uintBitsToFloat(uvec4(x.z, y.z, z.z, w.z)));
    vec4 has_place = vec4(equal(kinds & lightmesh_cache_directional, uvec4(0u)));
    LightMeshCacheFour offsets = lightmesh_cache_differences(
        places, LightMeshCacheFour(has_place * point.x, has_place * point.y, has_place * point.z));
    precise vec4 to_x = normal.x * offsets.x, to_y = normal.y * offsets.y, to_z = normal.z * offsets.z;
    precise vec4 sum = to_x + to_y + to_z;
    vec4 size = abs(to_x) + abs(to_y) + abs(to_z);
    vec4 far = max(max(abs(places.x), abs(places.y)), abs(places.z)) + has_place * size_of_point;
    uint facing = lightmesh_cache_bits(uvec4(greaterThan(sum, vec4(0.0)))),
         unsure = lightmesh_cache_bits(uvec4(not(greaterThan(abs(sum), 1e-6 * size + 1e-14 * far + 1e-36))));
    uvec4 has_range = kinds & lightmesh_cache_has_range;
    if ((has_range.x | has_range.y | has_range.z | has_range.w) != 0u) {
        vec4 range = uintBitsToFloat(uvec4(lightmesh_cache_head[at.x + 1u].x, lightmesh_cache_head[at.y + 1u].x,
                                           lightmesh_cache_head[at.z + 1u].x, lightmesh_cache_head[at.w + 1u].x));
        vec4 squared = lightmesh_cache_dots(offsets, offsets), limit = range * range;
        uint ranged = lightmesh_cache_bits(has_range >> 4);
        facing &= ~ranged | lightmesh_cache_bits(uvec4(lessThan(squared, limit)) &
                                                 uvec4(greaterThanEqual(range, vec4(0.0))));
        unsure |= ranged & lightmesh_cache_bits(uvec4(not(greaterThan(abs(squared - limit), 1e-6 * limit + 1e-36))));
    }
    unsure |= facing & lightmesh_cache_bits(kinds >> 1);
    return facing | unsure << 4;
}

// Which of the asked lights of a tile can reach the point, chi of equation (3), range and cone: by its normal, and by
// its smooth one.
uvec4 lightmesh_cache_reaching(uint tile, uvec2 asked, LightMeshCachePoint at) {
    uvec4 found = uvec4(0u);
    uint turns = at.is_smooth ? 2u : 1u, count = lightmesh_cache_tile_size(tile), last = 64u * tile + count - 1u;
    float size_of_point = lightmesh_cache_largest(at.position);
    for (uint turn = 0u; turn < turns; ++turn) {
        vec3 normal = turn == 0u ? at.normal : at.smooth_normal;
        uvec2 reaching = uvec2(0u), unsure = uvec2(0u);
        for (uint l = 0u; l < count; l += 4u) {
            uint four = lightmesh_cache_four_reaching(64u * tile + l, last, at.position, size_of_point, normal);
            uint shift = l & 31u;
            reaching |= l < 32u ? uvec2((four & 15u) << shift, 0u) : uvec2(0u, (four & 15u) << shift);
            unsure |= l < 32u ? uvec2(four >> 4 << shift, 0u) : uvec2(0u, four >> 4 << shift);
        }
        unsure &= asked;
        reaching &= asked & ~unsure;
        while ((unsure.x | unsure.y) != 0u) {
            uint l = uint(unsure.x != 0u ? findLSB(unsure.x) : 32 + findLSB(unsure.y));
            unsure = unsure.x != 0u ? uvec2(unsure.x & (unsure.x - 1u), unsure.y)
                                    : uvec2(0u, unsure.y & (unsure.y - 1u));
            if (lightmesh_cache_can_reach(64u * tile + l, at.position, normal))
                lightmesh_cache_add(reaching, l);
        }
        found = turn == 0u ? uvec4(reaching, 0u, 0u) : uvec4(found.xy, reaching);
    }
    return found;
}

// ---- records

// The key of a cell: a facing, and the axis of that.
int lightmesh_cache_axis(int facing) {
    return facing >> 1;
}
// A vector's components along the facing's axis, and along the two that follow in cyclic order; and back.
vec3 lightmesh_cache_turned(vec3 v, int axis) {
    return axis == 0 ? v : axis == 1 ? v.yzx : v.zxy;
}
ivec3 lightmesh_cache_turned_back(ivec3 v, int axis) {
    return axis == 0 ? v : axis == 1 ? v.zxy : v.yzx;
}

uint lightmesh_cache_hash(uvec3 key) {
    uint hash = key.x * 0x8da6b343u + key.y * 0xd8163841u + key.z * 0xcb1ab31fu;
    hash = (hash ^ hash >> 15) * 0x2c1b3c6du;
    return hash ^ hash >> 13;
}

uvec3 lightmesh_cache_key(ivec3 index, uint what, int level) {
    uvec3 key = uvec3(index) & 0x07ffffffu;
    key.x |= what << 27;
    key.y |= uint(level) << 27;
    return key;
}

// The answer of two slots about a key: where its record stands, 0 if it has none, and ~0 if the slots that follow tell.
uint lightmesh_cache_look(uvec3 key, uint slot) {
    uvec4 a = lightmesh_cache_slots[slot], b = lightmesh_cache_slots[slot + 1u];
    uint second = b.w == 0u || b.xyz == key ? b.w : ~0u;
    return a.w == 0u || a.xyz == key ? a.w : second;
}

// The place of a key's record, or 0. `what`: kind and facing.
uint lightmesh_cache_find_record(ivec3 index, uint what, int level) {
    uvec3 key = lightmesh_cache_key(index, what, level);
    uint slot = lightmesh_cache_hash(key) & lightmesh_cache_head[0].z;
    // Not a loop that is left from within: there lavapipe of Mesa 22.3 misses keys.
    uint record = lightmesh_cache_look(key, slot);
    while (record == ~0u) {
        slot += 2u;
        record = lightmesh_cache_look(key, slot);
    }
    return record;
}

vec3 lightmesh_cache_record_position(uint record) {
    return uintBitsToFloat(lightmesh_cache_records[record].xyz);
}
vec4 lightmesh_cache_unit_floats(ivec4 components) {
    precise vec4 floats = vec4(components) * uintBitsToFloat(0x38000100u);  // 1 / 32767
    return floats;
}
// Zero: there is no surface.
vec3 lightmesh_cache_record_normal(uint record) {
    uint xy = lightmesh_cache_records[record].w;
    uvec4 more = lightmesh_cache_records[record + 1u];
    if ((more.y & 1u) == 0u)
        return vec3(0.0);
    return lightmesh_cache_unit_floats(ivec4(int(xy << 16) >> 16, int(xy) >> 16, int(more.x << 16) >> 16, 0)).xyz;
}

// The tile of a record's values: what lightmesh_cache_records says, 0 if nothing is known. Mostly it is the first one:
// it is read along, also where a record has none.
uvec4 lightmesh_cache_record_row(uint record, uint tile) {
    uint count = lightmesh_cache_records[record + 1u].w;
    uvec4 row = lightmesh_cache_records[record + 2u];
    for (uint i = 1u; i < count && (row.x & 0x00ffffffu) != tile; ++i)
        row = lightmesh_cache_records[record + 2u + i];
    return count != 0u && (row.x & 0x00ffffffu) == tile ? row : uvec4(0u);
}

// The values of the eight lights of an octet of a tile, a byte each; 0 where they are not known. `row`: the octets that
// there are, and the first one of them.
uvec2 lightmesh_cache_row_octet(uint octets, uint first, uint octet) {
    if (((octets >> octet) & 1u) == 0u)
        return uvec2(0u);
    return lightmesh_cache_octets[first + uint(bitCount(octets & ((1u << octet) - 1u)))];
}

// Of four taps' tiles the first octets, which octets there are, eight bits each, and which lights are known to all.
struct LightMeshCacheRows {
    uvec4 firsts;
    uint octets;
    uvec2 known;
};

LightMeshCacheRows lightmesh_cache_rows_of(uvec4 taps, uint tile) {
    uvec4 x = lightmesh_cache_record_row(taps.x, tile), y = lightmesh_cache_record_row(taps.y, tile),
          z = lightmesh_cache_record_row(taps.z, tile), w = lightmesh_cache_record_row(taps.w, tile);
    return LightMeshCacheRows(
        uvec4(x.y, y.y, z.y, w.y),
        x.x >> 24 | (y.x & 0xff000000u) >> 16 | (z.x & 0xff000000u) >> 8 | (w.x & 0xff000000u),
        x.zw & y.zw & z.zw & w.zw);
}

// The words of the first four, and of the other lights of an octet.
void lightmesh_cache_read_octets(LightMeshCacheRows rows, uint octet, out uvec4 low, out uvec4 high) {
    uvec2 x = lightmesh_cache_row_octet(rows.octets & 255u, rows.firsts.x, octet),
          y = lightmesh_cache_row_octet(rows.octets >> 8 & 255u, rows.firsts.y, octet),
          z = lightmesh_cache_row_octet(rows.octets >> 16 & 255u, rows.firsts.z, octet),
          w = lightmesh_cache_row_octet(rows.octets >> 24, rows.firsts.w, octet);
    low = uvec4(x.x, y.x, z.x, w.x);
    high = uvec4(x.y, y.y, z.y, w.y);
}

// ---- a cell of four records

struct LightMeshCacheCell {
    ivec2 corner;  // the least indices along u and v
    ivec4 along;   // the indices along the axis of the records' facing
    ivec2 at;      // the point's coordinates in the cell, of 2^15
    uvec4 records;
    uint links;    // four bits: 0-1, 2-3, 0-2, 1-3
    // The records that serve the point, on surfaces and in the air; where there is none, another one with weight 0.
    uvec4 taps;
    uvec4 air_taps;
    uvec4 weights;  // sum to 2^15, with those in the air
    uvec4 air_weights;
    bool has_taps;
    bool has_surface_taps;
    bool has_air_taps;
    uint missing;  // least share of the next level for lights that any of the records sees
    uint covered;  // how far the point may be covered by something thin, see `make_taps` of the library
    uint lacks;    // why it is not known
};
// The one in work: passed from function to function it would be copied.
LightMeshCacheCell lightmesh_cache_cell;

ivec3 lightmesh_cache_index(int k, int axis) {
    return lightmesh_cache_turned_back(ivec3(lightmesh_cache_pick(lightmesh_cache_cell.along, k),
                                             lightmesh_cache_cell.corner.x + (k & 1),
                                             lightmesh_cache_cell.corner.y + (k >> 1)),
                                       axis);
}

// The places of the records of the four corners, or 0, side by side: it is memory that takes the time.
uvec4 lightmesh_cache_find_records(int axis, uint what, int level) {
    uvec3 x = lightmesh_cache_key(lightmesh_cache_index(0, axis), what, level),
          y = lightmesh_cache_key(lightmesh_cache_index(1, axis), what, level),
          z = lightmesh_cache_key(lightmesh_cache_index(2, axis), what, level),
          w = lightmesh_cache_key(lightmesh_cache_index(3, axis), what, level);
    uvec4 slots = uvec4(lightmesh_cache_hash(x), lightmesh_cache_hash(y), lightmesh_cache_hash(z),
                        lightmesh_cache_hash(w)) &
                  lightmesh_cache_head[0].z;
    uvec4 records = uvec4(lightmesh_cache_look(x, slots.x), lightmesh_cache_look(y, slots.y),
                          lightmesh_cache_look(z, slots.z), lightmesh_cache_look(w, slots.w));
    while (any(equal(records, uvec4(~0u)))) {
        slots += 2u;
        if (records.x == ~0u)
            records.x = lightmesh_cache_look(x, slots.x);
        if (records.y == ~0u)
            records.y = lightmesh_cache_look(y, slots.y);
        if (records.z == ~0u)
            records.z = lightmesh_cache_look(z, slots.z);
        if (records.w == ~0u)
            records.w = lightmesh_cache_look(w, slots.w);
    }
    return records;
}

// origin + step * index as the nearest float, in pairs of floats; whether that is sure: of a double between it makes no
// difference then.
float lightmesh_cache_lattice_component(int index, uvec2 origin, float step, inout bool is_sure) {
    vec2 product = lightmesh_product(step, float(index));
    // The origin's first 24 bits, and what follows.
    uint exponent = (origin.y >> 20) & 0x7ffu;
    uint high_bits = (origin.y & 0x80000000u) | (((origin.y & 0x7fffffffu) - 0x38000000u) << 3 | origin.x >> 29);
    bool is_normal = exponent >= 980u && exponent < 1100u;
    float high = is_normal ? uintBitsToFloat(high_bits) : 0.0;
    float low = is_normal ? float(origin.x & 0x1fffffffu) * uintBitsToFloat((exponent - 948u) << 23) : 0.0;
    low = (origin.y & 0x80000000u) != 0u ? -low : low;
    precise float sum = high + product.x, part = sum - high;
    precise float rest = ((high - (sum - part)) + (product.x - part)) + (low + product.y);
    precise float point = sum + rest;
    precise float slack = (abs(high) + abs(product.x)) * uintBitsToFloat(0x29800000u);  // 2^-44
    precise float least = sum + (rest - slack), most = sum + (rest + slack);
    is_sure = is_sure && (is_normal || origin.y == 0u) && abs(index) < 0x1000000 && step > 1e-20 && step < 1e20 &&
              least == most;
    return point;
}

vec3 lightmesh_cache_lattice_point(ivec3 index, int level) {
    float step = lightmesh_double_to_float(lightmesh_cache_level_step(level));
    bool is_sure = true;
    vec3 point = vec3(
        lightmesh_cache_lattice_component(index.x, lightmesh_cache_level_origin(level, 0), step, is_sure),
        lightmesh_cache_lattice_component(index.y, lightmesh_cache_level_origin(level, 1), step, is_sure),
        lightmesh_cache_lattice_component(index.z, lightmesh_cache_level_origin(level, 2), step, is_sure));
    for (int axis = 0; axis < lightmesh_cache_three() && !is_sure; ++axis) {
        float component = lightmesh_double_to_float(lightmesh_double_add(
            lightmesh_cache_level_origin(level, axis),
            lightmesh_double_multiply(
                lightmesh_cache_level_step(level),
                lightmesh_double_of(axis == 0 ? index.x : axis == 1 ? index.y : index.z))));
        point = vec3(axis == 0 ? component : point.x, axis == 1 ? component : point.y, axis == 2 ? component : point.z);
    }
    return point;
}

// ---- where the point lies: coordinates in steps, with 32 bits behind the point, of which all but some of the lowest
// are sure; and in doubles where those decide.

// 64 bits, the lower word first; `slack`: how far that may be from what doubles have.
uvec2 lightmesh_cache_located(float position, int level, int axis, out uint slack) {
    uvec2 per_step = lightmesh_cache_level_per_step(level), factor = lightmesh_double_bits(per_step);
    uint bits = floatBitsToUint(position), exponent = (bits >> 23) & 255u, high, low, higher, lower;
    uint mantissa = exponent == 0u ? 0u : 0x80000000u | bits << 8;
    umulExtended(mantissa, factor.y, high, low);
    umulExtended(mantissa, factor.x, higher, lower);
    low += higher;
    high += low < higher ? 1u : 0u;
    // Of 64 bits the highest is worth 2^(both exponents + 1) at most.
    int shift = 30 - (int(exponent) - 127 + lightmesh_double_exponent(per_step));
    bool is_sure = shift >= 0 && (lightmesh_cache_head[0].w & 1024u) != 0u;
    uint by = uint(clamp(shift, 0, 63)), part = by & 31u;
    uvec2 located = uvec2(low >> part | (high << 1) << (31u - part), high >> part);
    located = by >= 32u ? uvec2(located.y, 0u) : located;
    if ((bits & 0x80000000u) != 0u)
        located = uvec2(0u - located.x, ~located.y + (located.x == 0u ? 1u : 0u));
    uvec2 origin = lightmesh_cache_level_origin_in_steps(level, axis);
    located = uvec2(located.x - origin.x, located.y - origin.y - (located.x < origin.x ? 1u : 0u));
    slack = is_sure ? 6u + (uint(abs(int(located.y))) >> 19) : 0x40000000u;
    return located;
}

// In doubles.
void lightmesh_cache_place_exactly(LightMeshCachePoint at, int facing, int level) {
    bool is_up = (facing & 1) == 0;
    int first_axis = lightmesh_cache_axis(facing);
    vec3 position = lightmesh_cache_turned(at.position, first_axis), n = lightmesh_cache_turned(at.normal, first_axis);
    uvec2 height = uvec2(0u);
    ivec2 corner = ivec2(0);
    vec2 fraction = vec2(0.0);
    for (int i = 0; i < lightmesh_cache_three(); ++i) {
        int axis = first_axis + i - (first_axis + i > 2 ? 3 : 0);
        uvec2 offset = lightmesh_double_subtract(lightmesh_double_of(lightmesh_cache_pick(position, i)),
                                                 lightmesh_cache_level_origin(level, axis));
        uvec2 located = lightmesh_double_multiply(offset, lightmesh_cache_level_per_step(level));
        if (i == 0) {
            height = is_up ? lightmesh_double_negate(located) : located;
            continue;
        }
        int whole = lightmesh_double_floor(located);
        float part = lightmesh_double_to_float(lightmesh_double_subtract(located, lightmesh_double_of(whole)));
        corner = i == 1 ? ivec2(whole, 0) : ivec2(corner.x, whole);
        fraction = i == 1 ? vec2(part, 0.0) : vec2(fraction.x, part);
    }
    lightmesh_cache_cell.corner = corner;
    lightmesh_cache_cell.at = ivec2(int(fraction.x * 32768.0), int(fraction.y * 32768.0));
    // The height by which the tangent plane rises from the corners to the point, along u and v: the first lattice index at least a
    // quarter before the plane.
    bool is_level = n.y == 0.0 && n.z == 0.0;
    for (int k = 0; k < 1 + lightmesh_cache_three(); ++k) {
        uvec2 plane = height, rises = uvec2(0u);
        for (int i = 1; i < lightmesh_cache_three() && !is_level; ++i) {
            bool is_far = (i == 1 ? k & 1 : k >> 1) != 0;
            precise float offset = (i == 1 ? fraction.x : fraction.y) - (is_far ? 1.0 : 0.0);
            float slope = lightmesh_float_divide(i == 1 ? n.y : n.z, n.x);
            uvec2 rise = lightmesh_double_multiply(lightmesh_double_of(is_up ? offset : -offset),
                                                   lightmesh_double_of(slope));
            rises = i == 1 ? rise : lightmesh_double_add(rises, rise);
        }
        if (!is_level)
            plane = lightmesh_double_subtract(height, rises);
        int below = lightmesh_double_floor(lightmesh_double_subtract(plane, uvec2(0u, 0x3fd00000u)));
        int index = is_up ? -below : below;
        lightmesh_cache_cell.along =
            ivec4(k == 0 ? index : lightmesh_cache_cell.along.x, k == 1 ? index : lightmesh_cache_cell.along.y,
                  k == 2 ? index : lightmesh_cache_cell.along.z, k == 3 ? index : lightmesh_cache_cell.along.w);
    }
}

// The integer below a height less a quarter and what a plane rises; whether that is sure is added to.
int lightmesh_cache_below(uvec2 height, float rise, uint slack, inout bool is_sure) {
    int rises = int(rise * 268435456.0);
    uvec2 less = uvec2(uint(rises) << 4, uint(rises >> 28));
    less += uvec2(0x40000000u, less.x >= 0xc0000000u ? 1u : 0u);
    uint part = height.x - less.x;
    is_sure = is_sure && part >= slack && part <= ~slack;
    return int(height.y - less.y - (height.x < less.x ? 1u : 0u));
}

void lightmesh_cache_place(LightMeshCachePoint at, int facing, int level) {
    bool is_up = (facing & 1) == 0;
    int axis = lightmesh_cache_axis(facing);
    vec3 position = lightmesh_cache_turned(at.position, axis), n = lightmesh_cache_turned(at.normal, axis);
    uvec3 slack;
    uvec2 height = lightmesh_cache_located(position.x, level, axis, slack.x);
    uvec2 u = lightmesh_cache_located(position.y, level, axis == 2 ? 0 : axis + 1, slack.y);
    uvec2 v = lightmesh_cache_located(position.z, level, axis == 0 ? 2 : axis - 1, slack.z);
    if (is_up)
        height = uvec2(0u - height.x, ~height.y + (height.x == 0u ? 1u : 0u));
    uvec2 parts = uvec2(u.x, v.x);
    // 2^-32; a float of 24 bits, as doubles are rounded to.
    vec2 fraction = vec2(parts) * uintBitsToFloat(0x2f800000u);
    ivec2 in_cell = ivec2(fraction * 32768.0);
    ivec2 least = ivec2(vec2(parts - slack.yz) * uintBitsToFloat(0x37000000u)),
          most = ivec2(vec2(parts + slack.yz) * uintBitsToFloat(0x37000000u));  // 2^-17
    bool is_sure = all(greaterThanEqual(parts, slack.yz)) && all(lessThanEqual(parts, ~slack.yz)) &&
                   least == in_cell && most == in_cell;
    lightmesh_cache_cell.corner = ivec2(u.y, v.y);
    lightmesh_cache_cell.at = in_cell;
    vec2 slope = n.yz / (is_up ? n.x : -n.x);
    vec2 close = fraction * slope, distant = (fraction - 1.0) * slope;
    // What floats lose of slopes and rises, many times over: 2^-18.
    uint loss = slack.x + 16384u;
    lightmesh_cache_cell.along = ivec4(lightmesh_cache_below(height, close.x + close.y, loss, is_sure),
                                       lightmesh_cache_below(height, distant.x + close.y, loss, is_sure),
                                       lightmesh_cache_below(height, close.x + distant.y, loss, is_sure),
                                       lightmesh_cache_below(height, distant.x + distant.y, loss, is_sure));
    if (is_up)
        lightmesh_cache_cell.along = -lightmesh_cache_cell.along;
    if (!is_sure)
        lightmesh_cache_place_exactly(at, facing, level);
}

bool lightmesh_cache_is_open(vec3 from, vec3 to, inout uint lacks) {
#ifdef LIGHTMESH_NO_RAYS
    lacks |= lightmesh_cache_lacks_rays;
    return false;
#else
    return lightmesh_is_open(from, to);
#endif
}

// A link that no record keeps.
bool lightmesh_cache_trace_link(int from, int to, int start, int end, int axis, int level) {
    vec3 first = vec3(0.0), second = vec3(0.0);
    for (int i = 1; i < lightmesh_cache_three(); ++i) {
        int k = i == 1 ? from : to;
        ivec3 index = lightmesh_cache_turned_back(ivec3(i == 1 ? start : end, lightmesh_cache_cell.corner.x + (k & 1),
                                                        lightmesh_cache_cell.corner.y + (k >> 1)),
                                                  axis);
        first = second;
        second = lightmesh_cache_lattice_point(index, level);
    }
    return lightmesh_cache_is_open(first, second, lightmesh_cache_cell.lacks);
}

// Which neighbouring columns have a free segment between them: 0-1 and 2-3 along u, 0-2 and 1-3 along v. By the links
// and the lattice indices of the records.
void lightmesh_cache_find_links(uvec4 kept, ivec4 ends, int axis, int level) {
    ivec4 rise = ends.ywzw - ends.xzxy;
    uvec4 is_near = uvec4(lessThanEqual(abs(rise), ivec4(1)));
    uvec4 of_rise = kept.xzxy >> uvec4(clamp(rise, -1, 1) + ivec4(17, 17, 20, 20));
    uint links = lightmesh_cache_bits(of_rise >> 6 & of_rise & is_near),
         untraced = lightmesh_cache_bits(~of_rise & is_near);
    while (untraced != 0u) {
        int i = findLSB(untraced);
        untraced &= untraced - 1u;
        int from = i == 0 ? 0 : i == 2 ? 0 : i == 1 ? 2 : 1, to = from + (i < 2 ? 1 : 2);
        bool is_open = lightmesh_cache_trace_link(from, to, lightmesh_cache_pick(ends, from),
                                                  lightmesh_cache_pick(ends, to), axis, level);
        links |= is_open ? 1u << i : 0u;
    }
    lightmesh_cache_cell.links = links;
}

// The fit of a record to a point, 0 to 256, and in the bits above whether something may lie between them, whether clearly
// nothing does, and from bit 12 on how alike their normals are, 0 to 256. In doubles.
uint lightmesh_cache_fit_exactly(vec3 offset, vec3 normal, LightMeshCachePoint at, int level) {
    // Before the point's plane, before the record's, and the cosine between.
    uvec2 before = uvec2(0u), before_record = uvec2(0u), cosine = uvec2(0u);
    for (int i = 0; i < lightmesh_cache_three(); ++i) {
        uvec2 product = lightmesh_cache_double_dot(lightmesh_cache_doubles(i == 2 ? normal : offset),
                                                   lightmesh_cache_doubles(i == 1 ? normal : at.normal));
        if (i == 0)
            before = product;
        else if (i == 1)
            before_record = product;
        else
            cosine = product;
    }
    int share = 256, alike = 0;
    for (int i = 1; i < lightmesh_cache_three(); ++i) {
        uvec2 from = i == 1 ? lightmesh_cache_level_near(level) : cosine;
        uvec2 less = i == 1 ? lightmesh_double_abs(before) : uvec2(0xcccccccdu, 0x3fe4ccccu);  // .65
        uvec2 by = i == 1 ? lightmesh_cache_level_per_fifth(level) : uvec2(0u, 0x40240000u);   // 10
        uvec2 part = lightmesh_double_multiply(lightmesh_double_subtract(from, less), by);
        int of_part = 0;
        if (!lightmesh_double_is_negative(part))
            of_part = lightmesh_double_less(part, lightmesh_cache_one)
                          ? lightmesh_double_floor(lightmesh_double_scale(part, 8))
                          : 256;
        share = share * of_part >> 8;
        alike = of_part;
    }
    uvec2 least = lightmesh_double_add(
        lightmesh_cache_level_least(level),
        lightmesh_double_scale(lightmesh_double_of(lightmesh_cache_largest(at.position)), -21));
    bool is_suspect = lightmesh_double_less(least, before) && lightmesh_double_less(least, before_record);
    least = lightmesh_double_negate(least);
    bool is_clear = lightmesh_double_less(before, least) || lightmesh_double_less(before_record, least);
    return uint(share) | (is_suspect ? 512u : 0u) | (is_clear ? 1024u : 0u) | uint(alike) << 12;
}

// The same of four records by floats, and 2048 more where those can't tell. `limits`: how near records fit, how fast
// that ends, and from where on something may lie between.
uvec4 lightmesh_cache_fits(LightMeshCacheFour offsets, LightMeshCacheFour normals, vec3 normal, vec3 limits) {
    LightMeshCacheFour n = lightmesh_cache_four(normal);
    vec4 before = lightmesh_cache_dots(offsets, n), before_record = lightmesh_cache_dots(offsets, normals),
         cosine = lightmesh_cache_dots(normals, n);
    vec4 x = abs(offsets.x), y = abs(offsets.y), z = abs(offsets.z);
    vec4 slack = 5e-7 * (x * abs(n.x) + y * abs(n.y) + z * abs(n.z)) + 1e-36,
         record_slack = 5e-7 * (x * abs(normals.x) + y * abs(normals.y) + z * abs(normals.z)) + 1e-36;
    vec4 height = (limits.x - abs(before)) * limits.y, slope = cosine * 10.0 - 6.5;
    vec4 unsure = (slack + 3e-7 * (limits.x + abs(before))) * limits.y;
    const float unsure_slope = 3e-5;
    ivec4 least = ivec4(256.0 * clamp(height - unsure, 0.0, 1.0)),
          most = ivec4(256.0 * clamp(height + unsure, 0.0, 1.0)),
          least_slope = ivec4(256.0 * clamp(slope - unsure_slope, 0.0, 1.0)),
          most_slope = ivec4(256.0 * clamp(slope + unsure_slope, 0.0, 1.0));
    uvec4 is_sure = uvec4(equal(least_slope, most_slope)) &
                    (uvec4(equal(least, most)) | uvec4(equal(most_slope, ivec4(0))));
    vec4 over = before - limits.z, record_over = before_record - limits.z;
    vec4 under = before + limits.z, record_under = before_record + limits.z;
    slack += 3e-7 * limits.z;
    record_slack += 3e-7 * limits.z;
    uvec4 is_surely_not = uvec4(lessThan(over, -slack)) | uvec4(lessThan(record_over, -record_slack)),
          is_suspect = uvec4(greaterThan(over, slack)) & uvec4(greaterThan(record_over, record_slack)),
          is_clear = uvec4(lessThan(under, -slack)) | uvec4(lessThan(record_under, -record_slack)),
          is_surely_unclear = uvec4(greaterThan(under, slack)) & uvec4(greaterThan(record_under, record_slack));
    is_sure &= (is_suspect | is_surely_not) & (is_clear | is_surely_unclear);
    return uvec4(most * most_slope >> 8) | is_suspect << 9 | is_clear << 10 | (1u - is_sure) << 11 |
           uvec4(most_slope) << 12;
}

// Which lattice points the point sees, four bits: rays to them, the nearest first; from those that are seen on over
// links, and rays only to where these don't lead.
uint lightmesh_cache_trace_seen(uint suspect, ivec4 weights, LightMeshCachePoint at, int axis, int level,
                                inout uint lacks) {
    vec3 end = lightmesh_cache_off_surface(at.position, at.normal, level);
    uint seen = 0u;
    // Which is the n-th heaviest, four bits each: how many are heavier than each, or as heavy and before it.
    uvec3 than_first = uvec3(greaterThan(weights.yzw, weights.xxx)),
          than_second = uvec3(greaterThan(weights.zww, weights.yyz));
    uvec4 heavier = uvec4(than_first.x + than_first.y + than_first.z, 1u - than_first.x + than_second.x + than_second.y,
                          2u - than_first.y - than_second.x + than_second.z,
                          3u - than_first.z - than_second.y - than_second.z);
    uint order = 1u << (4u * heavier.y) | 2u << (4u * heavier.z) | 3u << (4u * heavier.w);
    for (int turn = 0; turn < 1 + lightmesh_cache_three(); ++turn) {
        int k = int(order >> (4 * turn)) & 3;
        if (((seen >> k) & 1u) != 0u)
            continue;
        vec3 to = lightmesh_cache_lattice_point(lightmesh_cache_index(k, axis), level);
        if (!lightmesh_cache_is_open(end, to, lacks))
            continue;
        seen |= 1u << k;
        for (int pass = 0; pass < 3; ++pass)
            for (int link = 0; link < 4; ++link) {
                uint ends = link == 0 ? 3u : link == 1 ? 12u : link == 2 ? 5u : 10u;
                if (((lightmesh_cache_cell.links >> link) & 1u) != 0u && (suspect & ends) == 0u && (seen & ends) != 0u)
                    seen |= ends;
            }
    }
    return seen;
}

// Of 2^15 what weights of a sum are, rounded down; below 2^27.
uvec4 lightmesh_cache_parts_of(uvec4 weights, uint sum) {
    uvec4 parts = uvec4(vec4(weights) / float(sum) * 32768.0);
    ivec4 rest = ivec4((weights << 15) - parts * sum);
    return parts + uvec4(greaterThanEqual(rest, ivec4(int(sum)))) - uvec4(lessThan(rest, ivec4(0)));
}

// Makes the weights sum to 2^15; so far they have any sum, below 2^27. The rest is the heaviest one's, the first of
// those: of each corner the record on a surface, and then the one in the air.
void lightmesh_cache_set_weights() {
    uvec4 on = lightmesh_cache_cell.weights, above = lightmesh_cache_cell.air_weights;
    uvec4 both = on + above, most = max(on, above);
    uint sum = both.x + both.y + both.z + both.w;
    uint greatest = max(max(most.x, most.y), max(most.z, most.w));
    uint heaviest = lightmesh_cache_bits(uvec4(equal(on, uvec4(greatest)))) |
                    lightmesh_cache_bits(uvec4(equal(above, uvec4(greatest)))) << 4;
    // As bits in that order.
    heaviest = (heaviest & 1u) | (heaviest & 2u) << 1 | (heaviest & 4u) << 2 | (heaviest & 8u) << 3 |
               (heaviest & 16u) >> 3 | (heaviest & 32u) >> 2 | (heaviest & 64u) >> 1 | (heaviest & 128u);
    heaviest &= ~(heaviest - 1u);
    on = lightmesh_cache_parts_of(on, sum);
    above = lightmesh_cache_parts_of(above, sum);
    both = on + above;
    uint rest = 32768u - (both.x + both.y + both.z + both.w);
    lightmesh_cache_cell.weights = on + rest * uvec4(equal(uvec4(heaviest), uvec4(1u, 4u, 16u, 64u)));
    lightmesh_cache_cell.air_weights = above + rest * uvec4(equal(uvec4(heaviest), uvec4(2u, 8u, 32u, 128u)));
}

uint lightmesh_cache_first_of(uvec4 some) {
    return some.x != 0u ? some.x : some.y != 0u ? some.y : some.z != 0u ? some.z : some.w;
}

uvec4 lightmesh_cache_filled(uvec4 some, uint other) {
    return uvec4(some.x != 0u ? some.x : other, some.y != 0u ? some.y : other, some.z != 0u ? some.z : other,
                 some.w != 0u ? some.w : other);
}

// The cell of a level about the point, with the records that serve it.
void lightmesh_cache_make_cell(inout LightMeshCachePoint at, int turn, int level) {
    int facing = turn == 0 ? at.facings.x : turn == 1 ? at.facings.y : at.facings.z;
    int axis = lightmesh_cache_axis(facing);
    lightmesh_cache_cell.lacks = 0u;
    lightmesh_cache_cell.missing = lightmesh_cache_cell.covered = 0u;
    lightmesh_cache_cell.has_taps = lightmesh_cache_cell.has_air_taps = lightmesh_cache_cell.has_surface_taps = false;
    lightmesh_cache_cell.air_weights = lightmesh_cache_cell.air_taps = uvec4(0u);
    lightmesh_cache_place(at, facing, level);
    uvec4 records = lightmesh_cache_find_records(axis, uint(facing), level);
    lightmesh_cache_cell.records = records;
    if (any(equal(records, uvec4(0u)))) {
        lightmesh_cache_cell.lacks = lightmesh_cache_lacks_values;
        return;
    }
    uvec4 x = lightmesh_cache_records[records.x], y = lightmesh_cache_records[records.y],
          z = lightmesh_cache_records[records.z], w = lightmesh_cache_records[records.w];
    uvec4 more_x = lightmesh_cache_records[records.x + 1u], more_y = lightmesh_cache_records[records.y + 1u],
          more_z = lightmesh_cache_records[records.z + 1u], more_w = lightmesh_cache_records[records.w + 1u];
    uvec4 places = uvec4(more_x.y, more_y.y, more_z.y, more_w.y), links = uvec4(more_x.x, more_y.x, more_z.x, more_w.x);
    uvec4 is_on_surface = places & 1u;
    uint on_surface = lightmesh_cache_bits(is_on_surface);
    lightmesh_cache_find_links(links, ivec4(places) >> 1, axis, level);
    if (lightmesh_cache_cell.lacks != 0u)
        return;
    LightMeshCacheFour positions = LightMeshCacheFour(
        uintBitsToFloat(uvec4(x.x, y.x, z.x, w.x)), uintBitsToFloat(uvec4(x.y, y.y, z.y, w.y)),
        uintBitsToFloat(uvec4(x.z, y.z, z.z, w.z)));
    uvec4 xy = uvec4(x.w, y.w, z.w, w.w);
    LightMeshCacheFour normals = LightMeshCacheFour(lightmesh_cache_unit_floats(ivec4(xy << 16) >> 16),
                                                    lightmesh_cache_unit_floats(ivec4(xy) >> 16),
                                                    lightmesh_cache_unit_floats(ivec4(links << 16) >> 16));
    // True if all four records fit the point without further questions.
    vec3 normal = vec3(normals.x.x, normals.y.x, normals.z.x);
    LightMeshCacheFour turns = lightmesh_cache_differences(normals, lightmesh_cache_four(normal));
    // The first one from the point's.
    turns.x.x = at.normal.x - normal.x;
    turns.y.x = at.normal.y - normal.y;
    turns.z.x = at.normal.z - normal.z;
    vec4 turned = max(max(abs(turns.x), abs(turns.y)), abs(turns.z));
    vec2 floats = lightmesh_cache_level_floats(level);
    vec3 position = vec3(positions.x.x, positions.y.x, positions.z.x);
    vec4 farther = abs(lightmesh_cache_dots(
        lightmesh_cache_four(normal), lightmesh_cache_differences(positions, lightmesh_cache_four(position))));
    precise float slack = floats.x - max(max(farther.y, farther.z), farther.w);
    precise vec3 from_first = at.position - position;
    bool is_flat = lightmesh_cache_cell.links == 15u && on_surface == 15u && all(lessThan(turned, vec4(1e-4))) &&
                   abs(lightmesh_cache_dot(normal, from_first)) < slack;

    ivec2 uv = lightmesh_cache_cell.at;
    int product = int(uint(uv.x) * uint(uv.y) >> 15);
    ivec4 weights = ivec4(32768 - uv.x - uv.y + product, uv.x - product, uv.y - product, product);
    lightmesh_cache_cell.taps = records;
    lightmesh_cache_cell.weights = uvec4(weights);
    lightmesh_cache_cell.has_taps = lightmesh_cache_cell.has_surface_taps = true;
    if (is_flat)
        return;
    vec3 limits = vec3(lightmesh_double_to_float(lightmesh_cache_level_near(level)),
                       lightmesh_double_to_float(lightmesh_cache_level_per_fifth(level)),
                       lightmesh_double_to_float(lightmesh_cache_level_least(level)) +
                           lightmesh_cache_largest(at.position) * uintBitsToFloat(0x35000000u));  // 2^-21
    LightMeshCacheFour offsets = lightmesh_cache_differences(positions, lightmesh_cache_four(at.position));
    uvec4 found = lightmesh_cache_fits(offsets, normals, at.normal, limits) * is_on_surface;
    ivec4 fits = ivec4(found & 511u), alike = ivec4(found >> 12);
    uint suspect = lightmesh_cache_bits(found >> 9),
         is_clear = lightmesh_cache_bits(found >> 10 | (1u - is_on_surface)),
         unsure = lightmesh_cache_bits(found >> 11);
    while (unsure != 0u) {
        int k = findLSB(unsure);
        unsure &= unsure - 1u;
        uint record = lightmesh_cache_pick(records, k);
        precise vec3 offset = lightmesh_cache_record_position(record) - at.position;
        uint fit = lightmesh_cache_fit_exactly(offset, lightmesh_cache_record_normal(record), at, level);
        ivec4 is_k = ivec4(equal(ivec4(k), ivec4(0, 1, 2, 3)));
        fits = fits * (1 - is_k) + is_k * int(fit & 511u);
        alike = alike * (1 - is_k) + is_k * int(fit >> 12);
        suspect = (suspect & ~(1u << k)) | (fit >> 9 & 1u) << k;
        is_clear = (is_clear & ~(1u << k)) | (fit >> 10 & 1u) << k;
    }
    uint seen = 15u;
    // Nothing stands out between the point and the records if all fit it, or one does wholly, and no other one
    // contradicts.
    uint wholly = lightmesh_cache_bits(uvec4(equal(fits, ivec4(256))));
    bool fits_enough = all(greaterThan(fits, ivec4(0))) || (wholly != 0u && (wholly | is_clear) == 15u);
    if (!fits_enough || suspect != 0u || lightmesh_cache_cell.links != 15u) {
        int traced = level - at.first_level;
        uint turn_traced = turn == 0 ? at.traced.x : turn == 1 ? at.traced.y : at.traced.z;
        uint turn_seen = turn == 0 ? at.seen.x : turn == 1 ? at.seen.y : at.seen.z;
        if (((turn_traced >> traced) & 1u) == 0u) {
            uint lacks = 0u;
            seen = lightmesh_cache_trace_seen(suspect, weights, at, axis, level, lacks);
            if (lacks != 0u) {
                lightmesh_cache_cell.lacks |= lacks;
                return;
            }
            turn_traced |= 1u << traced;
            turn_seen |= seen << (4 * traced);
            at.traced = uvec3(turn == 0 ? turn_traced : at.traced.x, turn == 1 ? turn_traced : at.traced.y,
                              turn == 2 ? turn_traced : at.traced.z);
            at.seen = uvec3(turn == 0 ? turn_seen : at.seen.x, turn == 1 ? turn_seen : at.seen.y,
                            turn == 2 ? turn_seen : at.seen.z);
        }
        seen = (turn_seen >> (4 * traced)) & 15u;
    }
    // Where a record does not fit the point, another one in the air, at the point's plane, has its share, less where others
    // serve more than a quarter of it.
    uvec4 is_seen = uvec4(seen & 1u, seen >> 1 & 1u, seen >> 2 & 1u, seen >> 3);
    ivec4 parts = ivec4(is_seen) * (weights * fits >> 8);
    int served = parts.x + parts.y + parts.z + parts.w;
    uint in_air_of_64 = uint(clamp((24576 - served) / 256, 0, 64));  // `air_share` of the library
    uvec4 on_weights = is_seen * 10u * (uvec4(weights) + 1u) * uvec4(fits),
          air_weights = is_seen * 3u * (uvec4(weights) + 1u) * uvec4(256 - fits) * in_air_of_64 >> 6;
    uvec4 air = uvec4(0u), in_air = uvec4(notEqual(air_weights, uvec4(0u)));
    if (in_air != uvec4(0u)) {
        air = lightmesh_cache_find_records(axis, 6u + uint(facing), level) * in_air;
        if (uvec4(notEqual(air, uvec4(0u))) != in_air) {
            lightmesh_cache_cell.lacks |= lightmesh_cache_lacks_values;
            return;
        }
    }
    records *= uvec4(notEqual(on_weights, uvec4(0u)));
    uint any_record = lightmesh_cache_first_of(records), any_air = lightmesh_cache_first_of(air);
    lightmesh_cache_cell.has_surface_taps = any_record != 0u;
    lightmesh_cache_cell.has_air_taps = any_air != 0u;
    lightmesh_cache_cell.has_taps = any_record != 0u || any_air != 0u;
    lightmesh_cache_cell.taps = lightmesh_cache_filled(records, any_record != 0u ? any_record : any_air);
    lightmesh_cache_cell.air_taps = lightmesh_cache_filled(air, any_air);
    lightmesh_cache_cell.weights = on_weights;
    lightmesh_cache_cell.air_weights = air_weights;
    if (lightmesh_cache_cell.has_taps)
        lightmesh_cache_set_weights();
    ivec4 hidden = (weights * alike >> 8) * (1 - ivec4(is_seen)) *
                   ivec4(suspect & 1u, suspect >> 1 & 1u, suspect >> 2 & 1u, suspect >> 3);
    int covered = min(5 * (hidden.x + hidden.y + hidden.z + hidden.w), 32768);
    lightmesh_cache_cell.covered = uint(covered);
    lightmesh_cache_cell.missing = uint(level < 11 ? min(5 * (32768 - served), 32768) : covered);
}

// The probe of a cell, or 0.
uint lightmesh_cache_find_probe(int facing, int level) {
    ivec4 along = lightmesh_cache_cell.along;
    int lowest = min(min(along.x, along.y), min(along.z, along.w));
    int highest = max(max(along.x, along.y), max(along.z, along.w));
    ivec3 index = lightmesh_cache_turned_back(ivec3((facing & 1) == 0 ? highest : lowest, lightmesh_cache_cell.corner),
                                              lightmesh_cache_axis(facing));
    return lightmesh_cache_find_record(index, 12u + uint(facing), level);
}

// ---- smooth surfaces

// True if the plane through a position leaves some of the lamp below.
bool lightmesh_cache_is_cut(uint light, vec3 position, vec3 normal) {
    uvec4 first = lightmesh_cache_light(light, 0u), second = lightmesh_cache_light(light, 1u);
    vec3 at = uintBitsToFloat(first.xyz);
    bool is_directional = (first.w & lightmesh_cache_directional) != 0u;
    bool is_rectangle = (first.w & lightmesh_cache_rectangle) != 0u;
    float size = lightmesh_double_to_float(second.zw);
    vec3 half_u = vec3(0.0), half_v = vec3(0.0);
    if (is_rectangle) {
        half_u = uintBitsToFloat(lightmesh_cache_light(light, 4u).xyz);
        half_v = uintBitsToFloat(lightmesh_cache_light(light, 5u).xyz);
        size = abs(dot(normal, half_u)) + abs(dot(normal, half_v));
    }
    vec3 offset = is_directional ? at : at - position;
    float over = dot(normal, offset) - size;
    float far = lightmesh_cache_largest(at) + (is_directional ? 0.0 : lightmesh_cache_largest(position));
    float bound = 2e-6 * (lightmesh_cache_largest(offset) + size + lightmesh_cache_largest(half_u) +
                          lightmesh_cache_largest(half_v)) +
                  1e-13 * far + 1e-36;
    if (abs(over) > bound)
        return over < 0.0;
    uvec2 extent = is_rectangle ? uvec2(0u) : second.zw, height = uvec2(0u);
    for (int i = is_rectangle ? 0 : 2; i < lightmesh_cache_three(); ++i) {
        LightMeshCacheDoubles along = lightmesh_cache_doubles(i == 0 ? half_u : i == 1 ? half_v : at);
        if (i == 2 && !is_directional)
            along = lightmesh_cache_double_differences(along, lightmesh_cache_doubles(position));
        height = lightmesh_cache_double_dot(along, lightmesh_cache_doubles(normal));
        if (i < 2)
            extent = lightmesh_double_add(extent, lightmesh_double_abs(height));
    }
    return lightmesh_double_less(height, extent);
}

uvec2 lightmesh_cache_to_float_precision(uvec2 a) {
    return lightmesh_double_of(lightmesh_double_to_float(a));
}

// True if some part of the lamp may be nearer to the point's tangent plane, or farther below it, than an angle of
// which the squared sine is given. In floats where those are sure, else in doubles.
bool lightmesh_cache_is_grazing(uint light, LightMeshCachePoint point, float sine_squared) {
    uvec4 first = lightmesh_cache_light(light, 0u);
    uvec2 extent = lightmesh_cache_light(light, 1u).zw;
    vec3 at = uintBitsToFloat(first.xyz);
    precise vec3 offset = at - ((first.w & lightmesh_cache_directional) != 0u ? vec3(0.0) : point.position);
    float size = lightmesh_double_to_float(extent), over = dot(offset, point.normal) - size;
    float slack = 1e-6 * (dot(abs(offset), abs(point.normal)) + size) + 1e-30;
    if (over < -slack)
        return true;
    float square = over * over, limit = sine_squared * dot(offset, offset);
    if (over > slack && abs(square - limit) > 3.0 * over * slack + 2e-6 * (square + limit) + 1e-30)
        return square < limit;
    LightMeshCacheDoubles w = lightmesh_cache_doubles(offset);
    uvec2 height = lightmesh_cache_to_float_precision(
        lightmesh_double_subtract(lightmesh_cache_double_dot(w, lightmesh_cache_doubles(point.normal)), extent));
    if (lightmesh_double_less(height, uvec2(0u)))
        return true;
    uvec2 squared = lightmesh_cache_to_float_precision(lightmesh_cache_double_dot(w, w));
    return lightmesh_double_less(lightmesh_cache_double_square(height),
                                 lightmesh_double_multiply(lightmesh_double_of(sine_squared), squared));
}

// The n-th tap of the cell.
uint lightmesh_cache_tap(int n) {
    return n < 4 ? lightmesh_cache_pick(lightmesh_cache_cell.taps, n)
                 : lightmesh_cache_pick(lightmesh_cache_cell.air_taps, n - 4);
}

// The lights about which the geometric normal of the point, or of a record that serves it, says something else than
// the smooth surface does.
uvec2 lightmesh_cache_bent(LightMeshCachePoint at, uint tile, uvec2 lights) {
    float sine_squared = 0.0;
    int taps = lightmesh_cache_cell.has_air_taps ? 8 : 4;
    for (int k = 0; k < taps; ++k) {
        vec3 normal = lightmesh_cache_record_normal(lightmesh_cache_tap(k));
        precise float cosine = lightmesh_cache_dot(at.normal, normal);
        precise float squared = 1.0 - cosine * cosine;
        sine_squared = lightmesh_cache_is_zero(normal) ? sine_squared : max(sine_squared, squared);
    }
    precise float limit = uintBitsToFloat(0x3f8147aeu) * sine_squared + uintBitsToFloat(0x358637bdu);  // 1.01, 1e-6
    // Of most points no light grazes the surface so.
    uvec2 grazing = uvec2(0u), bent = uvec2(0u);
    uint count = lightmesh_cache_tile_size(tile);
    for (uint l = 0u; l < count; ++l)
        if (lightmesh_cache_has(lights, l) && lightmesh_cache_is_grazing(64u * tile + l, at, limit))
            lightmesh_cache_add(grazing, l);
    for (int k = -1; k < taps && grazing != bent; ++k) {
        vec3 position = at.position, normal = at.normal;
        if (k >= 0) {
            position = lightmesh_cache_record_position(lightmesh_cache_tap(k));
            normal = lightmesh_cache_record_normal(lightmesh_cache_tap(k));
        }
        if (lightmesh_cache_is_zero(normal))
            continue;
        for (uint l = 0u; l < count; ++l)
            if (lightmesh_cache_has(grazing & ~bent, l) && lightmesh_cache_is_cut(64u * tile + l, position, normal))
                lightmesh_cache_add(bent, l);
    }
    return bent;
}

// ---- values

uvec4 lightmesh_cache_bytes(uint word) {
    return uvec4(word & 255u, (word >> 8) & 255u, (word >> 16) & 255u, word >> 24);
}

// Reads four bytes of a shaft row: makes them plain values, and returns 1 in each byte that misses something. See
// `shaft_byte` of the library's row.hpp.
uint lightmesh_cache_zero_bytes(uint word) {
    return (~(((word & 0x7f7f7f7fu) + 0x7f7f7f7fu) | word) >> 7) & 0x01010101u;
}
uint lightmesh_cache_read_shaft(inout uint word) {
    uint misses = word & 0x01010101u & ~lightmesh_cache_zero_bytes(~word);
    if (misses != 0u)
        word = (word & ~lightmesh_cache_zero_bytes(word ^ 0x01010101u)) |
               lightmesh_cache_zero_bytes(word ^ 0xfdfdfdfdu) << 1;
    return misses;
}

// The difference that makes a level give way to the next one.
struct LightMeshCacheLevel {
    uint spread_low;  // difference up to which it does not, see `spread_lows`
    uint force;   // least share of the next level
    uint fade;    // greatest share
    uint window;  // weight of the probe
    bool is_last;
    bool has_shafts;  // whether rows of records on surfaces are shaft rows
};

// The contents of four taps' words: of how each differs from another one, and their weighed sums, and how far the farthest is
// from a value, weighed.
uint lightmesh_cache_differing(uvec4 words, uint other) {
    return words.x ^ other | words.y ^ other | words.z ^ other | words.w ^ other;
}
uvec4 lightmesh_cache_weighed(uvec4 words, uvec4 weights) {
    return weights.x * lightmesh_cache_bytes(words.x) + weights.y * lightmesh_cache_bytes(words.y) +
           weights.z * lightmesh_cache_bytes(words.z) + weights.w * lightmesh_cache_bytes(words.w);
}
uvec4 lightmesh_cache_apart(uint word, uint weight, uvec4 value) {
    return uvec4(abs(ivec4(lightmesh_cache_bytes(word) << 8) - ivec4(value))) * weight;
}
uvec4 lightmesh_cache_farthest(uvec4 words, uvec4 weights, uvec4 value) {
    uvec4 by = min(4u * weights, 32768u);
    return max(max(lightmesh_cache_apart(words.x, by.x, value), lightmesh_cache_apart(words.y, by.y, value)),
               max(lightmesh_cache_apart(words.z, by.z, value), lightmesh_cache_apart(words.w, by.w, value)));
}
uvec4 lightmesh_cache_least(uvec4 words) {
    return min(min(lightmesh_cache_bytes(words.x), lightmesh_cache_bytes(words.y)),
               min(lightmesh_cache_bytes(words.z), lightmesh_cache_bytes(words.w)));
}
uvec4 lightmesh_cache_greatest(uvec4 words) {
    return max(max(lightmesh_cache_bytes(words.x), lightmesh_cache_bytes(words.y)),
               max(lightmesh_cache_bytes(words.z), lightmesh_cache_bytes(words.w)));
}
void lightmesh_cache_read_shaft_of(inout uint word, uint weight, inout uvec4 missed) {
    uint misses = lightmesh_cache_read_shaft(word);
    if (misses != 0u)
        missed = max(missed, lightmesh_cache_bytes(misses) * min(8u * weight, 32768u));
}

// Adds what a level's records say of four lights: what `blend_level` of the library's kernels does. Words of the
// records on surfaces, of those in the air, and of the probe. `asked`: 255 in the bytes of lights of which something is
// left.
void lightmesh_cache_blend(inout uvec4 found, inout uvec4 left, uvec4 words, uvec4 air_words, uint probe_word,
                           uint asked, LightMeshCacheLevel level) {
    uvec4 missed = uvec4(0u);
    if (level.has_shafts) {
        uvec4 weights = lightmesh_cache_cell.weights;
        lightmesh_cache_read_shaft_of(words.x, weights.x, missed);
        lightmesh_cache_read_shaft_of(words.y, weights.y, missed);
        lightmesh_cache_read_shaft_of(words.z, weights.z, missed);
        lightmesh_cache_read_shaft_of(words.w, weights.w, missed);
    }
    uint apart = lightmesh_cache_differing(words, words.x);
    if (lightmesh_cache_cell.has_air_taps)
        apart |= lightmesh_cache_differing(air_words, words.x);
    apart &= asked;
    uint missing = lightmesh_cache_cell.missing;
    uvec4 value = lightmesh_cache_bytes(words.x) << 8;
    if (apart != 0u) {
        value = lightmesh_cache_weighed(words, lightmesh_cache_cell.weights);
        if (lightmesh_cache_cell.has_air_taps)
            value += lightmesh_cache_weighed(air_words, lightmesh_cache_cell.air_weights);
        value = (value + 64u) >> 7;
    }
    // Nothing is left for finer levels, also where all say the same, and a probe does.
    uint differing = apart | missing | level.force | missed.x | missed.y | missed.z | missed.w;
    if (level.window != 0u)
        differing |= (probe_word ^ words.x) & asked;
    if (level.is_last || differing == 0u) {
        found += left * value;
        left = uvec4(0u);
        return;
    }
    uvec4 beta = missed;
    if (apart != 0u) {
        uvec4 spread = lightmesh_cache_farthest(words, lightmesh_cache_cell.weights, value);
        if (lightmesh_cache_cell.has_air_taps)
            spread = max(spread, lightmesh_cache_farthest(air_words, lightmesh_cache_cell.air_weights, value));
        uvec4 twice = min(2u * value, uvec4(65280u));
        spread = (spread >> 15) * (512u - (twice >> 8)) >> 8;
        uvec4 t = 2u * min(max(spread, uvec4(level.spread_low)) - level.spread_low, uvec4(16384u));
        beta = max((t * t >> 15) * (98304u - 2u * t) >> 15, missed);
    }
    if ((level.window | missing) != 0u) {
        uvec4 least = lightmesh_cache_least(words), greatest = lightmesh_cache_greatest(words);
        if (lightmesh_cache_cell.has_air_taps) {
            least = min(least, lightmesh_cache_least(air_words));
            greatest = max(greatest, lightmesh_cache_greatest(air_words));
        }
        uvec4 probe = lightmesh_cache_bytes(probe_word);
        uvec4 is_missed = (uvec4(equal(probe, uvec4(0u))) & uvec4(greaterThan(least, uvec4(153u)))) |
                          (uvec4(equal(probe, uvec4(255u))) & uvec4(lessThan(greatest, uvec4(102u)))) |
                          (uvec4(equal(probe, uvec4(127u))) &
                           (uvec4(equal(least, uvec4(255u))) | uvec4(equal(greatest, uvec4(0u)))));
        beta = max(beta, max(is_missed * level.window, uvec4(greaterThan(greatest, uvec4(0u))) * missing));
    }
    beta = max(beta, uvec4(level.force));
    beta = beta * (level.fade >> 1) >> 14;
    uvec4 rest = left * beta >> 15;
    rest *= uvec4(greaterThanEqual(rest, uvec4(64u)));
    found += (left - rest) * value;
    left = rest;
}

// The lowest four bits of a mask's lights.
uvec4 lightmesh_cache_lanes(uint mask) {
    return uvec4(mask & 1u, (mask >> 1) & 1u, (mask >> 2) & 1u, (mask >> 3) & 1u);
}

uint lightmesh_cache_mask(uvec4 lanes) {
    uvec4 set = uvec4(notEqual(lanes, uvec4(0u)));
    return set.x | set.y << 1 | set.z << 2 | set.w << 3;
}

// What is left for finer levels, of 2^15: 16 bits for each light.
uvec2 lightmesh_cache_left[16];

// Finds S of lights along one facing, as 2^23 * 255 for 1, in the turn's part of lightmesh_cache_values. Those for
// which something is lacking come back.
uvec2 lightmesh_cache_find_along(inout LightMeshCachePoint at, int turn, uint tile, uvec2 lights,
                                 uvec2 smooth_lights) {
    uvec2 unknown = uvec2(0u);
    bool is_first = true;
    int finest = lightmesh_cache_finest();
    int facing = turn == 0 ? at.facings.x : turn == 1 ? at.facings.y : at.facings.z;
    uint values_at = 16u * uint(turn), words = (lightmesh_cache_tile_size(tile) + 3u) / 4u;
    for (uint k = 0u; k < words; ++k)
        lightmesh_cache_values[values_at + k] = uvec4(0u);
    for (int level = at.first_level; (lights.x | lights.y) != 0u; ++level) {
        int next = level < finest ? lightmesh_cache_share_of(at, level + 1) : 0;
        bool is_last = next == 0;
        lightmesh_cache_make_cell(at, turn, level);
        bool has_taps = lightmesh_cache_cell.has_taps;
        uint by_rays = (has_taps ? lightmesh_cache_cell.covered : 32768u) * uint(32768 - next) >> 15;
        bool needs_rays = by_rays != 0u;
        if (lightmesh_cache_cell.lacks != 0u || needs_rays) {
            at.lacks |= lightmesh_cache_cell.lacks != 0u ? lightmesh_cache_cell.lacks : lightmesh_cache_lacks_rays;
            unknown |= lights;
            break;
        }
        if (!has_taps)
            continue;
        uvec2 bending = lights & smooth_lights;
        if ((bending.x | bending.y) != 0u) {
            uvec2 bent = lightmesh_cache_bent(at, tile, bending);
            at.lacks |= (bent.x | bent.y) != 0u ? lightmesh_cache_lacks_rays : 0u;
            unknown |= bent;
            lights &= ~bent;
        }
        bool is_base = level >= 9, is_exact = is_last && lightmesh_cache_has_exact_edges();
        LightMeshCacheLevel how;
        how.is_last = is_last && !is_exact;
        how.spread_low = level <= 9 ? 1958u : level == 10 ? 6528u : 9792u;
        how.force = is_exact || is_base ? 0u : 32768u;
        how.fade = uint(is_exact ? 32768 : next);
        how.window = 0u;
        bool is_coarse = is_base && level < 11;
        how.has_shafts = is_base && level < 12 && lightmesh_cache_has_shaft_rows() &&
                         lightmesh_cache_cell.has_surface_taps;
        uvec2 known = uvec2(~0u);
        uvec4 probe_row = uvec4(0u);
        if (is_coarse && !lightmesh_cache_has_shaft_rows() && !is_last) {
            ivec2 inside = min(lightmesh_cache_cell.at, 32768 - lightmesh_cache_cell.at);
            how.window = uint(min(8 * min(inside.x, inside.y), 32768));
            uint probe = how.window != 0u ? lightmesh_cache_find_probe(facing, level) : 0u;
            if (probe != 0u)
                probe_row = lightmesh_cache_record_row(probe, tile);
            if (how.window != 0u)
                known = probe_row.zw;
        }
        LightMeshCacheRows rows = lightmesh_cache_rows_of(lightmesh_cache_cell.taps, tile), air_rows = rows;
        known &= rows.known;
        if (lightmesh_cache_cell.has_air_taps) {
            air_rows = lightmesh_cache_rows_of(lightmesh_cache_cell.air_taps, tile);
            known &= air_rows.known;
        }
        uvec2 lacking = lights & ~known;
        at.lacks |= (lacking.x | lacking.y) != 0u ? lightmesh_cache_lacks_values : 0u;
        unknown |= lacking;
        uvec2 asking = lights & known;
        lights = uvec2(0u);
        // Octets of lights that are asked for.
        while ((asking.x | asking.y) != 0u) {
            uint octet = uint(asking.x != 0u ? findLSB(asking.x) : 32 + findLSB(asking.y)) >> 3;
            uint shift = 8u * (octet & 3u);
            uint asked = (octet < 4u ? asking.x : asking.y) >> shift & 255u;
            asking &= octet < 4u ? uvec2(~(255u << shift), ~0u) : uvec2(0u, ~(255u << shift));
            uvec4 low_words, high_words, air_low_words = uvec4(0u), air_high_words = uvec4(0u);
            lightmesh_cache_read_octets(rows, octet, low_words, high_words);
            if (lightmesh_cache_cell.has_air_taps)
                lightmesh_cache_read_octets(air_rows, octet, air_low_words, air_high_words);
            uvec2 probe_words = uvec2(0u);
            if (how.window != 0u)
                probe_words = lightmesh_cache_row_octet(probe_row.x >> 24, probe_row.y, octet);
            uint going_on = 0u;
            for (int i = 1; i < lightmesh_cache_three(); ++i) {
                uint asked_here = i == 1 ? asked & 15u : asked >> 4;
                if (asked_here == 0u)
                    continue;
                uint word = 2u * octet + uint(i) - 1u;
                uvec4 lanes = lightmesh_cache_lanes(asked_here), rest = lanes * 32768u, found = uvec4(0u);
                if (!is_first) {
                    found = lightmesh_cache_values[values_at + word];
                    uvec2 left = lightmesh_cache_left[word];
                    rest = lanes * uvec4(left.x & 0xffffu, left.x >> 16, left.y & 0xffffu, left.y >> 16);
                }
                lightmesh_cache_blend(found, rest, i == 1 ? low_words : high_words,
                                      i == 1 ? air_low_words : air_high_words, i == 1 ? probe_words.x : probe_words.y,
                                      lanes.x * 255u | lanes.y * 0xff00u | lanes.z * 0xff0000u | lanes.w * 0xff000000u,
                                      how);
                lightmesh_cache_values[values_at + word] = found;
                uint more = lightmesh_cache_mask(rest);
                if (more != 0u)
                    lightmesh_cache_left[word] = uvec2(rest.x | rest.y << 16, rest.z | rest.w << 16);
                going_on |= i == 1 ? more : more << 4;
            }
            lights |= octet < 4u ? uvec2(going_on << shift, 0u) : uvec2(0u, going_on << shift);
        }
        is_first = false;
        if (is_exact && (lights.x | lights.y) != 0u) {
            at.lacks |= lightmesh_cache_lacks_rays;
            unknown |= lights;
            break;
        }
    }
    return unknown;
}

// The float nearest to a sum's share of 2^38 * 255. (So far from the middle between two floats, or on it, are all such
// quotients that the double between, that the library rounds to first, makes no difference.) Divided digit by digit.
float lightmesh_cache_share_of_sum(uint low, uint high) {
    if ((low | high) == 0u)
        return 0.0;
    // 46 bits, the highest set.
    int zeros = high != 0u ? findMSB(high) : findMSB(low) - 32;
    int shift = 13 - zeros;
    uint up = shift >= 32 ? low << (shift - 32) : shift == 0 ? high : high << shift | low >> (32 - shift);
    uint down = shift >= 32 ? 0u : low << shift;
    // Digits of 23 bits.
    uint upper = up << 9 | down >> 23, quotient = upper / 255u;
    uint lower = (upper - 255u * quotient) << 23 | (down & 0x7fffffu), lower_quotient = lower / 255u;
    bool has_rest = lower != 255u * lower_quotient || (lower_quotient & 127u) != 0u;
    uint bits = quotient << 16 | lower_quotient >> 7 | (has_rest ? 1u : 0u);
    // Of 38 bits behind the point, less seven; 2^-(31 + shift).
    precise float share = float(bits) * uintBitsToFloat(uint(96 - shift) << 23);
    return share;
}

// S of the asked lights of a tile; 0 for others. What is not known is marked, and why is added to `at.lacks`.
void lightmesh_cache_find(inout LightMeshCachePoint at, uint tile, uvec2 asked, out LightMeshCacheTile shares) {
    shares.is_float = false;
    shares.unknown = uvec2(0u);
    uint count = lightmesh_cache_tile_size(tile), words = (count + 3u) / 4u;
    asked.x &= count < 32u ? (1u << count) - 1u : ~0u;
    asked.y &= count < 64u ? (count > 32u ? (1u << (count - 32u)) - 1u : 0u) : ~0u;
    for (uint k = 0u; k < words; ++k)
        lightmesh_cache_values[k] = uvec4(0u);
    if ((at.lacks & lightmesh_cache_lacks_place) != 0u) {
        shares.unknown = asked;
        return;
    }
    uvec4 reaching = lightmesh_cache_reaching(tile, asked, at);
    uvec2 lights = reaching.xy, smooth_lights = reaching.zw;
    if ((lights.x | lights.y | smooth_lights.x | smooth_lights.y) == 0u)
        return;
    // Rays from the point itself: without a normal, or below the facet but not below the smooth surface.
    uvec2 by_rays = at.facing_count == 0 ? lights : smooth_lights & ~lights;
    if ((by_rays.x | by_rays.y) != 0u)
        at.lacks |= lightmesh_cache_lacks_rays;
    shares.is_float = at.facing_count > 1;
    for (int turn = 0; turn < at.facing_count; ++turn)
        shares.unknown |= lightmesh_cache_find_along(at, turn, tile, lights, smooth_lights);
    // Of several facings the sum.
    for (uint k = 0u; k < words && shares.is_float; ++k) {
        uvec4 low, high;
        umulExtended(lightmesh_cache_values[k], uvec4(uint(at.facing_weights.x)), high, low);
        for (int turn = 1; turn < at.facing_count; ++turn) {
            uvec4 more, above;
            umulExtended(lightmesh_cache_values[16u * uint(turn) + k],
                         uvec4(uint(turn == 1 ? at.facing_weights.y : at.facing_weights.z)), above, more);
            low += more;
            high += above + uvec4(lessThan(low, more));
        }
        vec4 sums = vec4(0.0);
        if ((low.x | low.y | low.z | low.w | high.x | high.y | high.z | high.w) != 0u)
            sums = vec4(
                lightmesh_cache_share_of_sum(low.x, high.x), lightmesh_cache_share_of_sum(low.y, high.y),
                lightmesh_cache_share_of_sum(low.z, high.z), lightmesh_cache_share_of_sum(low.w, high.w));
        lightmesh_cache_values[k] = floatBitsToUint(sums);
    }
    shares.unknown |= by_rays;
}

#endif
