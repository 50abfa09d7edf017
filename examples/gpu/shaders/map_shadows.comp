#version 450
// SPDX-License-Identifier: MIT

// Whether a light is seen from each pixel's point, by look-ups in its shadow map as `lightmesh::ShadowMap::visible` and
// lookup_visibility.cpp have them. Pictures that are not there are asked for.

#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"
#include "paths.glsl"
#include "lights.glsl"

layout(local_size_x = 64) in;

struct View {
    vec4 eye;      // w: the side of a texel, at distance 1 or everywhere
    vec4 forward;  // w: 1 for parallel rays
    vec4 right;
    vec4 down;
};
layout(std430, set = 1, binding = 0) readonly buffer Map {
    uint light;
    int resolution;
    int first_face;  // of six views, and whether there is one of a cone before them
    uint there;      // a bit for each view
    float bias;
    View views[7];
}
map;
// A row of S of all lights for each pixel.
layout(std430, set = 1, binding = 1) writeonly buffer Answers {
    float answers[];
};
// Of each light a bit for each picture that is asked for.
layout(std430, set = 1, binding = 2) buffer Needed {
    uint needed[];
};
layout(std430, set = 1, binding = 3) readonly buffer Picture0 {
    float picture_0[];
};
layout(std430, set = 1, binding = 4) readonly buffer Picture1 {
    float picture_1[];
};
layout(std430, set = 1, binding = 5) readonly buffer Picture2 {
    float picture_2[];
};
layout(std430, set = 1, binding = 6) readonly buffer Picture3 {
    float picture_3[];
};
layout(std430, set = 1, binding = 7) readonly buffer Picture4 {
    float picture_4[];
};
layout(std430, set = 1, binding = 8) readonly buffer Picture5 {
    float picture_5[];
};
layout(std430, set = 1, binding = 9) readonly buffer Picture6 {
    float picture_6[];
};

struct TexelCoord {
    int view;  // -1: nothing is before it
    float column;
    float row;
    float far;  // the distance
    float stretch;
    float relative_texel;
    float absolute_texel;
};

TexelCoord coord_at(int view, float x, float y, float z) {
    float half_side = 0.5 * float(map.resolution);
    return TexelCoord(view, z > 0.0 ? half_side + half_side * (x / z) : half_side,
                      z > 0.0 ? half_side + half_side * (y / z) : half_side, 0.0, 1.0, 0.0, 0.0);
}

int face_of(vec3 direction) {
    vec3 size = abs(direction);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    return 2 * axis + (direction[axis] < 0.0 ? 1 : 0);
}

TexelCoord locate_direction(vec3 direction) {
    if (map.first_face > 0) {
        View view = map.views[0];
        float z = dot(view.forward.xyz, direction);
        float x = dot(view.right.xyz, direction) / dot(view.right.xyz, view.right.xyz);
        float y = dot(view.down.xyz, direction) / dot(view.down.xyz, view.down.xyz);
        float texels = float(map.resolution);
        if (max(abs(x), abs(y)) <= texels / (texels + 2.0) * 1.00001 * z)
            return coord_at(0, x, y, z);
    }
    int face = face_of(direction);
    View view = map.views[map.first_face + face];
    return coord_at(map.first_face + face, dot(view.right.xyz, direction), dot(view.down.xyz, direction),
                    abs(direction[face / 2]));
}

TexelCoord locate(vec3 point) {
    View first = map.views[0];
    vec3 to_point = point - first.eye.xyz;
    if (first.forward.w != 0.0) {
        float x = dot(first.right.xyz, to_point) / dot(first.right.xyz, first.right.xyz);
        float y = dot(first.down.xyz, to_point) / dot(first.down.xyz, first.down.xyz);
        bool is_inside = abs(x) <= 1.0 && abs(y) <= 1.0;
        TexelCoord coord = coord_at(is_inside ? 0 : -1, x, y, 1.0);
        coord.far = dot(first.forward.xyz, to_point);
        coord.absolute_texel = first.eye.w;
        return coord;
    }
    TexelCoord coord = locate_direction(to_point);
    coord.far = length(to_point);
    View view = map.views[coord.view];
    float cosine = coord.far > 0.0 ? dot(view.forward.xyz, to_point) / coord.far : 1.0;
    coord.stretch = 1.0 / cosine;
    coord.relative_texel = view.eye.w * cosine;
    return coord;
}

