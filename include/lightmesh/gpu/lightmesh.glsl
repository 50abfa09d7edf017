// SPDX-License-Identifier: MIT
//
// Light meshes in shaders: S of equation (3) at a surface point from a mesh that `lightmesh::MeshUpload`
// (mesh_upload.hpp) laid out, bit-equal to `LightMesh::visibility` on the CPU. For any number of lights, q of
// 1 to 16, ShortTest::none and linked, and exact by macro.
//
//     #define LIGHTMESH_SET 0
//     #define LIGHTMESH_BINDING 0                // this storage buffer and the five after it
//     #include <lightmesh/gpu/lightmesh.glsl>
//     bool lightmesh_is_open(vec3 from, vec3 to) { return !...; }    // the short ray: yours
//
//     LightMeshPoint point = lightmesh_point(P, n);                  // n: geometric normal on the shaded side
//     for (uint t = 0u; t < lightmesh_tile_count(); ++t) {           // 64 lights at a time
//         LightMeshTile tile = lightmesh_tile(point, t);
//         for (uint l = 0u; l < lightmesh_tile_size(t); ++l)
//             if (!lightmesh_is_missing(tile, l))
//                 color += light[lightmesh_light_at(t, l)] * lightmesh_visibility(tile, l);
//     }
//
// Four lights at a time cost less: lightmesh_visibility_of_four(tile, l), l a multiple of four, is a vec4 of S.
//
// A point with a footprint (world units; see `SurfacePoint`) is answered by one level of the mesh, or between two:
//
//     LightMeshBlend point = lightmesh_point(P, n, footprint);
//     LightMeshBlendTile tile = lightmesh_tile(point, t);            // and so on, by functions of the same names
//
// What the mesh does not know yet is missing, which is not the same as dark: the query has then written P and
// n to the request buffer, once for points that lie close together. Hand them to `fill` on the CPU
// (`read_requests`), upload what changed and ask again.
//
// Macros, to be defined before the include:
//     LIGHTMESH_SET, LIGHTMESH_BINDING   where the buffers are bound; 0 and 0
//     LIGHTMESH_MAX_QUALITY              the greatest q that the shader serves; 16. With 4 it is faster
//     LIGHTMESH_NO_RAYS                  there is no lightmesh_is_open: what needs a ray is missing
//     LIGHTMESH_EXACT                    also serves ShortTest::exact, a ray to each light point of a hemisphere and
//                                        tile of lights
//
// GLSL 4.5 for Vulkan 1.0: no 64-bit types, no subgroups, no shared memory; in any stage that can write to
// storage buffers. Sums and products must round to nearest, as they do on all GPUs. What the CPU does in double is done
// by pairs of floats with a bound of their error here, and in integers where those can't tell. Coordinates and normals
// below 2^-126 may count as 0.
#ifndef LIGHTMESH_GLSL
#define LIGHTMESH_GLSL

#ifndef LIGHTMESH_SET
#define LIGHTMESH_SET 0
#endif
#ifndef LIGHTMESH_BINDING
#define LIGHTMESH_BINDING 0
#endif
#ifndef LIGHTMESH_MAX_QUALITY
#define LIGHTMESH_MAX_QUALITY 16
#endif

// Bits of a count of light points in a hemisphere.
#if LIGHTMESH_MAX_QUALITY <= 4
#define LIGHTMESH_PLANES 8
#elif LIGHTMESH_MAX_QUALITY <= 8
#define LIGHTMESH_PLANES 11
#else
#define LIGHTMESH_PLANES 14
#endif

#ifndef LIGHTMESH_NO_RAYS
// True if nothing lies on the segment between two points, world units. Yours to define.
bool lightmesh_is_open(vec3 from, vec3 to);
#endif

// As mesh_upload.hpp lays them out.
struct LightMeshLevel {
    uvec2 step;  // doubles: low word, high word
    uvec2 inverse_step;
    uvec2 origin[3];
    float step_float;
    float reach;  // of segments to far lights, world units
    float seed_bounds[32];  // from |P|_inf = seed_bounds[i] on seeds are sought 2^(i - 6) steps in front of P
    // The doubles as sums of two floats: high, low.
    float step_low;
    float inverse_step_high;
    float inverse_step_low;
    float origin_high[3];
    float origin_low[3];
    float unused;
};
layout(std430, set = LIGHTMESH_SET, binding = LIGHTMESH_BINDING) readonly buffer LightMeshHeader {
    uvec2 steps_per_footprint;  // a double
    float quality;
    uint short_test;  // 0: none, 1: linked, 2: exact
    uint fraction_bits;
    int radius_squared;
    uint light_count;
    uint slot_mask;     // number of slots of the directory, less one
    uint first_region;  // word of the directory
    uint brick_words;   // of a brick's record
    int flood_side;     // of the box of a flood, in bricks
    uint flood_words;   // 32 bricks of it each
    int coarsest;       // level
    uint unused;
    LightMeshLevel levels[];
} lightmesh;
layout(std430, set = LIGHTMESH_SET, binding = LIGHTMESH_BINDING + 1) readonly buffer LightMeshLights {
    uvec4 lightmesh_lights[];
};
layout(std430, set = LIGHTMESH_SET, binding = LIGHTMESH_BINDING + 2) readonly buffer LightMeshDirectory {
    uvec4 lightmesh_directory[];
};
layout(std430, set = LIGHTMESH_SET, binding = LIGHTMESH_BINDING + 3) readonly buffer LightMeshBricks {
    uvec4 lightmesh_bricks[];
};
layout(std430, set = LIGHTMESH_SET, binding = LIGHTMESH_BINDING + 4) readonly buffer LightMeshBits {
    uvec4 lightmesh_bits[];  // two pairs each
};
layout(std430, set = LIGHTMESH_SET, binding = LIGHTMESH_BINDING + 5) buffer LightMeshRequests {
    uint count;    // records that were asked for; those beyond `capacity` were not written
    uint dropped;  // points for which there was no slot
    uint capacity;
    uint slot_count;
    uint words[];  // slots, then records
} lightmesh_requests;

#include "doubles.glsl"

// ---- floats that round as the CPU's do, where GLSL allows a division or a root some error

// a / b, rounded to nearest; for values whose products neither overflow nor underflow.
float lightmesh_quotient(float a, float b) {
    float q = a / b;
    vec2 p = lightmesh_product(q, b);
    precise float rest = (a - p.x) - p.y;
    precise float rounded = q + rest / b;
    return rounded;
}

float lightmesh_root(float a) {
    float s = sqrt(a);
    vec2 p = lightmesh_product(s, s);
    precise float rest = (a - p.x) - p.y;
    precise float rounded = s + rest / (2.0 * s);
    return a > 0.0 ? rounded : 0.0;
}

float lightmesh_length_squared(vec3 v) {
    precise vec3 squares = v * v;
    precise float sum = (squares.x + squares.y) + squares.z;
    return sum;
}

float lightmesh_largest(vec3 v) {
    vec3 a = abs(v);
    return max(max(a.x, a.y), a.z);
}

// At length 1; zero stays zero.
vec3 lightmesh_unit(vec3 v) {
    float largest = lightmesh_largest(v);
    if (!(largest > 0.0))
        return vec3(0.0);
    // Far from 1 products would overflow, or lose bits: a power of two changes no quotient.
    float power = uintBitsToFloat((253u - clamp(floatBitsToUint(largest) >> 23, 1u, 252u)) << 23);
    v *= power;
    largest *= power;
    vec3 scaled = vec3(lightmesh_quotient(v.x, largest), lightmesh_quotient(v.y, largest),
                       lightmesh_quotient(v.z, largest));
    float inverse = lightmesh_quotient(1.0, lightmesh_root(lightmesh_length_squared(scaled)));
    precise vec3 unit = scaled * inverse;
    return unit;
}

uint lightmesh_component(uvec4 v, uint i) {
    uvec2 two = (i & 2u) == 0u ? v.xy : v.zw;
    return (i & 1u) == 0u ? two.x : two.y;
}

bool lightmesh_is_finite(vec3 v) {
    uvec3 exponents = floatBitsToUint(v) & 0x7f800000u;
    return all(notEqual(exponents, uvec3(0x7f800000u)));
}

// ---- what the CPU does in double: see doubles.glsl

// A number of magnitude below 2^31 as floor + fraction, the latter in 2^-64; what is below that is cut off.
struct LightMeshFixed {
    int whole;
    uint high;
    uint low;
};

LightMeshFixed lightmesh_fixed(uvec2 a) {
    uvec2 bits = lightmesh_double_bits(a);  // in 2^(exponent - 63)
    int exponent = lightmesh_double_exponent(a);
    uint whole = 0u, high = bits.y, low = bits.x, lost = 0u;
    if (exponent >= 0) {
        whole = high >> (31 - exponent);
        high = high << (exponent + 1) | low >> (31 - exponent);
        low <<= exponent + 1;
    } else if (exponent < -64) {
        lost = high;
        high = low = 0u;
    } else if (exponent < -1) {
        int down = -1 - exponent;
        if (down >= 32) {
            lost = low;
            low = high;
            high = 0u;
            down -= 32;
        }
        if (down > 0) {
            lost |= low << (32 - down);
            low = low >> down | high << (32 - down);
            high >>= down;
        }
    }
    if (lightmesh_double_is_negative(a)) {
        bool has_fraction = (high | low | lost) != 0u;
        // -(whole + f) = -(whole + 1) + (1 - f)
        high = ~high;
        low = ~low;
        if (lost == 0u && ++low == 0u)
            ++high;
        return LightMeshFixed(-int(whole) - (has_fraction ? 1 : 0), high, low);
    }
    return LightMeshFixed(int(whole), high, low);
}

