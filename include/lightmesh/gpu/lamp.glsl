// SPDX-License-Identifier: MIT
// Where a visibility cache's rays to a lamp end: what the CPU finds by doubles, to the bit, by doubles by integers
// (doubles.glsl). Zeros are positive here.
//
//     LightMeshLampView view = lightmesh_lamp_view(lamp, origin, least_end, reach);
//     LightMeshLampPlace place = lightmesh_lamp_turned(lightmesh_lamp_disc_point(word), turn);
//     vec3 target = lightmesh_lamp_target(view, place);
#ifndef LIGHTMESH_LAMP_GLSL
#define LIGHTMESH_LAMP_GLSL

#include "doubles.glsl"

const uint lightmesh_lamp_round = 0u;  // a point or a sphere
const uint lightmesh_lamp_directional = 1u;
const uint lightmesh_lamp_rectangle = 2u;

// A light with its size. Pairs of words are doubles.
struct LightMeshLamp {
    vec3 at;  // the centre; of a directional light the unit vector towards it
    uint kind;
    vec3 half_u;  // of rectangles
    vec3 half_v;
    uvec2 radius; // of a directional light where rays end; of a rectangle 0
    uvec2 top;    // how far above its centre it reaches; of a directional light at distance 1; of a rectangle 0
    uvec2 rest;   // how far short of its centre rays end, for its size
};

// The lamp as seen from one point.
struct LightMeshLampView {
    vec3 origin;
    uvec2 share;  // of the way to the lamp that rays go
    uvec2 middle[3];
    uvec2 u[3];  // half sides, or directions across
    uvec2 v[3];
};

// A place on the lamp, along u and v.
struct LightMeshLampPlace {
    uvec2 x;
    uvec2 y;
};

// A rotation and a radius.
struct LightMeshLampTurn {
    uvec2 cosine;
    uvec2 sine;
};

// True if one ray says all.
bool lightmesh_lamp_is_point(LightMeshLamp lamp) {
    return lamp.kind != lightmesh_lamp_rectangle && lamp.radius.y == 0u;
}

// True if all of the lamp lies below the plane through a point.
bool lightmesh_lamp_is_below(LightMeshLamp lamp, vec3 point, vec3 unit_normal) {
    uvec2 height = uvec2(0u), along_u = uvec2(0u), along_v = uvec2(0u);
    for (int axis = 0; axis < 3; ++axis) {
        uvec2 n = lightmesh_double_of(unit_normal[axis]), at = lightmesh_double_of(lamp.at[axis]);
        if (lamp.kind != lightmesh_lamp_directional)
            at = lightmesh_double_subtract(at, lightmesh_double_of(point[axis]));
        height = lightmesh_double_add(height, lightmesh_double_multiply(n, at));
        if (lamp.kind == lightmesh_lamp_rectangle) {
            uvec2 u = lightmesh_double_of(lamp.half_u[axis]), v = lightmesh_double_of(lamp.half_v[axis]);
            along_u = lightmesh_double_add(along_u, lightmesh_double_multiply(n, u));
            along_v = lightmesh_double_add(along_v, lightmesh_double_multiply(n, v));
        }
    }
    uvec2 top = lamp.top;
    if (lamp.kind == lightmesh_lamp_rectangle)
        top = lightmesh_double_add(lightmesh_double_abs(along_u), lightmesh_double_abs(along_v));
    return lightmesh_double_less(height, lightmesh_double_negate(top));
}

// `least_end`: how far short of the lamp rays end at least, but for the size of its coordinates. `reach`: the greatest
// length of a ray, a double.
LightMeshLampView lightmesh_lamp_view(LightMeshLamp lamp, vec3 origin, float least_end, uvec2 reach) {
    const uvec2 one = uvec2(0u, 0x3ff00000u);
    LightMeshLampView view;
    view.origin = origin;
    view.share = one;
    bool is_far = lamp.kind == lightmesh_lamp_directional;
    uvec2 squared = uvec2(0u);
    for (int axis = 0; axis < 3; ++axis) {
        uvec2 at = lightmesh_double_of(lamp.at[axis]);
        at = is_far ? lightmesh_double_multiply(at, reach)
                    : lightmesh_double_subtract(at, lightmesh_double_of(origin[axis]));
        view.middle[axis] = at;
        squared = lightmesh_double_add(squared, lightmesh_double_multiply(at, at));
    }
    uvec2 distance = lightmesh_double_sqrt(squared);
    bool is_there = distance.y == 0u;
    uvec2 inverse = is_there ? uvec2(0u) : lightmesh_double_divide(one, distance);
    if (!is_far) {
        // The product is exact.
        precise float offset = max(max(abs(lamp.at.x), abs(lamp.at.y)), abs(lamp.at.z)) * (1.0f / 524288.0f) + least_end;
        uvec2 end = lightmesh_double_of(offset);
        uvec2 rest = lightmesh_double_less(end, lamp.rest) ? lamp.rest : end;
        uvec2 least = lamp.radius.y == 0u ? uvec2(0u, 0x3fe00000u) : uvec2(0x33333333u, 0x3fd33333u);  // .5, .3
        view.share = lightmesh_double_subtract(one, lightmesh_double_multiply(rest, inverse));
        if (lightmesh_double_less(view.share, least))
            view.share = least;
        if (is_there)
            view.share = uvec2(0u);
        if (lightmesh_double_less(reach, lightmesh_double_multiply(view.share, distance)))
            view.share = lightmesh_double_multiply(reach, inverse);
    }
    if (lamp.radius.y == 0u) {
        for (int axis = 0; axis < 3; ++axis) {
            view.u[axis] = lightmesh_double_of(lamp.half_u[axis]);
            view.v[axis] = lightmesh_double_of(lamp.half_v[axis]);
        }
        return view;
    }
    // Duff et al., "Building an Orthonormal Basis, Revisited" (JCGT 2017).
    uvec2 n[3];
    for (int axis = 0; axis < 3; ++axis)
        n[axis] = lightmesh_double_multiply(view.middle[axis], inverse);
    if (is_there)
        n[2] = one;
    bool is_down = lightmesh_double_is_negative(n[2]);
    uvec2 sign = is_down ? lightmesh_double_negate(one) : one;
    uvec2 a = lightmesh_double_negate(lightmesh_double_divide(one, lightmesh_double_add(sign, n[2])));
    uvec2 b = lightmesh_double_multiply(lightmesh_double_multiply(n[0], n[1]), a);
    uvec2 c = lightmesh_double_multiply(lightmesh_double_multiply(n[0], n[0]), a);
    uvec2 d = lightmesh_double_multiply(lightmesh_double_multiply(n[1], n[1]), a);
    view.u[0] = lightmesh_double_add(one, is_down ? lightmesh_double_negate(c) : c);
    view.u[1] = is_down ? lightmesh_double_negate(b) : b;
    view.u[2] = is_down ? n[0] : lightmesh_double_negate(n[0]);
    view.v[0] = b;
    view.v[1] = lightmesh_double_add(sign, d);
    view.v[2] = lightmesh_double_negate(n[1]);
    return view;
}

