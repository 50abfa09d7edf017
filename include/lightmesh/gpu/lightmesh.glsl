// SPDX-License-Identifier: MIT
//
// Light meshes in shaders: S of equation (3) at a surface point from a mesh that `lightmesh::MeshUpload`
// (mesh_upload.hpp) laid out, bit-equal to `LightMesh::visibility` on the CPU. For any number of lights, q of
// 1 to 16, ShortTest::none and linked.
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
//
// GLSL 4.5 for Vulkan 1.0: no 64-bit types, no subgroups, no shared memory; in any stage that can write to
// storage buffers. Sums and products must round to nearest, as they do on all GPUs; what the CPU does in
// double is done in integers here.
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
// Whether nothing lies on the segment between two points, world units. Yours to define.
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
};
layout(std430, set = LIGHTMESH_SET, binding = LIGHTMESH_BINDING) readonly buffer LightMeshHeader {
    uvec2 steps_per_footprint;  // a double
    float quality;
    uint short_test;  // 0: none, 1: linked
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
    uint lightmesh_lights[];
};
layout(std430, set = LIGHTMESH_SET, binding = LIGHTMESH_BINDING + 2) readonly buffer LightMeshDirectory {
    uint lightmesh_directory[];
};
layout(std430, set = LIGHTMESH_SET, binding = LIGHTMESH_BINDING + 3) readonly buffer LightMeshBricks {
    uint lightmesh_bricks[];
};
layout(std430, set = LIGHTMESH_SET, binding = LIGHTMESH_BINDING + 4) readonly buffer LightMeshBits {
    uvec2 lightmesh_bits[];
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

// a * b as the sum of two floats. Dekker 1971, "A Floating-Point Technique for Extending the Available
// Precision".
vec2 lightmesh_product(float a, float b) {
    precise float ca = 4097.0 * a;
    precise float ah = ca - (ca - a);
    precise float al = a - ah;
    precise float cb = 4097.0 * b;
    precise float bh = cb - (cb - b);
    precise float bl = b - bh;
    precise float p = a * b;
    precise float e = ((ah * bh - p) + ah * bl + al * bh) + al * bl;
    return vec2(p, e);
}

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
    vec3 scaled = vec3(lightmesh_quotient(v.x, largest), lightmesh_quotient(v.y, largest),
                       lightmesh_quotient(v.z, largest));
    float inverse = lightmesh_quotient(1.0, lightmesh_root(lightmesh_length_squared(scaled)));
    precise vec3 unit = scaled * inverse;
    return unit;
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

const uint lightmesh_light_words = 16u;
const uint lightmesh_light_tile_words = 8u;

uint lightmesh_tile_count() {
    return (lightmesh.light_count + 63u) >> 6;
}

// Number of lights in a tile.
uint lightmesh_tile_size(uint tile) {
    return min(64u, lightmesh.light_count - 64u * tile);
}

// The number of light l of a tile, as `LightMesh::visibility` counts them.
uint lightmesh_light_at(uint tile, uint l) {
    return lightmesh_lights[lightmesh_light_tile_words * lightmesh_tile_count() +
                            lightmesh_light_words * (64u * tile + l) + 15u];
}

uint lightmesh_light(uint slot) {
    return lightmesh_light_tile_words * lightmesh_tile_count() + lightmesh_light_words * slot;
}

vec3 lightmesh_light_vector(uint word) {
    return uintBitsToFloat(
        uvec3(lightmesh_lights[word], lightmesh_lights[word + 1u], lightmesh_lights[word + 2u]));
}

uvec2 lightmesh_light_double(uint word) {
    return uvec2(lightmesh_lights[word], lightmesh_lights[word + 1u]);
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

// Whether a light's cone holds the offset from the light to a point; exact.
bool lightmesh_cone_holds(uint light, vec3 offset, bool is_wide) {
    uvec2 along = uvec2(0u), across = uvec2(0u);
    for (int i = 0; i < 3; ++i) {
        int j = i == 2 ? 0 : i + 1, k = i == 0 ? 2 : i - 1;
        uvec2 axis_j = lightmesh_light_double(light + 7u + 2u * uint(j));
        uvec2 axis_k = lightmesh_light_double(light + 7u + 2u * uint(k));
        uvec2 offset_j = lightmesh_double_of(offset[j]), offset_k = lightmesh_double_of(offset[k]);
        uvec2 component = lightmesh_double_subtract(lightmesh_double_multiply(axis_j, offset_k),
                                                    lightmesh_double_multiply(offset_j, axis_k));
        across = lightmesh_double_add(across, lightmesh_double_multiply(component, component));
        uvec2 axis_i = lightmesh_light_double(light + 7u + 2u * uint(i));
        along = lightmesh_double_add(along, lightmesh_double_multiply(axis_i, lightmesh_double_of(offset[i])));
    }
    uvec2 limit = lightmesh_double_multiply(lightmesh_light_double(light + 13u), along);
    limit = lightmesh_double_multiply(limit, along);
    uvec2 left = lightmesh_double_subtract(limit, across);
    bool is_behind = lightmesh_double_is_negative(along), is_outside = lightmesh_double_is_negative(left);
    return is_wide ? !is_behind || is_outside || left.y == 0u : !is_behind && !is_outside;
}

float lightmesh_double_as_float(uint word) {
    return lightmesh_double_to_float(lightmesh_light_double(word));
}

// The same; by floats where they can tell.
bool lightmesh_in_cone(uint light, vec3 offset, bool is_wide) {
    float largest = lightmesh_largest(offset);
    vec3 w = offset / largest;
    vec3 axis = vec3(lightmesh_double_as_float(light + 7u), lightmesh_double_as_float(light + 9u),
                     lightmesh_double_as_float(light + 11u));
    float tangent_squared = lightmesh_double_as_float(light + 13u);
    float along = dot(axis, w);
    vec3 across = cross(axis, w);
    float limit = tangent_squared * along * along;
    float difference = limit - dot(across, across);
    float band = 3.8e-6 * (3.0 + 2.0 * tangent_squared * abs(along));
    if (!(largest > 1e-15 && largest < 1e15 && abs(along) > 3.8e-6 && abs(difference) > band))
        return lightmesh_cone_holds(light, offset, is_wide);
    return is_wide ? along > 0.0 || difference < 0.0 : along > 0.0 && difference > 0.0;
}

// One bit for each light of a tile that can reach P at all.
uvec2 lightmesh_reaching(vec3 P, vec3 n, uint tile) {
    uint of_tile = lightmesh_light_tile_words * tile;
    vec3 low = lightmesh_light_vector(of_tile), high = lightmesh_light_vector(of_tile + 3u);
    if (any(lessThan(P, low)) || any(greaterThan(P, high)))
        return uvec2(0u);
    float largest_at = uintBitsToFloat(lightmesh_lights[of_tile + 6u]);
    float band = 9.5367431640625e-7 * (largest_at + abs(P.x) + abs(P.y) + abs(P.z));
    uvec2 reaching = uvec2(0u);
    uint size = lightmesh_tile_size(tile);
    for (uint l = 0u; l < size; ++l) {
        uint light = lightmesh_light(64u * tile + l);
        uint kind = lightmesh_lights[light + 3u];
        vec3 at = lightmesh_light_vector(light);
        bool is_directional = (kind & lightmesh_is_directional) != 0u;
        precise vec3 offset = is_directional ? at : at - P;
        float height = dot(n, offset);
        if (height < -band || (kind & lightmesh_reaches_nothing) != 0u)
            continue;
        if (!(height > band) && lightmesh_double_is_negative(lightmesh_dot(n, offset)))
            continue;
        if ((kind & lightmesh_has_range) != 0u) {
            float distance = dot(offset, offset);
            float range = uintBitsToFloat(lightmesh_lights[light + 6u]);  // squared
            bool is_told = (kind & lightmesh_has_odd_range) == 0u;
            if (is_told && distance > 1.00001 * range)
                continue;
            if (!(is_told && distance < 0.99999 * range) &&
                lightmesh_double_less(lightmesh_light_double(light + 4u), lightmesh_dot(offset, offset)))
                continue;
        }
        if ((kind & lightmesh_has_cone) != 0u) {
            precise vec3 from_light = P - at;
            if (!lightmesh_in_cone(light, from_light, (kind & lightmesh_has_wide_cone) != 0u))
                continue;
        }
        if (l < 32u)
            reaching.x |= 1u << l;
        else
            reaching.y |= 1u << (l - 32u);
    }
    return reaching;
}

// ---- the hemisphere of equation (2)

const uint lightmesh_no_ray = 1u;       // it needs a ray, and there is no lightmesh_is_open
const uint lightmesh_not_filled = 2u;   // `fill` finds what it needs
const uint lightmesh_outside = 4u;      // P or n is not finite, or P lies outside of the grid
const uint lightmesh_not_served = 8u;   // q is greater than LIGHTMESH_MAX_QUALITY

// In fixed point: see query/hemisphere.hpp.
struct LightMeshHemisphere {
    ivec3 first;     // coordinates of the first brick of its box
    ivec3 bricks;    // of the box
    ivec3 position;  // from the first brick's first light point
    ivec3 slope;
    int lowest_height;
};

// What the seeds that P sees reach.
struct LightMeshFloods {
    int count;
    uint at[20];
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
    int m;         // number of light points that are averaged; 0: shadow rays decide; -1: not counted yet
    bool is_requested;
    bool is_linked;  // only what floods reach is averaged
    uint uniform_brick;  // a brick like all others for the lights that reach P; lightmesh_no_brick: they differ
    LightMeshHemisphere hemisphere;
    LightMeshFloods floods;
};

// Light points of a brick of the box, 8 bits a cell as everywhere in the library.
uvec2 lightmesh_brick_mask(LightMeshHemisphere p, ivec3 brick) {
    int one = 1 << lightmesh.fraction_bits;
    ivec3 low = (brick << (2 + int(lightmesh.fraction_bits))) - p.position;
    ivec3 high = low + 3 * one;
    ivec3 least = max(max(low, -high), ivec3(0));
    ivec3 far = max(abs(low), abs(high));
    ivec3 height_low = low * p.slope, height_high = high * p.slope;
    ivec3 greatest_height = max(height_low, height_high), least_height = min(height_low, height_high);
    int radius_squared = lightmesh.radius_squared;
    least *= least;
    far *= far;
    if (least.x + least.y + least.z >= radius_squared ||
        greatest_height.x + greatest_height.y + greatest_height.z <= p.lowest_height)
        return uvec2(0u);
    if (far.x + far.y + far.z < radius_squared &&
        least_height.x + least_height.y + least_height.z > p.lowest_height)
        return uvec2(0xffffffffu);
    ivec4 x = ivec4(low.x, low.x + one, low.x + 2 * one, high.x);
    ivec4 square_x = x * x, height_x = x * p.slope.x;
    uvec2 mask = uvec2(0u);
    for (int z = 0; z < 4; ++z) {
        int dz = low.z + z * one;
        int square_z = radius_squared - dz * dz, height_z = p.lowest_height - dz * p.slope.z;
        uint of_z = 0u;
        for (int y = 0; y < 4; ++y) {
            int dy = low.y + y * one;
            ivec4 square_left = ivec4(square_z - dy * dy), height_left = ivec4(height_z - dy * p.slope.y);
            uvec4 inside = uvec4(lessThan(square_x, square_left)) & uvec4(greaterThan(height_x, height_left));
            of_z |= (inside.x | inside.y << 1 | inside.z << 8 | inside.w << 9) << ((y >> 1) * 16 + (y & 1) * 2);
        }
        of_z <<= (z & 1) * 4;
        if (z < 2)
            mask.x |= of_z;
        else
            mask.y |= of_z;
    }
    return mask;
}

int lightmesh_bits_in(uvec2 mask) {
    ivec2 counts = bitCount(mask);
    return counts.x + counts.y;
}

int lightmesh_lowest_height(int level, float largest) {
    // 2^15 (2 + 2^f largest 2^-22 / step): where it is far from a whole number floats are enough.
    float scale = uintBitsToFloat(uint(127 + int(lightmesh.fraction_bits) - 7) << 23);
    float guess = (largest / lightmesh.levels[level].step_float) * scale;
    float fraction = fract(guess);
    if (guess < 65536.0 && fraction > 0.02 && fraction < 0.98)
        return 65536 + int(guess);
    uvec2 rounding = lightmesh_double_of(largest);
    rounding = lightmesh_double_divide(lightmesh_double_scale(rounding, -22), lightmesh.levels[level].step);
    rounding = lightmesh_double_scale(rounding, int(lightmesh.fraction_bits));
    uvec2 height = lightmesh_double_scale(lightmesh_double_add(lightmesh_double_of(2.0), rounding), 15);
    return lightmesh_double_exponent(height) >= 31 ? 0x7fffffff : lightmesh_double_floor(height);
}

// Places in the grid, in steps, as `Grid::locate`.
struct LightMeshGridPos {
    uvec2 at[3];
};

const uint lightmesh_no_brick = 0xffffffffu;

// Fills in the hemisphere; false if P lies outside of the grid.
bool lightmesh_find_hemisphere(inout LightMeshPoint p, out LightMeshGridPos grid_pos) {
    LightMeshFixed quality = lightmesh_fixed(lightmesh_double_of(lightmesh.quality));
    for (int axis = 0; axis < 3; ++axis) {
        uvec2 at = lightmesh_double_multiply(
            lightmesh_double_subtract(lightmesh_double_of(p.position[axis]), lightmesh.levels[p.level].origin[axis]),
            lightmesh.levels[p.level].inverse_step);
        grid_pos.at[axis] = at;
        if (!lightmesh_double_less(lightmesh_double_abs(at), lightmesh_double_of(16777152.0)))
            return false;
        LightMeshFixed fixed_at = lightmesh_fixed(at);
        int low = fixed_at.whole - quality.whole - (fixed_at.high < quality.high ? 1 : 0);
        int high = fixed_at.whole + quality.whole + (fixed_at.high + quality.high < fixed_at.high ? 1 : 0);
        p.hemisphere.first[axis] = low >> 2;
        p.hemisphere.bricks[axis] = (high >> 2) - p.hemisphere.first[axis] + 1;
        LightMeshFixed from_first = lightmesh_fixed(
            lightmesh_double_subtract(at, lightmesh_double_of(4 * p.hemisphere.first[axis])));
        uint bits = lightmesh.fraction_bits;
        uint below = from_first.high >> (31u - bits);  // one bit more than is kept
        p.hemisphere.position[axis] = (from_first.whole << bits) + int((below + 1u) >> 1);
        // 2^15 n + 1/2 is exact: n has 24 bits.
        LightMeshFixed fixed_slope = lightmesh_fixed(lightmesh_double_scale(lightmesh_double_of(p.unit[axis]), 15));
        p.hemisphere.slope[axis] = fixed_slope.whole + int(fixed_slope.high >> 31);
    }
    p.hemisphere.lowest_height = lightmesh_lowest_height(p.level, lightmesh_largest(p.position));
    return true;
}

// ---- bricks

// Word of the record of a level's brick; 0xffffffff if it is not there.
uint lightmesh_find_brick(int level, ivec3 coord) {
    ivec3 region = coord >> 2;
    uvec3 r = uvec3(region);
    uint hash = r.x * 0x9e3779b1u ^ r.y * 0x85ebca77u ^ r.z * 0xc2b2ae3du ^ uint(level) * 0x27d4eb2fu;
    hash ^= hash >> 15;
    for (uint slot = hash & lightmesh.slot_mask;; slot = (slot + 1u) & lightmesh.slot_mask) {
        uint named = lightmesh_directory[4u * slot + 3u];
        if (named == 0u)
            return lightmesh_no_brick;
        ivec3 of = ivec3(lightmesh_directory[4u * slot], lightmesh_directory[4u * slot + 1u],
                         lightmesh_directory[4u * slot + 2u]);
        if (of != region || named >> 27 != uint(level))
            continue;
        uint in_region = uint((coord.x & 3) + 4 * (coord.y & 3) + 16 * (coord.z & 3));
        uint brick = lightmesh_directory[lightmesh.first_region + 64u * ((named & 0x07ffffffu) - 1u) + in_region];
        return brick == 0u ? lightmesh_no_brick : (brick - 1u) * lightmesh.brick_words;
    }
}

const uint lightmesh_brick_head = 4u;
const uint lightmesh_tile_words = 16u;

uint lightmesh_tile_record(uint brick, uint tile) {
    return brick + lightmesh_brick_head + lightmesh_tile_words * tile;
}

uvec2 lightmesh_brick_pair(uint word) {
    return uvec2(lightmesh_bricks[word], lightmesh_bricks[word + 1u]);
}

// ---- floods: what the seeds of the linked short test reach

// Place plus one in `lightmesh_bits` of the flood of a light point; 0 if nobody has looked.
uint lightmesh_find_flood(int level, ivec3 seed) {
    uint brick = lightmesh_find_brick(level, seed >> 2);
    if (brick == lightmesh_no_brick)
        return 0u;
    uint table = lightmesh_bricks[brick];
    if (table == 0u)
        return 0u;
    uint bit = uint(8 * ((seed.x >> 1 & 1) + 2 * (seed.y >> 1 & 1) + 4 * (seed.z >> 1 & 1)) + (seed.x & 1) +
                    2 * (seed.y & 1) + 4 * (seed.z & 1));
    uvec2 seeds = lightmesh_brick_pair(brick + 2u);
    uint word = bit < 32u ? seeds.x : seeds.y;
    uint one = 1u << (bit & 31u);
    if ((word & one) == 0u)
        return 0u;
    int rank = bitCount(word & (one - 1u)) + (bit < 32u ? 0 : bitCount(seeds.x));
    uvec2 at = lightmesh_bits[(table - 1u) + uint(rank >> 1)];
    return (rank & 1) == 0 ? at.x : at.y;
}

// What a flood reaches in a brick.
uvec2 lightmesh_reached(uint flood, ivec3 coord) {
    uint at = flood - 1u;
    uvec2 first_xy = lightmesh_bits[at];
    ivec3 p = coord - ivec3(first_xy, lightmesh_bits[at + 1u].x);
    int side = lightmesh.flood_side;
    if (any(lessThan(p, ivec3(0))) || any(greaterThanEqual(p, ivec3(side))))
        return uvec2(0u);
    uint slot = uint(p.x + side * (p.y + side * p.z));
    uint one = 1u << (slot & 31u);
    uvec2 of = lightmesh_bits[at + 2u + (slot >> 5)];  // slots that are full, slots that are partial
    if ((of.x & one) != 0u)
        return uvec2(0xffffffffu);
    if ((of.y & one) == 0u)
        return uvec2(0u);
    uint ranks = lightmesh.flood_words;
    uvec2 before = lightmesh_bits[at + 2u + ranks + (slot >> 6)];
    uint rank = ((slot >> 5 & 1u) == 0u ? before.x : before.y) + uint(bitCount(of.y & (one - 1u)));
    return lightmesh_bits[at + 2u + ranks + ((ranks + 1u) >> 1) + rank];
}

uvec2 lightmesh_reached_by_all(LightMeshFloods floods, ivec3 coord) {
    uvec2 reached = uvec2(0u);
    for (int i = 0; i < floods.count; ++i)
        reached |= lightmesh_reached(floods.at[i], coord);
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

vec3 lightmesh_light_point(int level, ivec3 light_point) {
    vec3 position;
    for (int axis = 0; axis < 3; ++axis)
        position[axis] = lightmesh_double_to_float(lightmesh_double_add(
            lightmesh.levels[level].origin[axis],
            lightmesh_double_multiply(lightmesh.levels[level].step, lightmesh_double_of(light_point[axis]))));
    return position;
}

bool lightmesh_in_hemisphere(LightMeshHemisphere p, ivec3 light_point) {
    ivec3 d = ((light_point - 4 * p.first) << lightmesh.fraction_bits) - p.position;
    ivec3 squares = d * d, heights = d * p.slope;
    return squares.x + squares.y + squares.z < lightmesh.radius_squared &&
           heights.x + heights.y + heights.z > p.lowest_height;
}

// Number of light points of the hemisphere, and of those that floods reach.
ivec2 lightmesh_count_points(LightMeshPoint p) {
    ivec2 counts = ivec2(0);
    for (int z = 0; z < p.hemisphere.bricks.z; ++z)
        for (int y = 0; y < p.hemisphere.bricks.y; ++y)
            for (int x = 0; x < p.hemisphere.bricks.x; ++x) {
                uvec2 mask = lightmesh_brick_mask(p.hemisphere, ivec3(x, y, z));
                if ((mask.x | mask.y) == 0u)
                    continue;
                counts.x += lightmesh_bits_in(mask);
                if (p.floods.count > 0)
                    counts.y += lightmesh_bits_in(mask & lightmesh_reached_by_all(p.floods, p.hemisphere.first + ivec3(x, y, z)));
            }
    return counts;
}

// Whether the bricks around P are known to be uniform for each of these lights, and alike.
bool lightmesh_bricks_agree(LightMeshPoint p, uint tile, uvec2 lights) {
    uvec2 all_lit = lights, any_lit = uvec2(0u);
    for (int z = 0; z < p.hemisphere.bricks.z; ++z)
        for (int y = 0; y < p.hemisphere.bricks.y; ++y)
            for (int x = 0; x < p.hemisphere.bricks.x; ++x) {
                uvec2 mask = lightmesh_brick_mask(p.hemisphere, ivec3(x, y, z));
                if ((mask.x | mask.y) == 0u)
                    continue;
                uint brick = lightmesh_find_brick(p.level, p.hemisphere.first + ivec3(x, y, z));
                uvec2 uniform_lights = uvec2(0u), lit = uvec2(0u);
                if (brick != lightmesh_no_brick) {
                    uint record = lightmesh_tile_record(brick, tile);
                    uniform_lights = lightmesh_brick_pair(record + 2u);
                    lit = lightmesh_brick_pair(record + 4u);
                }
                if (any(notEqual(lights & ~uniform_lights, uvec2(0u))))
                    return lights == uvec2(0u);
                all_lit &= lit;
                any_lit |= lit & lights;
            }
    return all_lit == any_lit;
}

#ifndef LIGHTMESH_NO_RAYS
// The light point of this number, in the order of bricks and bits.
ivec3 lightmesh_point_at(LightMeshPoint p, int number) {
    for (int z = 0; z < p.hemisphere.bricks.z; ++z)
        for (int y = 0; y < p.hemisphere.bricks.y; ++y)
            for (int x = 0; x < p.hemisphere.bricks.x; ++x) {
                uvec2 mask = lightmesh_brick_mask(p.hemisphere, ivec3(x, y, z));
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
                int cell = bit >> 3;
                return 4 * (p.hemisphere.first + ivec3(x, y, z)) +
                       ivec3(2 * (cell & 1) + (bit & 1), 2 * (cell >> 1 & 1) + (bit >> 1 & 1),
                             2 * (cell >> 2) + (bit >> 2 & 1));
            }
    return ivec3(0);
}

bool lightmesh_is_reached(LightMeshPoint p, ivec3 light_point) {
    if (p.floods.count == 0)
        return false;
    uvec2 reached = lightmesh_reached_by_all(p.floods, light_point >> 2);
    int bit = 8 * ((light_point.x >> 1 & 1) + 2 * (light_point.y >> 1 & 1) + 4 * (light_point.z >> 1 & 1)) + (light_point.x & 1) +
              2 * (light_point.y & 1) + 4 * (light_point.z & 1);
    return ((bit < 32 ? reached.x : reached.y) >> (bit & 31) & 1u) != 0u;
}

// Sets m, and the floods whose light points are averaged.
void lightmesh_link(inout LightMeshPoint p, LightMeshGridPos grid_pos) {
    bool is_uniform = true;
    bool is_lit = false;
    for (uint t = 0u; t < lightmesh_tile_count(); ++t) {
        uvec2 reaching = lightmesh_reaching(p.position, p.unit, t);
        is_lit = is_lit || reaching != uvec2(0u);
        is_uniform = is_uniform && lightmesh_bricks_agree(p, t, reaching);
        if (is_lit && !is_uniform)
            break;
    }
    if (!is_lit)
        return;
    int size = -1;  // of the hemisphere; counted where it is needed
    int linked = 0;
    p.is_linked = true;

    // As `SeedCandidates`.
    float largest = lightmesh_largest(p.position);
    int in_front = -7;
    for (int i = 0; i < 32 && largest >= lightmesh.levels[p.level].seed_bounds[i]; ++i)
        ++in_front;
    ivec3 low, fraction;
    for (int axis = 0; axis < 3; ++axis) {
        uvec2 ahead = lightmesh_double_scale(lightmesh_double_of(p.unit[axis]), in_front);
        LightMeshFixed at = lightmesh_fixed(lightmesh_double_add(grid_pos.at[axis], ahead));
        low[axis] = at.whole;
        bool rounds_to_one = at.high == 0xffffffffu && at.low >= 0xfffffc00u;
        fraction[axis] = rounds_to_one ? 1024 : int(at.high >> 22);
    }
    uint left = 255u;
    int far_seeds = 0;
    while (true) {
        ivec3 seed;
        if (left != 0u) {
            int best = 0, least = 0x7fffffff;
            for (int corner = 0; corner < 8; ++corner) {
                ivec3 to = ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
                ivec3 to_corner = 1024 * to - fraction;
                ivec3 pos = low + to;
                bool is_even = ((pos.x ^ pos.y ^ pos.z) & 1) == 0;
                int rank = 8 * (to_corner.x * to_corner.x + to_corner.y * to_corner.y + to_corner.z * to_corner.z + (is_even ? 0 : 1 << 24)) + corner;
                if ((left >> corner & 1u) != 0u && rank < least) {
                    least = rank;
                    best = corner;
                }
            }
            left &= ~(1u << best);
            seed = low + ivec3(best & 1, best >> 1 & 1, best >> 2);
            if (!lightmesh_in_hemisphere(p.hemisphere, seed))
                continue;
        } else {
            if (size < 0)
                size = lightmesh_count_points(p).x;
            if (far_seeds == 12 || 4 * linked >= size)
                break;
            seed = lightmesh_point_at(p, (2 * far_seeds + 1) * size / 24);
            ++far_seeds;
        }
        if (lightmesh_is_reached(p, seed) || !lightmesh_is_open(p.end, lightmesh_light_point(p.level, seed)))
            continue;
        if (is_uniform) {
            p.uniform_brick = lightmesh_find_brick(p.level, seed >> 2);
            p.m = 1;  // as good as all of them
            return;
        }
        uint flood = lightmesh_find_flood(p.level, seed);
        if (flood == 0u) {
            p.missing = lightmesh_not_filled;
            return;
        }
        p.floods.at[p.floods.count++] = flood;
        ivec2 counts = lightmesh_count_points(p);
        size = counts.x;
        linked = counts.y;
        if (3 * linked >= 2 * size)
            break;
    }
    p.m = linked;
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
    p.m = 0;
    p.is_requested = false;
    p.is_linked = false;
    p.uniform_brick = lightmesh_no_brick;
    p.floods.count = 0;
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
    LightMeshGridPos grid_pos;
    if (!lightmesh_find_hemisphere(p, grid_pos)) {
        p.missing = lightmesh_outside;
        return p;
    }
    if (lightmesh.quality > float(LIGHTMESH_MAX_QUALITY)) {
        p.missing = lightmesh_not_served;
        return p;
    }
    if (lightmesh.short_test == 0u) {
        p.m = -1;
        return p;
    }
#ifdef LIGHTMESH_NO_RAYS
    p.missing = lightmesh_no_ray;
#else
    lightmesh_link(p, grid_pos);
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
    uvec2 w[8];
    for (uint i = 0u; i < 8u; ++i)
        w[i] = (points >> i & 1u) != 0u ? lightmesh_bits[cell + i] : uvec2(0u);
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
    vec3 at = lightmesh_light_vector(light);
    if ((lightmesh_lights[light + 3u] & lightmesh_is_directional) != 0u) {
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

// A long test, as `fill` traces it on the CPU: whether light point p of a level's brick (see `LongTestWord`) sees the
// light in a slot, 64 * tile + l.
bool lightmesh_sees_light(uint of_level, ivec3 brick, uint p, uint slot) {
    int level = int(of_level);
    ivec3 in_brick = ivec3((p & 1u) | (p >> 2 & 2u), (p >> 1 & 1u) | (p >> 3 & 2u), (p >> 2 & 1u) | (p >> 4 & 2u));
    vec3 point = lightmesh_light_point(level, 4 * brick + in_brick);
    uint light = lightmesh_light(slot);
    vec3 end = lightmesh_light_end(level, light, point);
    bool is_far = (lightmesh_lights[light + 3u] & lightmesh_is_directional) != 0u ||
                  lightmesh_largest(lightmesh_light_vector(light)) > 16384.0 * lightmesh.levels[level].step_float;
    return is_far ? lightmesh_is_open(point, end) : lightmesh_is_open(end, point);
}
#endif

// 64 lights at a point. Writes a request if something is missing that `fill` can find.
LightMeshTile lightmesh_tile(inout LightMeshPoint p, uint t) {
    LightMeshTile tile;
    for (int k = 0; k < LIGHTMESH_PLANES; ++k)
        tile.planes[k] = uvec2(0u);
    tile.missing = uvec2(0u);
    tile.why = p.missing;
    tile.m = 1;
    if ((p.missing & lightmesh_outside) != 0u) {
        tile.reaching = tile.missing = uvec2(0xffffffffu);
        return tile;
    }
    tile.reaching = lightmesh_reaching(p.position, p.unit, t);
    if (tile.reaching == uvec2(0u))
        return tile;
    if (p.missing != 0u) {
        tile.missing = tile.reaching;
        if ((p.missing & lightmesh_not_filled) != 0u)
            lightmesh_request(p);
        return tile;
    }
    if (p.uniform_brick != lightmesh_no_brick) {
        tile.planes[0] = lightmesh_brick_pair(lightmesh_tile_record(p.uniform_brick, t) + 4u);
        return tile;
    }
    int m = 0;
    uint groups = lightmesh_groups_of(tile.reaching);
    uint missing_groups = 0u;
    uvec2 pending = uvec2(0u);
    uint pending_count = 0u;
    ivec3 bricks = p.m == 0 ? ivec3(0) : p.hemisphere.bricks;
    for (int z = 0; z < bricks.z; ++z)
        for (int y = 0; y < bricks.y; ++y)
            for (int x = 0; x < bricks.x; ++x) {
                ivec3 coord = p.hemisphere.first + ivec3(x, y, z);
                uvec2 mask = lightmesh_brick_mask(p.hemisphere, ivec3(x, y, z));
                if ((mask.x | mask.y) != 0u && p.is_linked)
                    mask &= lightmesh_reached_by_all(p.floods, coord);
                if ((mask.x | mask.y) == 0u)
                    continue;
                m += lightmesh_bits_in(mask);
                uint brick = lightmesh_find_brick(p.level, coord);
                if (brick == lightmesh_no_brick) {
                    missing_groups = groups;
                    continue;
                }
                uint record = lightmesh_tile_record(brick, t);
                uvec2 unknown =
                    lightmesh_cells_in(mask) & ~lightmesh_brick_pair(record) & uvec2(groups * 0x01010101u);
                uint folded = unknown.x | unknown.y;
                folded |= folded >> 16;
                missing_groups |= (folded | folded >> 8) & 0xffu;
                uvec2 lit = lightmesh_brick_pair(record + 4u);
                uint uniform_points = 0u;
                for (uint cell = 0u; cell < 8u; ++cell) {
                    uint points = (cell < 4u ? mask.x : mask.y) >> (8u * (cell & 3u)) & 0xffu;
                    if (points == 0u)
                        continue;
                    uint at = lightmesh_bricks[record + 6u + cell];
                    if (at == 0u)
                        uniform_points += uint(bitCount(points));
                    else if ((at & 1u) != 0u)
                        lightmesh_add(tile, lightmesh_bits[(at >> 1) - 1u], uint(bitCount(points)));
                    else
                        lightmesh_add_cell(tile, (at >> 1) - 1u, points);
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
    p.m = m;
    if (p.m == 0) {
#ifdef LIGHTMESH_NO_RAYS
        tile.why = lightmesh_no_ray;
        tile.missing = tile.reaching;
#else
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
#endif
        return tile;
    }
    tile.m = m;
    lightmesh_add(tile, pending, pending_count);
    tile.missing = lightmesh_lights_of(missing_groups) & tile.reaching;
    if (missing_groups != 0u) {
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

// Whether S of light l of a tile is not known.
bool lightmesh_is_missing(LightMeshTile tile, uint l) {
    return ((l < 32u ? tile.missing.x : tile.missing.y) >> (l & 31u) & 1u) != 0u;
}

// S of light l of a tile, 0 to 1, as `LightMesh::visibility`. Means nothing for a light that is missing.
float lightmesh_visibility(LightMeshTile tile, uint l) {
    uint count = lightmesh_count_of(tile, l);
    return count == 0u ? 0.0 : lightmesh_quotient(float(count), float(tile.m));
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

#endif