// ---- levels

// The level that serves a footprint, and how much of the next one is blended in, as `LevelRule`.
struct LightMeshLevels {
    int level;
    float coarser_share;
};

LightMeshLevels lightmesh_levels(float footprint) {
    const uvec2 begin_of_blend = uvec2(0xdadbe120u, 0x3febdb8cu);   // 2^-0.2
    const uvec2 width_of_blend = uvec2(0x94907b80u, 0x3fc091ccu);   // 1 - 2^-0.2
    const uint infinity = 0x7f800000u;
    uint bits = floatBitsToUint(footprint);
    // 0, negative, NaN
    if (bits - 1u >= infinity || lightmesh.steps_per_footprint.y == 0u)
        return LightMeshLevels(0, 0.0);
    if (bits == infinity)
        return LightMeshLevels(lightmesh.coarsest, 0.0);
    uvec2 steps = lightmesh_double_multiply(lightmesh_double_of(footprint), lightmesh.steps_per_footprint);
    if (!lightmesh_double_less(begin_of_blend, steps))
        return LightMeshLevels(0, 0.0);
    int level = lightmesh_double_exponent(steps) + 1;
    if (level >= lightmesh.coarsest)
        return LightMeshLevels(lightmesh.coarsest, 0.0);
    uvec2 place_in_octave = lightmesh_double_scale(steps, -level);
    if (!lightmesh_double_less(begin_of_blend, place_in_octave))
        return LightMeshLevels(level, 0.0);
    uvec2 share =
        lightmesh_double_divide(lightmesh_double_subtract(place_in_octave, begin_of_blend), width_of_blend);
    return LightMeshLevels(level, lightmesh_double_to_float(share));
}

// S between two levels.
float lightmesh_blended(float fine, float coarse, float coarser_share) {
    uvec2 from = lightmesh_double_of(fine);
    uvec2 way = lightmesh_double_subtract(lightmesh_double_of(coarse), from);
    return lightmesh_double_to_float(
        lightmesh_double_add(from, lightmesh_double_multiply(lightmesh_double_of(coarser_share), way)));
}

// ---- lights: chi of equation (3), ranges and cones

// In fours of words: {low, high} of the box of a tile's lights and the largest magnitude of a place, for all tiles;
// then for each light {place or direction, kind}, {range squared: a double, the same as a float, .}, {axis and
// squared tangent of the cone: doubles, from the word before on}, number.
const uint lightmesh_light_fours = 4u;
const uint lightmesh_light_tile_fours = 2u;

uint lightmesh_tile_count() {
    return (lightmesh.light_count + 63u) >> 6;
}

// Number of lights in a tile.
uint lightmesh_tile_size(uint tile) {
    return min(64u, lightmesh.light_count - 64u * tile);
}

// The place of a light in the buffer; its slot is 64 * tile + l.
uint lightmesh_light(uint slot) {
    return lightmesh_light_tile_fours * lightmesh_tile_count() + lightmesh_light_fours * slot;
}

// The number of light l of a tile, as `LightMesh::visibility` counts them.
uint lightmesh_light_at(uint tile, uint l) {
    return lightmesh_lights[lightmesh_light(64u * tile + l) + 3u].w;
}

const uint lightmesh_is_directional = 1u;
const uint lightmesh_has_range = 2u;
const uint lightmesh_has_cone = 4u;
const uint lightmesh_has_wide_cone = 8u;
const uint lightmesh_reaches_nothing = 16u;
const uint lightmesh_has_odd_range = 32u;  // floats can't tell

// The sum of the products of the components, each rounded as doubles are.
uvec2 lightmesh_dot(vec3 a, vec3 b) {
    uvec2 sum = uvec2(0u);
    for (int axis = 0; axis < 3; ++axis)
        sum = lightmesh_double_add(
            sum, lightmesh_double_multiply(lightmesh_double_of(a[axis]), lightmesh_double_of(b[axis])));
    return sum;
}

struct LightMeshCone {
    uvec2 axis[3];  // doubles
    uvec2 tangent_squared;
};

LightMeshCone lightmesh_cone_of(uint light) {
    uvec4 first = lightmesh_lights[light + 1u], second = lightmesh_lights[light + 2u], third = lightmesh_lights[light + 3u];
    return LightMeshCone(uvec2[3](uvec2(first.w, second.x), second.yz, uvec2(second.w, third.x)), third.yz);
}

// True if a light's cone holds the offset from the light to a point; exact.
bool lightmesh_cone_holds(LightMeshCone cone, vec3 offset, bool is_wide) {
    uvec2 along = uvec2(0u), across = uvec2(0u);
    for (int i = 0; i < 3; ++i) {
        int j = i == 2 ? 0 : i + 1, k = i == 0 ? 2 : i - 1;
        uvec2 offset_j = lightmesh_double_of(offset[j]), offset_k = lightmesh_double_of(offset[k]);
        uvec2 component = lightmesh_double_subtract(lightmesh_double_multiply(cone.axis[j], offset_k),
                                                    lightmesh_double_multiply(offset_j, cone.axis[k]));
        across = lightmesh_double_add(across, lightmesh_double_multiply(component, component));
        along = lightmesh_double_add(along, lightmesh_double_multiply(cone.axis[i], lightmesh_double_of(offset[i])));
    }
    uvec2 limit = lightmesh_double_multiply(cone.tangent_squared, along);
    limit = lightmesh_double_multiply(limit, along);
    uvec2 left = lightmesh_double_subtract(limit, across);
    bool is_behind = lightmesh_double_is_negative(along), is_outside = lightmesh_double_is_negative(left);
    return is_wide ? !is_behind || is_outside || left.y == 0u : !is_behind && !is_outside;
}

// The same; by floats where they can tell.
bool lightmesh_in_cone(uint light, vec3 offset, bool is_wide) {
    LightMeshCone cone = lightmesh_cone_of(light);
    float largest = lightmesh_largest(offset);
    vec3 w = offset / largest;
    vec3 axis = vec3(lightmesh_double_to_float(cone.axis[0]), lightmesh_double_to_float(cone.axis[1]),
                     lightmesh_double_to_float(cone.axis[2]));
    float tangent_squared = lightmesh_double_to_float(cone.tangent_squared);
    float along = dot(axis, w);
    vec3 across = cross(axis, w);
    float limit = tangent_squared * along * along;
    float difference = limit - dot(across, across);
    float band = 3.8e-6 * (3.0 + 2.0 * tangent_squared * abs(along));
    if (!(largest > 1e-15 && largest < 1e15 && abs(along) > 3.8e-6 && abs(difference) > band))
        return lightmesh_cone_holds(cone, offset, is_wide);
    return is_wide ? along > 0.0 || difference < 0.0 : along > 0.0 && difference > 0.0;
}

// True if a light that P may face reaches P. `is_clear`: whether floats tell that P faces it.
bool lightmesh_reaches(uint light, uint kind, vec3 at, vec3 offset, vec3 P, vec3 n, bool is_clear) {
    if ((kind & lightmesh_reaches_nothing) != 0u)
        return false;
    bool is_in_range = (kind & lightmesh_has_range) == 0u;
    uvec2 range = uvec2(0u);
    if (!is_in_range) {
        uvec4 squared = lightmesh_lights[light + 1u];
        range = squared.xy;
        float distance = dot(offset, offset), of_range = uintBitsToFloat(squared.z);
        bool is_told = (kind & lightmesh_has_odd_range) == 0u;
        if (is_told && distance > 1.00001 * of_range)
            return false;
        is_in_range = is_told && distance < 0.99999 * of_range;
    }
    // What floats can't tell: the sign of n . offset, then whether offset . offset is greater than the range.
    int last = is_in_range ? 1 : 2;
    for (int what = is_clear ? 1 : 0; what < last; ++what) {
        uvec2 exact = lightmesh_dot(what == 0 ? n : offset, offset);
        if (what == 0 ? lightmesh_double_is_negative(exact) : lightmesh_double_less(range, exact))
            return false;
    }
    if ((kind & lightmesh_has_cone) != 0u) {
        precise vec3 from_light = P - at;
        return lightmesh_in_cone(light, from_light, (kind & lightmesh_has_wide_cone) != 0u);
    }
    return true;
}