// Of the pattern of rays by 12 bits. `first`: by the lower ten of these, the cosine and the sine.
LightMeshLampTurn lightmesh_lamp_turn(uvec4 first, uint bits, uvec2 radius) {
    uvec2 c = lightmesh_double_multiply(radius, uvec2(first.x, first.y));
    uvec2 s = lightmesh_double_multiply(radius, uvec2(first.z, first.w));
    uint quarters = (bits >> 10) & 3u;
    LightMeshLampTurn turn;
    turn.cosine = (quarters & 1u) == 0u ? c : s;
    turn.sine = (quarters & 1u) == 0u ? s : c;
    if (quarters == 1u || quarters == 2u)
        turn.cosine = lightmesh_double_negate(turn.cosine);
    if (quarters >= 2u)
        turn.sine = lightmesh_double_negate(turn.sine);
    return turn;
}

LightMeshLampPlace lightmesh_lamp_turned(LightMeshLampPlace place, LightMeshLampTurn turn) {
    LightMeshLampPlace turned;
    turned.x = lightmesh_double_subtract(lightmesh_double_multiply(place.x, turn.cosine),
                                         lightmesh_double_multiply(place.y, turn.sine));
    turned.y = lightmesh_double_add(lightmesh_double_multiply(place.x, turn.sine),
                                    lightmesh_double_multiply(place.y, turn.cosine));
    return turned;
}

// A point of the disc's pattern, of which the coordinates times 1024 are the lower and the upper half of a word.
LightMeshLampPlace lightmesh_lamp_disc_point(uint word) {
    LightMeshLampPlace place;
    place.x = lightmesh_double_of(float(int(word << 16) >> 16) * (1.0f / 1024.0f));
    place.y = lightmesh_double_of(float(int(word) >> 16) * (1.0f / 1024.0f));
    return place;
}

// The i-th point of the square's pattern, shifted by 32 bits.
LightMeshLampPlace lightmesh_lamp_square_point(uint i, uint bits) {
    uint x = 0u, y = 0u, direction = 0x8000u;
    for (int digit = 0; digit < 8; ++digit) {
        uint mask = 0u - ((i >> digit) & 1u);
        x ^= mask & (0x8000u >> digit);
        y ^= mask & direction;
        direction ^= direction >> 1;
    }
    LightMeshLampPlace place;
    place.x = lightmesh_double_of((float(x ^ (bits & 0xffffu)) + 0.5f) * (1.0f / 32768.0f) - 1.0f);
    place.y = lightmesh_double_of((float(y ^ (bits >> 16)) + 0.5f) * (1.0f / 32768.0f) - 1.0f);
    return place;
}

// The i-th of eight points near the rim of a square or a disc.
LightMeshLampPlace lightmesh_lamp_rim_point(uint i, bool is_square) {
    bool is_side = (i & 1u) == 0u || is_square;
    uvec2 radius = is_side ? uvec2(0x70a3d70au, 0x3fef0a3du) : uvec2(0x169f41b0u, 0x3fe5f2d7u);  // .97, by sqrt(.5)
    uint x = (i + 1u) & 7u, y = (i + 7u) & 7u;
    LightMeshLampPlace place;
    place.x = (x & 3u) == 3u ? uvec2(0u) : x > 3u ? lightmesh_double_negate(radius) : radius;
    place.y = (y & 3u) == 3u ? uvec2(0u) : y > 3u ? lightmesh_double_negate(radius) : radius;
    return place;
}

LightMeshLampPlace lightmesh_lamp_middle() {
    LightMeshLampPlace place;
    place.x = uvec2(0u);
    place.y = uvec2(0u);
    return place;
}

// The end of the ray to a place on the lamp.
vec3 lightmesh_lamp_target(LightMeshLampView view, LightMeshLampPlace place) {
    vec3 target;
    for (int axis = 0; axis < 3; ++axis) {
        uvec2 offset = lightmesh_double_add(view.middle[axis], lightmesh_double_multiply(place.x, view.u[axis]));
        offset = lightmesh_double_add(offset, lightmesh_double_multiply(place.y, view.v[axis]));
        offset = lightmesh_double_multiply(view.share, offset);
        target[axis] = lightmesh_double_to_float(
            lightmesh_double_add(lightmesh_double_of(view.origin[axis]), offset));
    }
    return target;
}

#endif