// What the pictures lack on the way.
uint lacks = 0u;

float stored_at(int view, ivec2 texel) {
    if ((map.there >> view & 1u) == 0u) {
        lacks |= 1u << view;
        return 0.0;
    }
    int i = texel.y * map.resolution + texel.x;
    switch (view) {
    case 0:
        return picture_0[i];
    case 1:
        return picture_1[i];
    case 2:
        return picture_2[i];
    case 3:
        return picture_3[i];
    case 4:
        return picture_4[i];
    case 5:
        return picture_5[i];
    default:
        return picture_6[i];
    }
}

float texel_at(TexelCoord coord, ivec2 texel) {
    if (coord.view < 0)
        return uintBitsToFloat(0x7f800000u);
    if (all(greaterThanEqual(texel, ivec2(0))) && all(lessThan(texel, ivec2(map.resolution))))
        return stored_at(coord.view, texel);
    View from = map.views[coord.view];
    if (from.forward.w != 0.0)
        return uintBitsToFloat(0x7f800000u);
    vec2 place = (vec2(texel) + 0.5) * (2.0 / float(map.resolution)) - 1.0;
    TexelCoord other = locate_direction(from.forward.xyz + place.x * from.right.xyz + place.y * from.down.xyz);
    return stored_at(other.view, clamp(ivec2(other.column, other.row), ivec2(0), ivec2(map.resolution - 1)));
}

bool is_lit(TexelCoord coord, float stored) {
    return coord.far <= stored * (1.0 + map.bias * coord.relative_texel) + map.bias * coord.absolute_texel;
}

// The plane through the texels in the direction of the point.
float surface_of(TexelCoord coord, ivec2 first, vec4 stored, vec4 weights) {
    View view = map.views[coord.view];
    if (view.forward.w != 0.0)
        return dot(weights, stored);
    float sum = 0.0;
    for (int i = 0; i < 4; ++i) {
        vec2 place = (vec2(first + ivec2(i & 1, i >> 1)) + 0.5) * (2.0 / float(map.resolution)) - 1.0;
        sum += weights[i] * length(view.forward.xyz + place.x * view.right.xyz + place.y * view.down.xyz) / stored[i];
    }
    return coord.stretch / sum;
}

bool is_visible(vec3 point) {
    TexelCoord coord = locate(point);
    vec2 at = vec2(coord.column, coord.row) - 0.5;
    vec2 corner = floor(at);
    vec2 share = at - corner;
    ivec2 first = ivec2(corner);
    vec4 stored;
    for (int i = 0; i < 4; ++i)
        stored[i] = texel_at(coord, first + ivec2(i & 1, i >> 1));
    vec4 weights = vec4((1.0 - share.x) * (1.0 - share.y), share.x * (1.0 - share.y), (1.0 - share.x) * share.y,
                        share.x * share.y);
    float lit_weight = 0.0;
    int lit_count = 0;
    for (int i = 0; i < 4; ++i)
        if (is_lit(coord, stored[i])) {
            lit_weight += weights[i];
            ++lit_count;
        }
    if (lit_count == 0 || lit_count == 4)
        return lit_count == 4;
    float nearest = min(min(stored.x, stored.y), min(stored.z, stored.w));
    float farthest = max(max(stored.x, stored.y), max(stored.z, stored.w));
    bool is_one_surface = farthest <= nearest * (1.0 + 16.0 * coord.relative_texel) + 16.0 * coord.absolute_texel;
    return is_one_surface ? is_lit(coord, surface_of(coord, first, stored, weights)) : lit_weight >= 0.5;
}

void main() {
    uint pixel = gl_GlobalInvocationID.x;
    if (pixel >= batch.count || paths[2u * pixel + 1u].w == 0u)
        return;
    PathPoint point = read_point(pixel);
    Illumination found = illuminate(read_light(map.light), point.position);
    bool faces = dot(point.normal, found.to_light) >= 0.0 && found.irradiance != vec3(0.0);
    bool is_seen = faces && is_visible(point.position);
    if (lacks != 0u)
        atomicOr(needed[map.light], lacks);
    answers[pixel * frame.numbers.x + map.light] = is_seen ? 1.0 : 0.0;
}