// One bit for each light of a tile that can reach P at all.
uvec2 lightmesh_reaching(vec3 P, vec3 n, uint tile) {
    uvec4 low = lightmesh_lights[lightmesh_light_tile_fours * tile];
    uvec4 high = lightmesh_lights[lightmesh_light_tile_fours * tile + 1u];
    vec3 box_high = uintBitsToFloat(uvec3(low.w, high.xy));
    if (any(lessThan(P, uintBitsToFloat(low.xyz))) || any(greaterThan(P, box_high)))
        return uvec2(0u);
    float band = 9.5367431640625e-7 * (uintBitsToFloat(high.z) + abs(P.x) + abs(P.y) + abs(P.z)) + 1e-36;
    uvec2 reaching = uvec2(0u);
    uint size = lightmesh_tile_size(tile);
    uint light = lightmesh_light(64u * tile);
    // Bits come in from above, so that the place of none depends on the loop.
    for (uint l = 0u; l < size; ++l, light += lightmesh_light_fours) {
        uvec4 first = lightmesh_lights[light];
        vec3 at = uintBitsToFloat(first.xyz);
        precise vec3 offset = (first.w & lightmesh_is_directional) != 0u ? at : at - P;
        float height = dot(n, offset);
        bool reaches = height > band;
        if (!(height < -band) && (!reaches || first.w > lightmesh_is_directional))
            reaches = lightmesh_reaches(light, first.w, at, offset, P, n, reaches);
        reaching.x = reaching.x >> 1 | reaching.y << 31;
        reaching.y = reaching.y >> 1 | (reaches ? 0x80000000u : 0u);
    }
    uint above = 64u - size;
    if (above >= 32u)
        reaching = uvec2(reaching.y, 0u);
    above &= 31u;
    if (above != 0u)
        reaching = uvec2(reaching.x >> above | reaching.y << (32u - above), reaching.y >> above);
    return reaching;
}

// ---- the hemisphere of equation (2)

const uint lightmesh_no_ray = 1u;       // it needs a ray, and there is no lightmesh_is_open
const uint lightmesh_not_filled = 2u;   // `fill` finds what it needs
const uint lightmesh_outside = 4u;      // P or n is not finite, or P lies outside of the grid
const uint lightmesh_not_served = 8u;   // q is greater than LIGHTMESH_MAX_QUALITY, or it takes LIGHTMESH_EXACT

// In fixed point: see query/hemisphere.hpp.
struct LightMeshHemisphere {
    ivec3 first;     // coordinates of the first brick of its box
    ivec3 bricks;    // of the box
    ivec3 position;  // from the first brick's first light point
    ivec3 slope;
    int lowest_height;
};

// The floods of the seeds that P sees.
struct LightMeshFloods {
    int count;
    uint first;
    uint others[19];
};

// A surface point on its way through a query.
struct LightMeshPoint {
    vec3 position;
    vec3 normal;  // as it was given
    vec3 unit;
    vec3 end;      // the surface end of segments
    float footprint;  // as it was given
    int level;
    uint missing;  // why all of it is; 0: it is not
    bool is_requested;
    uint uniform_brick;  // a brick like all others for the lights that reach P; lightmesh_no_brick: they differ
    LightMeshHemisphere hemisphere;
    bool is_tested;  // only what P sees is averaged: the exact short test
    // The linked short test:
    bool is_linked;  // only what floods reach is averaged
    bool is_settled;  // no more seeds are sought
    LightMeshFloods floods;
    ivec3 low;        // the light point at the corner of the eight around the place in front of P
    ivec3 fraction;   // where that place lies between these, of 1024
    uint left;        // which of the eight were not sought yet
    int far_seeds;    // how many of twelve others were; 13: all
    int size;         // number of light points of the hemisphere; -1: not counted yet
    int linked;       // of those that the short test leaves
};

// Light points of a row of twelve, from light point `first` of the hemisphere's box on; a bit each. `square`, `height`:
// what is left for x of the radius squared, and of the least height.
uint lightmesh_row(LightMeshHemisphere p, int first, int square, int height) {
    int one = 1 << lightmesh.fraction_bits;
    int d = (first << lightmesh.fraction_bits) - p.position.x;
    uint row = 0u;
    for (int i = 0; i < 12; ++i, d += one)
        row |= d * d < square && d * p.slope.x > height ? 1u << i : 0u;
    return row;
}

// Exchanges bits that `mask` has with those `by` places above them.
uvec2 lightmesh_exchange(uvec2 bits, uint mask, int by) {
    uvec2 differ = (bits ^ bits >> by) & mask;
    return bits ^ differ ^ differ << by;
}

// Light points of three bricks in a row along x, 8 bits a cell as everywhere in the library. None beyond the box: in
// fixed point the next brick may seem to be within the radius.
struct LightMeshMasks {
    uvec2 of[3];
};

LightMeshMasks lightmesh_masks(LightMeshHemisphere p, ivec3 brick) {
    LightMeshMasks masks = LightMeshMasks(uvec2[3](uvec2(0u), uvec2(0u), uvec2(0u)));
    // Of y and z the ends; of x what the radius allows.
    ivec2 low = (4 * brick.yz << int(lightmesh.fraction_bits)) - p.position.yz;
    ivec2 height = max(low * p.slope.yz, (low + (3 << lightmesh.fraction_bits)) * p.slope.yz);
    int radius = int(ceil(lightmesh.quality)) << lightmesh.fraction_bits;
    if (height.x + height.y + radius * abs(p.slope.x) <= p.lowest_height)
        return masks;
    for (int z = 0; z < 4; ++z) {
        int dz = ((4 * brick.z + z) << lightmesh.fraction_bits) - p.position.z;
        int square_z = lightmesh.radius_squared - dz * dz;
        if (square_z <= 0)
            continue;
        int height_z = p.lowest_height - dz * p.slope.z;
        uvec3 rows = uvec3(0u);
        for (int y = 0; y < 4; ++y) {
            int dy = ((4 * brick.y + y) << lightmesh.fraction_bits) - p.position.y;
            int square = square_z - dy * dy;
            if (square <= 0)
                continue;
            uint row = lightmesh_row(p, 4 * brick.x, square, height_z - dy * p.slope.y);
            rows |= (uvec3(row, row >> 4, row >> 8) & 15u) << (4 * y);
        }
        rows <<= 16 * (z & 1);
        for (int i = 0; i < 3; ++i)
            masks.of[i] |= z < 2 ? uvec2(rows[i], 0u) : uvec2(0u, rows[i]);
    }
    // Row by row: x, x, y, y, z are the places of bits; by cells: x, y, z, x, y.
    for (int i = 0; i < 3; ++i) {
        uvec2 mask = lightmesh_exchange(masks.of[i], 0x0c0c0c0cu, 2);
        mask = lightmesh_exchange(mask, 0x0000f0f0u, 12);
        mask = lightmesh_exchange(mask, 0x0000ff00u, 8);
        masks.of[i] = brick.x + i < p.bricks.x ? mask : uvec2(0u);
    }
    return masks;
}

int lightmesh_bits_in(uvec2 mask) {
    ivec2 counts = bitCount(mask);
    return counts.x + counts.y;
}

int lightmesh_lowest_height(int level, float largest) {
    // 2^15 (2 + 2^f largest 2^-22 / step): where it is far from a whole number floats are enough.
    float scale = uintBitsToFloat((127u + lightmesh.fraction_bits - 7u) << 23);
    float step = lightmesh.levels[level].step_float;
    float quotient = largest / step;
    vec2 product = lightmesh_product(quotient, step);
    precise float rest = ((largest - product.x) - product.y) - quotient * lightmesh.levels[level].step_low;
    float guess = quotient * scale;
    float whole = floor(guess);
    precise float fraction = (guess - whole) + rest / step * scale;
    if (step > 1e-20 && guess < 65536.0 && fraction > 1e-5 && fraction < 0.99999)
        return 65536 + int(whole);
    uvec2 rounding = lightmesh_double_of(largest);
    rounding = lightmesh_double_divide(lightmesh_double_scale(rounding, -22), lightmesh.levels[level].step);
    rounding = lightmesh_double_scale(rounding, int(lightmesh.fraction_bits));
    uvec2 height = lightmesh_double_scale(lightmesh_double_add(lightmesh_double_of(2.0), rounding), 15);
    return lightmesh_double_exponent(height) >= 31 ? 0x7fffffff : lightmesh_double_floor(height);
}

const uint lightmesh_no_brick = 0xffffffffu;

// floor(a + b), 0 <= a < 2^12, if what is left of it leaves no doubt, given how far a + b may be off.
bool lightmesh_floor_of_sum(float a, float b, float error, out int whole) {
    float base = floor(a);
    precise float part = (a - base) + b;
    float more = floor(part);
    whole = int(base) + int(more);
    float band = error + 4.8e-7;
    return part - more > band && part - more < 1.0 - band;
}

// A coordinate in the grid, in steps, as the sum of a whole number, a part of 0 to 1 and what is left, and how far that
// may be from what `Grid::locate` has: more than a step where floats don't hold what they are made of.
struct LightMeshCoordinate {
    float whole;
    float part;
    float left;
    float error;
};

LightMeshCoordinate lightmesh_coordinate(int level, int axis, float position) {
    float origin = lightmesh.levels[level].origin_high[axis], inverse_step = lightmesh.levels[level].inverse_step_high;
    vec2 difference = lightmesh_sum(position, -origin);
    precise float rest = difference.y - lightmesh.levels[level].origin_low[axis];
    vec2 product = lightmesh_product(difference.x, inverse_step);
    precise float more = product.y + (difference.x * lightmesh.levels[level].inverse_step_low + rest * inverse_step);
    precise float high = product.x + more;
    precise float low = more - (high - product.x);
    float size = abs(position) + abs(origin);
    // Between -1 and 0 the part takes a rounding.
    float whole = floor(high);
    precise float part = high - whole;
    precise float left = (high - (whole + part)) + low;
    bool is_held = size > 1e-20 && size < 1e18 && inverse_step > 1e-15 && inverse_step < 1e15 && abs(high) < 16777000.0;
    return LightMeshCoordinate(whole, part, left, is_held ? size * inverse_step * 2.2737368e-13 : 2.0);
}

// The position of P along an axis: the first and the last brick that the hemisphere may reach, and its place from the first
// one's first light point on in 2^-f steps.
struct LightMeshReach {
    int first;
    int last;
    int position;
};

// By floats; false where they can't tell.
bool lightmesh_reach(int level, int axis, float position, out LightMeshReach reach) {
    LightMeshCoordinate c = lightmesh_coordinate(level, axis, position);
    float whole_quality = floor(lightmesh.quality), quality = lightmesh.quality - whole_quality;
    float one = uintBitsToFloat((127u + lightmesh.fraction_bits) << 23);
    int low, high, units;
    bool is_low_clear = lightmesh_floor_of_sum(c.part + (1.0 - quality), c.left, c.error, low);
    bool is_high_clear = lightmesh_floor_of_sum(c.part + quality, c.left, c.error, high);
    bool is_clear = lightmesh_floor_of_sum(c.part * one, c.left * one + 0.5, c.error * one, units);
    int steps = int(c.whole);
    reach.first = (steps + low - 1 - int(whole_quality)) >> 2;
    reach.last = (steps + high + int(whole_quality)) >> 2;
    reach.position = ((steps - 4 * reach.first) << lightmesh.fraction_bits) + units;
    return is_low_clear && is_high_clear && is_clear;
}

// A coordinate in the grid, in steps, as the CPU's double.
uvec2 lightmesh_exact_coordinate(int level, int axis, float position) {
    return lightmesh_double_multiply(
        lightmesh_double_subtract(lightmesh_double_of(position), lightmesh.levels[level].origin[axis]),
        lightmesh.levels[level].inverse_step);
}

// As the CPU's doubles. False outside of the grid.
bool lightmesh_exact_reach(int level, int axis, float position, out LightMeshReach reach) {
    LightMeshFixed quality = lightmesh_fixed(lightmesh_double_of(lightmesh.quality));
    uvec2 at = lightmesh_exact_coordinate(level, axis, position);
    if (!lightmesh_double_less(lightmesh_double_abs(at), lightmesh_double_of(16777152.0)))
        return false;
    LightMeshFixed fixed_at = lightmesh_fixed(at);
    int low = fixed_at.whole - quality.whole - (fixed_at.high < quality.high ? 1 : 0);
    int high = fixed_at.whole + quality.whole + (fixed_at.high + quality.high < fixed_at.high ? 1 : 0);
    reach.first = low >> 2;
    reach.last = high >> 2;
    LightMeshFixed from_first =
        lightmesh_fixed(lightmesh_double_subtract(at, lightmesh_double_of(4 * reach.first)));
    uint below = from_first.high >> (31u - lightmesh.fraction_bits);  // one bit more than is kept
    reach.position = (from_first.whole << lightmesh.fraction_bits) + int((below + 1u) >> 1);
    return true;
}

// Fills in the hemisphere; false if P lies outside of the grid.
bool lightmesh_find_hemisphere(inout LightMeshPoint p) {
    LightMeshReach x, y, z;
    bool is_clear = lightmesh_reach(p.level, 0, p.position.x, x);
    is_clear = lightmesh_reach(p.level, 1, p.position.y, y) && is_clear;
    is_clear = lightmesh_reach(p.level, 2, p.position.z, z) && is_clear;
    if (!is_clear) {
        LightMeshReach exact[3];
        bool is_inside = true;
        for (int axis = 0; axis < 3; ++axis)
            is_inside = lightmesh_exact_reach(p.level, axis, p.position[axis], exact[axis]) && is_inside;
        if (!is_inside)
            return false;
        x = exact[0];
        y = exact[1];
        z = exact[2];
    }
    p.hemisphere.first = ivec3(x.first, y.first, z.first);
    p.hemisphere.bricks = ivec3(x.last, y.last, z.last) - p.hemisphere.first + 1;
    p.hemisphere.position = ivec3(x.position, y.position, z.position);
    vec3 slope = p.unit * 32768.0, below = floor(slope);
    p.hemisphere.slope = ivec3(below) + ivec3(greaterThanEqual(slope - below, vec3(0.5)));
    p.hemisphere.lowest_height = lightmesh_lowest_height(p.level, lightmesh_largest(p.position));
    return true;
}

// ---- bricks

// The place where the directory's words of a region of 4 x 4 x 4 bricks of a level begin; 0 if there is none.
uint lightmesh_find_region(int level, ivec3 region) {
    uvec3 r = uvec3(region);
    uint hash = r.x * 0x9e3779b1u ^ r.y * 0x85ebca77u ^ r.z * 0xc2b2ae3du ^ uint(level) * 0x27d4eb2fu;
    hash ^= hash >> 15;
    for (uint slot = hash & lightmesh.slot_mask;; slot = (slot + 1u) & lightmesh.slot_mask) {
        uvec4 named = lightmesh_directory[slot];
        if (named.w == 0u)
            return 0u;
        if (ivec3(named.xyz) == region && named.w >> 27 == uint(level))
            return lightmesh.first_region + 64u * ((named.w & 0x07ffffffu) - 1u);
    }
}

// The place of a brick's record, given its region; lightmesh_no_brick if it is not there.
uint lightmesh_brick_of(uint region, ivec3 coord) {
    if (region == 0u)
        return lightmesh_no_brick;
    ivec3 at = coord & 3;
    uint brick = lightmesh_component(lightmesh_directory[(region >> 2) + uint(at.y + 4 * at.z)], uint(at.x));
    return brick == 0u ? lightmesh_no_brick : (brick - 1u) * (lightmesh.brick_words >> 2);
}

uint lightmesh_find_brick(int level, ivec3 coord) {
    return lightmesh_brick_of(lightmesh_find_region(level, coord >> 2), coord);
}

// Of a tile of lights: {known cells, uniform lights}, {lit of those, 8 bits for each cell that has words of its own},
// {words of four cells}, {of the others}.
uint lightmesh_tile_record(uint brick, uint tile) {
    return brick + 1u + 4u * tile;
}

uvec2 lightmesh_pair(uint pair) {
    uvec4 two = lightmesh_bits[pair >> 1];
    return (pair & 1u) == 0u ? two.xy : two.zw;
}

// The bit of a light point in its brick.
uint lightmesh_bit_in_brick(ivec3 light_point) {
    uvec3 at = uvec3(light_point) & 3u, cell = at >> 1, in_cell = at & 1u;
    return 8u * (cell.x + 2u * cell.y + 4u * cell.z) + in_cell.x + 2u * in_cell.y + 4u * in_cell.z;
}

// ---- floods: what the seeds of the linked short test reach

// Place plus one in `lightmesh_bits` of the flood of a light point; 0 if nobody has looked.
uint lightmesh_find_flood(int level, ivec3 seed) {
    uint brick = lightmesh_find_brick(level, seed >> 2);
    if (brick == lightmesh_no_brick)
        return 0u;
    uvec4 head = lightmesh_bricks[brick];
    uint table = head.x;
    if (table == 0u)
        return 0u;
    uint bit = lightmesh_bit_in_brick(seed);
    uvec2 seeds = head.zw;
    uint word = bit < 32u ? seeds.x : seeds.y;
    uint one = 1u << (bit & 31u);
    if ((word & one) == 0u)
        return 0u;
    int rank = bitCount(word & (one - 1u)) + (bit < 32u ? 0 : bitCount(seeds.x));
    uvec2 at = lightmesh_pair((table - 1u) + uint(rank >> 1));
    return (rank & 1) == 0 ? at.x : at.y;
}

// The light points that a flood reaches in a brick.
uvec2 lightmesh_reached(uint flood, ivec3 coord) {
    uint at = flood - 1u;
    ivec3 p = coord - ivec3(lightmesh_bits[at >> 1].xyz);
    int side = lightmesh.flood_side;
    if (any(lessThan(p, ivec3(0))) || any(greaterThanEqual(p, ivec3(side))))
        return uvec2(0u);
    uint slot = uint(p.x + side * (p.y + side * p.z));
    uint one = 1u << (slot & 31u);
    uvec2 of = lightmesh_pair(at + 2u + (slot >> 5));  // slots that are full, slots that are partial
    if ((of.x & one) != 0u)
        return uvec2(0xffffffffu);
    if ((of.y & one) == 0u)
        return uvec2(0u);
    uint ranks = lightmesh.flood_words;
    uvec2 before = lightmesh_pair(at + 2u + ranks + (slot >> 6));
    uint rank = ((slot >> 5 & 1u) == 0u ? before.x : before.y) + uint(bitCount(of.y & (one - 1u)));
    return lightmesh_pair(at + 2u + ranks + ((ranks + 1u) >> 1) + rank);
}

uvec2 lightmesh_reached_by_all(LightMeshFloods floods, ivec3 coord) {
    uvec2 reached = uvec2(0u);
    for (int i = 0; i < floods.count; ++i)
        reached |= lightmesh_reached(i == 0 ? floods.first : floods.others[i - 1], coord);
    return reached;
}

// ---- requests

// Asks for what P lacks on its level, once for the points of a cell of half a step whose normals have the same signs.
void lightmesh_request(inout LightMeshPoint p) {
    if (p.is_requested)
        return;
    p.is_requested = true;
    uint bits = lightmesh.fraction_bits - 1u;
    uvec3 cell = uvec3(8 * p.hemisphere.first + (p.hemisphere.position >> bits));
    uvec3 signs = uvec3(lessThan(p.hemisphere.slope, ivec3(0)));
    uint key = cell.x * 0x9e3779b1u + cell.y * 0x85ebca77u + cell.z * 0xc2b2ae3du +
               (signs.x + 2u * signs.y + 4u * signs.z + 8u * uint(p.level)) * 0x27d4eb2fu;
    key ^= key >> 16;
    key *= 0x7feb352du;
    key ^= key >> 15;
    key = max(key, 1u);
    uint slot_count = lightmesh_requests.slot_count;
    for (uint i = 0u; i < 16u && slot_count != 0u; ++i) {
        uint found = atomicCompSwap(lightmesh_requests.words[(key + i) % slot_count], 0u, key);
        if (found == key)
            return;
        if (found != 0u)
            continue;
        uint record = atomicAdd(lightmesh_requests.count, 1u);
        if (record >= lightmesh_requests.capacity)
            return;
        uint at = slot_count + 7u * record;
        for (int axis = 0; axis < 3; ++axis) {
            lightmesh_requests.words[at + uint(axis)] = floatBitsToUint(p.position[axis]);
            lightmesh_requests.words[at + 3u + uint(axis)] = floatBitsToUint(p.normal[axis]);
        }
        lightmesh_requests.words[at + 6u] = floatBitsToUint(p.footprint);
        return;
    }
    atomicAdd(lightmesh_requests.dropped, 1u);
}

// ---- the linked short test

// The nearest float to a coordinate of a light point, which is computed in double. By floats; false where they can't
// tell.
bool lightmesh_light_coordinate(int level, int axis, int light_point, out float coordinate) {
    float step = lightmesh.levels[level].step_float, origin = lightmesh.levels[level].origin_high[axis];
    float index = float(light_point);
    vec2 product = lightmesh_product(step, index);
    vec2 sum = lightmesh_sum(origin, product.x);
    precise float more =
        sum.y + (product.y + (lightmesh.levels[level].step_low * index + lightmesh.levels[level].origin_low[axis]));
    float size = abs(origin) + abs(product.x);
    float error = size * 1.1368684e-13 + abs(more) * 2e-6;
    precise float least = sum.x + (more - error);
    precise float greatest = sum.x + (more + error);
    coordinate = least;
    return least == greatest && size > 1e-20 && size < 1e25;
}

vec3 lightmesh_light_point(int level, ivec3 light_point) {
    float x, y, z;
    bool is_clear = lightmesh_light_coordinate(level, 0, light_point.x, x);
    is_clear = lightmesh_light_coordinate(level, 1, light_point.y, y) && is_clear;
    is_clear = lightmesh_light_coordinate(level, 2, light_point.z, z) && is_clear;
    if (is_clear)
        return vec3(x, y, z);
    vec3 exact;
    for (int axis = 0; axis < 3; ++axis)
        exact[axis] = lightmesh_double_to_float(lightmesh_double_add(
            lightmesh.levels[level].origin[axis],
            lightmesh_double_multiply(lightmesh.levels[level].step, lightmesh_double_of(light_point[axis]))));
    return exact;
}

bool lightmesh_in_hemisphere(LightMeshHemisphere p, ivec3 light_point) {
    ivec3 d = ((light_point - 4 * p.first) << lightmesh.fraction_bits) - p.position;
    ivec3 squares = d * d, heights = d * p.slope;
    uvec3 brick = uvec3((light_point >> 2) - p.first);
    return all(lessThan(brick, uvec3(p.bricks))) && squares.x + squares.y + squares.z < lightmesh.radius_squared &&
           heights.x + heights.y + heights.z > p.lowest_height;
}

#ifndef LIGHTMESH_NO_RAYS
// The light point of a bit of a brick.
ivec3 lightmesh_point_of(ivec3 brick, int bit) {
    int cell = bit >> 3;
    return 4 * brick + ivec3(2 * (cell & 1) + (bit & 1), 2 * (cell >> 1 & 1) + (bit >> 1 & 1), 2 * (cell >> 2) + (bit >> 2 & 1));
}

// The light point of this number, in the order of bricks and bits.
ivec3 lightmesh_point_at(LightMeshPoint p, int number) {
    for (int z = 0; z < p.hemisphere.bricks.z; ++z)
        for (int y = 0; y < p.hemisphere.bricks.y; ++y)
            for (int x = 0; x < p.hemisphere.bricks.x; x += 3) {
                LightMeshMasks masks = lightmesh_masks(p.hemisphere, ivec3(x, y, z));
                for (int i = 0; i < 3; ++i) {
                    uvec2 mask = masks.of[i];
                    int size = lightmesh_bits_in(mask);
                    if (number >= size) {
                        number -= size;
                        continue;
                    }
                    int in_low = bitCount(mask.x);
                    uint rest = number < in_low ? mask.x : mask.y;
                    int bit = number < in_low ? 0 : 32;
                    number -= number < in_low ? 0 : in_low;
                    for (; number > 0; --number)
                        rest &= rest - 1u;
                    bit += findLSB(rest);
                    return lightmesh_point_of(p.hemisphere.first + ivec3(x + i, y, z), bit);
                }
            }
    return ivec3(0);
}

#ifdef LIGHTMESH_EXACT
// Of some light points of a brick those that P sees.
uvec2 lightmesh_seen(LightMeshPoint p, ivec3 brick, uvec2 mask) {
    uvec2 seen = uvec2(0u);
    while ((mask.x | mask.y) != 0u) {
        bool is_low = mask.x != 0u;
        int bit = findLSB(is_low ? mask.x : mask.y);
        uvec2 one = is_low ? uvec2(1u << bit, 0u) : uvec2(0u, 1u << bit);
        mask &= ~one;
        ivec3 light_point = lightmesh_point_of(brick, is_low ? bit : 32 + bit);
        if (lightmesh_is_open(p.end, lightmesh_light_point(p.level, light_point)))
            seen |= one;
    }
    return seen;
}
#endif

// The first light point of the hemisphere that P sees, in the same order; false if it sees none.
bool lightmesh_find_seen(LightMeshPoint p, out ivec3 seen) {
    for (int z = 0; z < p.hemisphere.bricks.z; ++z)
        for (int y = 0; y < p.hemisphere.bricks.y; ++y)
            for (int x = 0; x < p.hemisphere.bricks.x; x += 3) {
                LightMeshMasks masks = lightmesh_masks(p.hemisphere, ivec3(x, y, z));
                for (int i = 0; i < 6; ++i) {
                    uvec2 mask = masks.of[i >> 1];
                    for (uint rest = (i & 1) == 0 ? mask.x : mask.y; rest != 0u; rest &= rest - 1u) {
                        int bit = findLSB(rest) + 32 * (i & 1);
                        seen = lightmesh_point_of(p.hemisphere.first + ivec3(x + (i >> 1), y, z), bit);
                        if (lightmesh_is_open(p.end, lightmesh_light_point(p.level, seen)))
                            return true;
                    }
                }
            }
    seen = ivec3(0);
    return false;
}

bool lightmesh_is_reached(LightMeshPoint p, ivec3 light_point) {
    if (p.floods.count == 0)
        return false;
    uvec2 reached = lightmesh_reached_by_all(p.floods, light_point >> 2);
    uint bit = lightmesh_bit_in_brick(light_point);
    return ((bit < 32u ? reached.x : reached.y) >> (bit & 31u) & 1u) != 0u;
}

// The place where seeds are sought along an axis, in front of P: the light point below, and 1024ths of a step beyond it.
struct LightMeshInFront {
    int low;
    int fraction;
};

// By floats; false where they can't tell.
bool lightmesh_in_front(int level, int axis, float position, float ahead, out LightMeshInFront place) {
    LightMeshCoordinate c = lightmesh_coordinate(level, axis, position);
    vec2 sum = lightmesh_sum(c.part, ahead);
    float whole = floor(sum.x);
    precise float part = sum.x - whole;
    precise float more = ((sum.x - (whole + part)) + sum.y) + c.left;
    float error = 1024.0 * (c.error + abs(more) * 2.4e-7);
    int fraction;
    bool is_clear = lightmesh_floor_of_sum(part * 1024.0, more * 1024.0, error, fraction);
    place.low = int(c.whole) + int(whole) + (fraction >> 10);
    place.fraction = fraction & 1023;
    return is_clear && abs(whole) < 16777000.0;
}

LightMeshInFront lightmesh_exactly_in_front(int level, int axis, float position, float unit, int in_front) {
    uvec2 at = lightmesh_exact_coordinate(level, axis, position);
    LightMeshFixed exact =
        lightmesh_fixed(lightmesh_double_add(at, lightmesh_double_scale(lightmesh_double_of(unit), in_front)));
    bool rounds_to_one = exact.high == 0xffffffffu && exact.low >= 0xfffffc00u;
    return LightMeshInFront(exact.whole, rounds_to_one ? 1024 : int(exact.high >> 22));
}

// Before the first seed is sought; as `SeedCandidates`.
void lightmesh_begin_seeds(inout LightMeshPoint p) {
    float largest = lightmesh_largest(p.position);
    int in_front = -7;
    for (int i = 0; i < 32 && largest >= lightmesh.levels[p.level].seed_bounds[i]; ++i)
        ++in_front;
    vec3 ahead = p.unit * uintBitsToFloat(uint(127 + in_front) << 23);
    LightMeshInFront x, y, z;
    bool is_clear = lightmesh_in_front(p.level, 0, p.position.x, ahead.x, x);
    is_clear = lightmesh_in_front(p.level, 1, p.position.y, ahead.y, y) && is_clear;
    is_clear = lightmesh_in_front(p.level, 2, p.position.z, ahead.z, z) && is_clear;
    if (!is_clear) {
        LightMeshInFront exact[3];
        for (int axis = 0; axis < 3; ++axis)
            exact[axis] = lightmesh_exactly_in_front(p.level, axis, p.position[axis], p.unit[axis], in_front);
        x = exact[0];
        y = exact[1];
        z = exact[2];
    }
    p.low = ivec3(x.low, y.low, z.low);
    p.fraction = ivec3(x.fraction, y.fraction, z.fraction);
    p.left = 255u;
}

// Takes the nearest of the light points in front of P that are left, even ones first.
ivec3 lightmesh_take_near_seed(inout LightMeshPoint p) {
    int best = 0, least = 0x7fffffff;
    for (int corner = 0; corner < 8; ++corner) {
        ivec3 to = ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
        ivec3 to_corner = 1024 * to - p.fraction;
        ivec3 pos = p.low + to;
        bool is_even = ((pos.x ^ pos.y ^ pos.z) & 1) == 0;
        int rank = 8 * (to_corner.x * to_corner.x + to_corner.y * to_corner.y + to_corner.z * to_corner.z +
                        (is_even ? 0 : 1 << 24)) + corner;
        if ((p.left >> corner & 1u) != 0u && rank < least) {
            least = rank;
            best = corner;
        }
    }
    p.left &= ~(1u << best);
    return p.low + ivec3(best & 1, best >> 1 & 1, best >> 2);
}

const int lightmesh_found_flood = 0;  // of a seed that P sees and no other flood reaches; it was added
const int lightmesh_no_flood = 1;     // P sees such a seed, but nobody looked what it reaches
const int lightmesh_no_seed = 2;      // there is none left
const int lightmesh_wants_size = 3;   // of the hemisphere, to find seeds far from P

// Adds the flood of a seed that P sees.
int lightmesh_add_flood(inout LightMeshPoint p, ivec3 seed) {
    uint flood = lightmesh_find_flood(p.level, seed);
    if (flood == 0u)
        return lightmesh_no_flood;
    if (p.floods.count == 0)
        p.floods.first = flood;
    else
        p.floods.others[p.floods.count - 1] = flood;
    ++p.floods.count;
    return lightmesh_found_flood;
}

int lightmesh_seek_flood(inout LightMeshPoint p, out ivec3 seed) {
    seed = ivec3(0);
    while (true) {
        if (p.left != 0u) {
            seed = lightmesh_take_near_seed(p);
            if (!lightmesh_in_hemisphere(p.hemisphere, seed))
                continue;
        } else {
            if (p.size < 0)
                return lightmesh_wants_size;
            if (4 * p.linked >= p.size || p.far_seeds == 13 || (p.far_seeds == 12 && p.linked > 0))
                return lightmesh_no_seed;
            if (p.far_seeds++ == 12)
                return lightmesh_find_seen(p, seed) ? lightmesh_add_flood(p, seed) : lightmesh_no_seed;
            seed = lightmesh_point_at(p, (2 * p.far_seeds - 1) * p.size / 24);
        }
        if (!lightmesh_is_reached(p, seed) && lightmesh_is_open(p.end, lightmesh_light_point(p.level, seed)))
            return lightmesh_add_flood(p, seed);
    }
}
#endif

// Begins a query of one level.
LightMeshPoint lightmesh_point_on(int level, vec3 P, vec3 n, float footprint) {
    LightMeshPoint p;
    p.position = P;
    p.normal = n;
    p.footprint = footprint;
    p.level = level;
    p.missing = 0u;
    p.is_requested = false;
    p.uniform_brick = lightmesh_no_brick;
    p.is_tested = false;
    p.is_linked = lightmesh.short_test == 1u;
    p.is_settled = !p.is_linked;
    p.floods.count = 0;
    p.floods.first = 0u;
    p.low = p.fraction = ivec3(0);
    p.left = 0u;
    p.far_seeds = 0;
    p.size = -1;
    p.linked = 0;
    p.hemisphere = LightMeshHemisphere(ivec3(0), ivec3(0), ivec3(0), ivec3(0), 0);
    p.unit = vec3(0.0);
    p.end = P;
    if (!lightmesh_is_finite(P) || !lightmesh_is_finite(n)) {
        p.missing = lightmesh_outside;
        return p;
    }
    p.unit = lightmesh_unit(n);
    precise float offset =
        lightmesh_largest(P) * 1.9073486328125e-6 + lightmesh.levels[level].step_float * 4.8828125e-4;
    precise vec3 end = P + offset * p.unit;
    p.end = end;
    if (!lightmesh_find_hemisphere(p)) {
        p.missing = lightmesh_outside;
        return p;
    }
    bool is_exact = lightmesh.short_test == 2u;
#ifdef LIGHTMESH_EXACT
    const bool serves_exact = true;
#else
    const bool serves_exact = false;
#endif
    if (lightmesh.quality > float(LIGHTMESH_MAX_QUALITY) || is_exact && !serves_exact) {
        p.missing = lightmesh_not_served;
        return p;
    }
#ifdef LIGHTMESH_NO_RAYS
    if (p.is_linked || is_exact)
        p.missing = lightmesh_no_ray;
#else
    if (p.is_linked)
        lightmesh_begin_seeds(p);
#endif
    return p;
}

// Begins a query at P (world units) with the geometric normal n on the side that is shaded, of any length.
LightMeshPoint lightmesh_point(vec3 P, vec3 n) {
    return lightmesh_point_on(0, P, n, 0.0);
}

// ---- the sum of equation (3)

// 64 lights at a point: bit l of planes[k] is bit k of how many light points see light l.
struct LightMeshTile {
    uvec2 planes[LIGHTMESH_PLANES];
    uvec2 reaching;  // lights that can reach P at all; S of the others is 0
    uvec2 missing;   // of these the lights of which something is not known
    uint why;        // they are missing: lightmesh_not_filled and others
    int m;
};

// Adds `count` to the lights of a mask.
void lightmesh_add(inout LightMeshTile tile, uvec2 lights, uint count) {
    uvec2 carry = uvec2(0u);
    for (int k = 0; k < LIGHTMESH_PLANES; ++k) {
        uvec2 bit = (count >> k & 1u) != 0u ? lights : uvec2(0u);
        uvec2 either = tile.planes[k] ^ bit;
        uvec2 next = (tile.planes[k] & bit) | (carry & either);
        tile.planes[k] = either ^ carry;
        carry = next;
    }
}

uvec2 lightmesh_full_add(inout uvec2 sum, uvec2 a, uvec2 b) {
    uvec2 either = a ^ b;
    uvec2 carry = (a & b) | (sum & either);
    sum ^= either;
    return carry;
}

// Adds 1 for each of a cell's light points in `points`, to the lights that it sees.
void lightmesh_add_cell(inout LightMeshTile tile, uint cell, uint points) {
    // Of light points that all see the same lights there are two, else eight.
    uint at = ((cell >> 1) - 1u) >> 1, next = 1u - (cell & 1u);
    uvec2 w[8];
    for (uint i = 0u; i < 4u; ++i) {
        uvec4 two = lightmesh_bits[at + next * i];
        w[2u * i] = (points >> (2u * i) & 1u) != 0u ? two.xy : uvec2(0u);
        w[2u * i + 1u] = (points >> (2u * i + 1u) & 1u) != 0u ? two.zw : uvec2(0u);
    }
    uvec2 a = lightmesh_full_add(tile.planes[0], w[0], w[1]);
    uvec2 b = lightmesh_full_add(tile.planes[0], w[2], w[3]);
    uvec2 c = lightmesh_full_add(tile.planes[0], w[4], w[5]);
    uvec2 d = lightmesh_full_add(tile.planes[0], w[6], w[7]);
    a = lightmesh_full_add(tile.planes[1], a, b);
    b = lightmesh_full_add(tile.planes[1], c, d);
    uvec2 carry = lightmesh_full_add(tile.planes[2], a, b);
    for (int k = 3; k < LIGHTMESH_PLANES; ++k) {
        uvec2 next = tile.planes[k] & carry;
        tile.planes[k] ^= carry;
        carry = next;
    }
}

// 0xff in each byte that is not 0.
uvec2 lightmesh_cells_in(uvec2 mask) {
    const uint low = 0x7f7f7f7fu;
    uvec2 highest = (((mask & low) + low) | mask) & ~low;
    return (highest >> 7) * 0xffu;
}

// One bit for each group of 8 lights with a light in it, as a byte.
uint lightmesh_groups_of(uvec2 lights) {
    uvec2 any = lightmesh_cells_in(lights) & 0x08040201u;
    uvec2 folded = any | any >> 16;
    folded |= folded >> 8;
    return (folded.x & 15u) | (folded.y & 15u) << 4;
}

uvec2 lightmesh_lights_of(uint groups) {
    uvec2 spread = uvec2(groups & 15u, groups >> 4 & 15u);
    spread = (spread | spread << 7 | spread << 14 | spread << 21) & 0x01010101u;
    return spread * 0xffu;
}

#ifndef LIGHTMESH_NO_RAYS
// The light's end of a shadow ray from `end`.
vec3 lightmesh_light_end(int level, uint light, vec3 end) {
    float step = lightmesh.levels[level].step_float, reach = lightmesh.levels[level].reach;
    uvec4 first = lightmesh_lights[light];
    vec3 at = uintBitsToFloat(first.xyz);
    if ((first.w & lightmesh_is_directional) != 0u) {
        precise vec3 far = end + at * reach;
        return far;
    }
    float largest = lightmesh_largest(at);
    precise vec3 to_light = at - end;
    if (largest > 16384.0 * step) {
        float size = lightmesh_largest(to_light);
        if (size * length(to_light / size) > reach) {
            precise vec3 far = end + lightmesh_unit(to_light) * reach;
            return far;
        }
    }
    precise float offset = largest * 1.9073486328125e-6 + step * 4.8828125e-4;
    float distance = lightmesh_root(lightmesh_length_squared(to_light));
    float share = distance > 2.0 * offset ? lightmesh_quotient(offset, distance) : 0.5;
    precise vec3 short_of_light = at - to_light * share;
    return short_of_light;
}

// The index in the grid of light point p of a brick (see `LongTestWord`).
ivec3 lightmesh_point_of_brick(ivec3 brick, uint p) {
    return 4 * brick + ivec3((p & 1u) | (p >> 2 & 2u), (p >> 1 & 1u) | (p >> 3 & 2u), (p >> 2 & 1u) | (p >> 4 & 2u));
}

// A link, as `fill` traces it on the CPU: whether nothing lies between light point p of a level's brick and the next one
// up along an axis, 0 to 2.
bool lightmesh_is_linked(uint of_level, ivec3 brick, uint p, uint axis) {
    ivec3 at = lightmesh_point_of_brick(brick, p);
    ivec3 up = ivec3(equal(uvec3(axis), uvec3(0u, 1u, 2u)));
    return lightmesh_is_open(lightmesh_light_point(int(of_level), at), lightmesh_light_point(int(of_level), at + up));
}

// A long test, as `fill` traces it on the CPU: whether light point p of a level's brick sees the light in a slot,
// 64 * tile + l.
bool lightmesh_sees_light(uint of_level, ivec3 brick, uint p, uint slot) {
    int level = int(of_level);
    vec3 point = lightmesh_light_point(level, lightmesh_point_of_brick(brick, p));
    uint light = lightmesh_light(slot);
    vec3 end = lightmesh_light_end(level, light, point);
    uvec4 first = lightmesh_lights[light];
    bool is_far = (first.w & lightmesh_is_directional) != 0u ||
                  lightmesh_largest(uintBitsToFloat(first.xyz)) > 16384.0 * lightmesh.levels[level].step_float;
    return is_far ? lightmesh_is_open(point, end) : lightmesh_is_open(end, point);
}
#endif

// The findings of a pass over the hemisphere for a tile of lights.
struct LightMeshPass {
    int size;             // number of light points
    int linked;           // of these that the short test leaves
    uint missing_groups;  // eights of lights of which something is not known
    bool agrees;          // whether all bricks are known to be uniform for each of the lights, and alike
};

// Adds what the light points of the hemisphere see of a tile's lights. `only_agrees`: only tells whether bricks agree.
LightMeshPass lightmesh_count(LightMeshPoint p, uint t, uvec2 lights, bool only_agrees, inout LightMeshTile tile) {
    LightMeshPass pass = LightMeshPass(0, 0, 0u, true);
    uint groups = lightmesh_groups_of(lights);
    uvec2 all_lit = lights, any_lit = uvec2(0u);
    uvec2 pending = uvec2(0u);  // lights that `pending_count` light points of uniform cells see
    uint pending_count = 0u;
    ivec3 region_at = ivec3(0x7fffffff);
    uint region = 0u;
    for (int z = 0; z < p.hemisphere.bricks.z; ++z)
        for (int y = 0; y < p.hemisphere.bricks.y; ++y)
            for (int x = 0; x < p.hemisphere.bricks.x; x += 3) {
                LightMeshMasks masks = lightmesh_masks(p.hemisphere, ivec3(x, y, z));
                for (int i = 0; i < 3; ++i) {
                    uvec2 mask = i == 0 ? masks.of[0] : i == 1 ? masks.of[1] : masks.of[2];
                    if ((mask.x | mask.y) == 0u)
                        continue;
                    pass.size += lightmesh_bits_in(mask);
                    ivec3 coord = p.hemisphere.first + ivec3(x + i, y, z);
                    if (p.is_linked && !only_agrees) {
                        mask &= lightmesh_reached_by_all(p.floods, coord);
                        if ((mask.x | mask.y) == 0u)
                            continue;
                    }
#if defined(LIGHTMESH_EXACT) && !defined(LIGHTMESH_NO_RAYS)
                    if (p.is_tested) {
                        mask = lightmesh_seen(p, coord, mask);
                        if ((mask.x | mask.y) == 0u)
                            continue;
                    }
#endif
                    pass.linked += lightmesh_bits_in(mask);
                    if (region_at != coord >> 2) {
                        region_at = coord >> 2;
                        region = lightmesh_find_region(p.level, region_at);
                    }
                    uint brick = lightmesh_brick_of(region, coord);
                    if (brick == lightmesh_no_brick) {
                        pass.missing_groups = groups;
                        pass.agrees = pass.agrees && groups == 0u;
                        continue;
                    }
                    uint record = lightmesh_tile_record(brick, t);
                    uvec4 known = lightmesh_bricks[record], of_cells = lightmesh_bricks[record + 1u];
                    uvec2 lit = of_cells.xy;
                    if (only_agrees) {
                        pass.agrees = pass.agrees && ((lights.x & ~known.z) | (lights.y & ~known.w)) == 0u;
                        all_lit &= lit;
                        any_lit |= lit & lights;
                        continue;
                    }
                    uvec2 unknown = lightmesh_cells_in(mask) & ~known.xy & uvec2(groups * 0x01010101u);
                    // Of lights that are uniform cells know nothing, or the same.
                    if ((unknown.x | unknown.y) != 0u)
                        unknown &= uvec2(lightmesh_groups_of(lights & ~known.zw) * 0x01010101u);
                    uint folded = unknown.x | unknown.y;
                    folded |= folded >> 16;
                    pass.missing_groups |= (folded | folded >> 8) & 0xffu;
                    uvec2 left = mask & of_cells.zw;
                    uint uniform_points = uint(lightmesh_bits_in(mask & ~of_cells.zw));
                    while ((left.x | left.y) != 0u) {
                        bool is_low = left.x != 0u;
                        uint four = is_low ? left.x : left.y;
                        uint cell = uint(findLSB(four)) >> 3;
                        uint points = four >> (8u * cell) & 0xffu;
                        four &= ~(0xffu << (8u * cell));
                        left = is_low ? uvec2(four, left.y) : uvec2(0u, four);
                        uvec4 words = lightmesh_bricks[record + (is_low ? 2u : 3u)];
                        lightmesh_add_cell(tile, lightmesh_component(words, cell), points);
                    }
                    if (uniform_points == 0u)
                        continue;
                    if (lit != pending) {
                        lightmesh_add(tile, pending, pending_count);
                        pending = lit;
                        pending_count = 0u;
                    }
                    pending_count += uniform_points;
                }
            }
    lightmesh_add(tile, pending, pending_count);
    pass.agrees = pass.agrees && all_lit == any_lit;
    return pass;
}

#ifndef LIGHTMESH_NO_RAYS
// S where no light point tells: a ray to each light.
void lightmesh_ask_rays(LightMeshPoint p, uint t, inout LightMeshTile tile) {
    for (uint l = 0u; l < 64u; ++l) {
        uint word = l < 32u ? tile.reaching.x : tile.reaching.y;
        if ((word >> (l & 31u) & 1u) == 0u ||
            !lightmesh_is_open(p.end, lightmesh_light_end(p.level, lightmesh_light(64u * t + l), p.end)))
            continue;
        if (l < 32u)
            tile.planes[0].x |= 1u << l;
        else
            tile.planes[0].y |= 1u << (l - 32u);
    }
}
#endif

#if defined(LIGHTMESH_EXACT) && !defined(LIGHTMESH_NO_RAYS)
// True if the exact short test can change what was counted: if light points disagree about a light, or P sees none of
// them.
bool lightmesh_needs_test(LightMeshPoint p, uvec2 lights, LightMeshPass pass, LightMeshTile tile) {
    if (pass.size == 0 || pass.missing_groups != 0u)
        return false;
    uvec2 none = lights, all = lights;
    for (int k = 0; k < LIGHTMESH_PLANES; ++k) {
        none &= ~tile.planes[k];
        all &= (pass.size >> k & 1) != 0 ? tile.planes[k] : ~tile.planes[k];
    }
    ivec3 seen;
    return (none | all) != lights || !lightmesh_find_seen(p, seen);
}
#endif

void lightmesh_clear(inout LightMeshTile tile) {
    for (int k = 0; k < LIGHTMESH_PLANES; ++k)
        tile.planes[k] = uvec2(0u);
}

// 64 lights at a point. Writes a request if something is missing that `fill` can find.
LightMeshTile lightmesh_tile(inout LightMeshPoint p, uint t) {
    LightMeshTile tile;
    lightmesh_clear(tile);
    tile.missing = uvec2(0u);
    tile.why = p.missing;
    tile.m = 1;
    if ((p.missing & lightmesh_outside) != 0u) {
        tile.reaching = tile.missing = uvec2(0xffffffffu);
        return tile;
    }
    tile.reaching = uvec2(0u);
    LightMeshPass pass = LightMeshPass(0, 0, 0u, false);
    uvec2 lights = uvec2(0u);  // that reach P, of `tile_of_lights`
    uint tile_of_lights = lightmesh_tile_count();
    // Where P sees a light point of which nobody knows what it reaches, that does not matter if all bricks say the
    // same: then tile by tile is asked whether they do. Tiles that do so far; ~0: it is not asked.
    uint agreeing = 0xffffffffu;
    ivec3 seed = ivec3(0);
    p.is_tested = false;
    // Until no more seeds are needed; once for later tiles.
    while (true) {
        bool only_agrees = agreeing != 0xffffffffu;
        uint now = only_agrees ? agreeing : t;
        if (now != tile_of_lights)
            lights = lightmesh_reaching(p.position, p.unit, now);
        tile_of_lights = now;
        bool is_last = p.is_settled;
        if (!only_agrees) {
            tile.reaching = lights;
            if (lights == uvec2(0u))
                return tile;
            bool has_no_light_points = is_last && p.size >= 0 && p.linked == 0;
            if (p.missing != 0u || p.uniform_brick != lightmesh_no_brick || has_no_light_points)
                break;
#ifndef LIGHTMESH_NO_RAYS
            if (!is_last) {
                int sought = lightmesh_seek_flood(p, seed);
                p.is_settled = sought == lightmesh_no_seed;
                if (p.is_settled)
                    break;  // what was counted last counts
                if (sought == lightmesh_no_flood) {
                    agreeing = 0u;
                    continue;
                }
            }
#endif
            lightmesh_clear(tile);
        }
        LightMeshPass found = lightmesh_count(p, now, lights, only_agrees, tile);
        if (only_agrees) {
            if (!found.agrees) {
                p.missing = lightmesh_not_filled;
                break;
            }
            if (++agreeing == lightmesh_tile_count()) {
                p.uniform_brick = lightmesh_find_brick(p.level, seed >> 2);
                break;
            }
            continue;
        }
        pass = found;
        p.size = pass.size;
        p.linked = pass.linked;
        p.is_settled = is_last || (p.floods.count > 0 && 3 * p.linked >= 2 * p.size);
#if defined(LIGHTMESH_EXACT) && !defined(LIGHTMESH_NO_RAYS)
        if (lightmesh.short_test == 2u && !p.is_tested && lightmesh_needs_test(p, lights, pass, tile)) {
            p.is_tested = true;
            continue;
        }
#endif
        if (p.is_settled)
            break;
    }
    if (p.missing != 0u) {
        lightmesh_clear(tile);
        tile.why = p.missing;
        tile.missing = tile.reaching;
        if ((p.missing & lightmesh_not_filled) != 0u)
            lightmesh_request(p);
        return tile;
    }
    if (p.uniform_brick != lightmesh_no_brick) {
        lightmesh_clear(tile);
        tile.planes[0] = lightmesh_bricks[lightmesh_tile_record(p.uniform_brick, t) + 1u].xy;
        return tile;
    }
    if (p.linked == 0) {
#ifdef LIGHTMESH_NO_RAYS
        tile.why = lightmesh_no_ray;
        tile.missing = tile.reaching;
#else
        lightmesh_ask_rays(p, t, tile);
#endif
        return tile;
    }
    tile.m = p.linked;
    tile.missing = lightmesh_lights_of(pass.missing_groups) & tile.reaching;
    if (pass.missing_groups != 0u) {
#ifdef LIGHTMESH_EXACT
        // The exact short test waits until all is known.
        if (lightmesh.short_test == 2u)
            tile.missing = tile.reaching;
#endif
        tile.why = lightmesh_not_filled;
        lightmesh_request(p);
    }
    return tile;
}

// Of how many of m light points light l of a tile is seen.
uint lightmesh_count_of(LightMeshTile tile, uint l) {
    uint count = 0u;
    for (int k = 0; k < LIGHTMESH_PLANES; ++k)
        count |= ((l < 32u ? tile.planes[k].x : tile.planes[k].y) >> (l & 31u) & 1u) << k;
    uint reaching = (l < 32u ? tile.reaching.x : tile.reaching.y) >> (l & 31u) & 1u;
    return reaching != 0u ? count : 0u;
}

// True if S of light l of a tile is not known.
bool lightmesh_is_missing(LightMeshTile tile, uint l) {
    return ((l < 32u ? tile.missing.x : tile.missing.y) >> (l & 31u) & 1u) != 0u;
}

// S of light l of a tile, 0 to 1, as `LightMesh::visibility`. Means nothing for a light that is missing.
float lightmesh_visibility(LightMeshTile tile, uint l) {
    uint count = lightmesh_count_of(tile, l);
    return count == 0u ? 0.0 : lightmesh_quotient(float(count), float(tile.m));
}

#if LIGHTMESH_PLANES == 8
// Of four lights from light l on, a multiple of four: 8 bits each.
uint lightmesh_counts_of_four(LightMeshTile tile, uint l) {
    uint shift = l & 31u, counts = 0u;
    uint reaching = (l < 32u ? tile.reaching.x : tile.reaching.y) >> shift;
    for (int k = 0; k < 8; ++k) {
        uint bits = (l < 32u ? tile.planes[k].x : tile.planes[k].y) >> shift & reaching & 15u;
        counts |= (bits * 0x00204081u & 0x01010101u) << k;
    }
    return counts;
}
#endif

// The same of four lights from light l on, a multiple of four.
vec4 lightmesh_visibility_of_four(LightMeshTile tile, uint l) {
#if LIGHTMESH_PLANES == 8
    // 1 / m as the sum of two floats, of which the first has 16 bits: its product with a count is exact, and that of
    // the second too small for its error to matter, as no quotient of such numbers is near to the middle of two floats.
    float m = float(tile.m);
    precise float high = uintBitsToFloat(floatBitsToUint(1.0 / m) & 0xffffff00u);
    precise float rest = 1.0 - m * high;
    precise float low = rest / m;
    uint counts = lightmesh_counts_of_four(tile, l);
    vec4 count = vec4(uvec4(counts & 0xffu, counts >> 8 & 0xffu, counts >> 16 & 0xffu, counts >> 24));
    precise vec4 shares = count * high + count * low;
    return shares;
#else
    return vec4(lightmesh_visibility(tile, l), lightmesh_visibility(tile, l + 1u), lightmesh_visibility(tile, l + 2u),
                lightmesh_visibility(tile, l + 3u));
#endif
}

// ---- points with footprints

struct LightMeshBlend {
    float coarser_share;  // 0: there is only one level
    LightMeshPoint fine;
    LightMeshPoint coarse;
};

// 64 lights at such a point.
struct LightMeshBlendTile {
    float coarser_share;
    uvec2 missing;  // as of `LightMeshTile`
    uint why;
    LightMeshTile fine;
    LightMeshTile coarse;
};

// Begins a query at a point with a footprint, world units; 0, NaN or negative: none.
LightMeshBlend lightmesh_point(vec3 P, vec3 n, float footprint) {
    LightMeshLevels levels = lightmesh_levels(footprint);
    LightMeshBlend p;
    p.coarser_share = levels.coarser_share;
    int last = levels.level + (levels.coarser_share > 0.0 ? 1 : 0);
    for (int level = levels.level; level <= last; ++level) {
        LightMeshPoint on = lightmesh_point_on(level, P, n, footprint);
        if (level == levels.level)
            p.fine = on;
        else
            p.coarse = on;
    }
    return p;
}

// As of a point without a footprint.
LightMeshBlendTile lightmesh_tile(inout LightMeshBlend p, uint t) {
    LightMeshBlendTile tile;
    tile.coarser_share = p.coarser_share;
    tile.missing = uvec2(0u);
    tile.why = 0u;
    int count = p.coarser_share > 0.0 ? 2 : 1;
    for (int i = 0; i < count; ++i) {
        LightMeshPoint on = p.fine;
        if (i == 1)
            on = p.coarse;
        LightMeshTile found = lightmesh_tile(on, t);
        tile.missing |= found.missing;
        tile.why |= found.why;
        if (i == 0) {
            p.fine = on;
            tile.fine = found;
        } else {
            p.coarse = on;
            tile.coarse = found;
        }
    }
    return tile;
}

bool lightmesh_is_missing(LightMeshBlendTile tile, uint l) {
    return ((l < 32u ? tile.missing.x : tile.missing.y) >> (l & 31u) & 1u) != 0u;
}

float lightmesh_visibility(LightMeshBlendTile tile, uint l) {
    float fine = lightmesh_visibility(tile.fine, l);
    if (!(tile.coarser_share > 0.0))
        return fine;
    return lightmesh_blended(fine, lightmesh_visibility(tile.coarse, l), tile.coarser_share);
}

vec4 lightmesh_visibility_of_four(LightMeshBlendTile tile, uint l) {
    vec4 fine = lightmesh_visibility_of_four(tile.fine, l);
    if (!(tile.coarser_share > 0.0))
        return fine;
    vec4 coarse = lightmesh_visibility_of_four(tile.coarse, l);
    for (int i = 0; i < 4; ++i)
        fine[i] = lightmesh_blended(fine[i], coarse[i], tile.coarser_share);
    return fine;
}

#endif
