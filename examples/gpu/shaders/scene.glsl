// SPDX-License-Identifier: MIT

// A scene as gpu_scene.cpp and scene_words.hpp pack it, and what is seen of it. Set 0; bindings 1 and 2 are those of
// rays.glsl.

#ifdef RAY_QUERIES
#extension GL_EXT_ray_query : require
#endif

layout(std140, set = 0, binding = 0) uniform Frame {
    vec4 eye;           // w: 1 for an orthographic view
    vec4 forward;       // w: the width of a pixel at the eye
    vec4 middle;        // of the picture beside `forward`; w: by how much a pixel widens
    vec4 right;         // half of the picture; w: z_near
    vec4 up;            // w: from z_near to z_far
    vec4 ambient;       // w: how far rays leave surfaces behind them
    vec4 background;    // w: where rays to directional lights end
    uvec4 picture;      // width, height, samples, depth limit
    uvec4 tables_at;    // in `tables`: materials, lights, textures, the sRGB curve
    uvec4 numbers;      // lights, words of a vertex, rays to a lamp of a size, their rings
    uvec4 attributes;   // in a vertex, 0 for none: normal, colour, first and second texture coordinates
    vec4 output_curve;  // exposure; 1 for the filmic curve
}
frame;

layout(std430, set = 0, binding = 3) readonly buffer Corners {
    uvec4 corners[];  // of a triangle, and its material
};
layout(std430, set = 0, binding = 4) readonly buffer Vertices {
    float vertices[];
};
layout(std430, set = 0, binding = 5) readonly buffer Tables {
    uvec4 tables[];
};
layout(std430, set = 0, binding = 6) readonly buffer Texels {
    uint texels[];
};

// ---- vertices

vec3 vertex_vec3(uint vertex, uint part) {
    uint at = vertex * frame.numbers.y + part;
    return vec3(vertices[at], vertices[at + 1u], vertices[at + 2u]);
}

vec3 between(uvec4 triangle, uint part, float u, float v) {
    return (1.0 - u - v) * vertex_vec3(triangle.x, part) + u * vertex_vec3(triangle.y, part) +
           v * vertex_vec3(triangle.z, part);
}

vec4 vertex_colour(uvec4 triangle, float u, float v) {
    uint part = frame.attributes.y;
    if (part == 0u)
        return vec4(1.0);
    vec3 weights = vec3(1.0 - u - v, u, v);
    vec3 alphas = vec3(vertices[triangle.x * frame.numbers.y + part + 3u],
                       vertices[triangle.y * frame.numbers.y + part + 3u],
                       vertices[triangle.z * frame.numbers.y + part + 3u]);
    return vec4(between(triangle, part, u, v), dot(weights, alphas));
}

vec2 texture_place(uvec4 triangle, uint which, float u, float v) {
    uint part = which == 0u ? frame.attributes.z : frame.attributes.w;
    if (part == 0u)
        return vec2(0.0);
    vec2 place = vec2(0.0);
    vec3 weights = vec3(1.0 - u - v, u, v);
    for (int i = 0; i < 3; ++i) {
        uint at = triangle[i] * frame.numbers.y + part;
        place += weights[i] * vec2(vertices[at], vertices[at + 1u]);
    }
    return place;
}

// ---- textures

const uint wrap_mirror = 1u;
const uint wrap_clamp = 2u;

int wrapped(int index, int size, uint wrap) {
    if (wrap == wrap_clamp)
        return clamp(index, 0, size - 1);
    int period = wrap == wrap_mirror ? 2 * size : size;
    int rest = index - period * int(floor(float(index) / float(period)));
    rest = rest < 0 ? rest + period : rest >= period ? rest - period : rest;
    return rest < size ? rest : period - 1 - rest;
}

float in_texels(float coordinate, int size, uint wrap) {
    if (isnan(coordinate) || isinf(coordinate))
        return 0.0;
    float near = wrap == wrap_clamp ? clamp(coordinate, -1.0, 2.0) : coordinate - 2.0 * floor(0.5 * coordinate);
    return near * float(size) - 0.5;
}

float from_srgb(float encoded) {
    float value = clamp(encoded, 0.0, 1.0);
    return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
}

float of_curve(uint byte) {
    return uintBitsToFloat(tables[frame.tables_at.w + byte / 4u][byte % 4u]);
}

// `texture_at`: the first texel, width, height; the kind: 1 linear values, 2 texels are blended as they are stored.
vec4 texel(uvec4 texture_at, int column, int row) {
    uint word = texels[texture_at.x + uint(row) * texture_at.y + uint(column)];
    if (texture_at.w != 0u)
        return unpackUnorm4x8(word);
    return vec4(of_curve(word & 255u), of_curve(word >> 8 & 255u), of_curve(word >> 16 & 255u),
                float(word >> 24) / 255.0);
}

vec4 texture_sample(uvec4 texture_at, vec2 place, uint wrap_u, uint wrap_v) {
    ivec2 size = ivec2(texture_at.yz);
    vec2 at = vec2(in_texels(place.x, size.x, wrap_u), in_texels(place.y, size.y, wrap_v));
    ivec2 first = ivec2(floor(at));
    vec2 share = at - vec2(first);
    int left = wrapped(first.x, size.x, wrap_u);
    int right = wrapped(first.x + 1, size.x, wrap_u);
    int top = wrapped(first.y, size.y, wrap_v);
    int bottom = wrapped(first.y + 1, size.y, wrap_v);
    vec4 above = texel(texture_at, left, top) * (1.0 - share.x) + texel(texture_at, right, top) * share.x;
    vec4 below = texel(texture_at, left, bottom) * (1.0 - share.x) + texel(texture_at, right, bottom) * share.x;
    vec4 blend = above * (1.0 - share.y) + below * share.y;
    if (texture_at.w == 2u)
        blend.rgb = vec3(from_srgb(blend.r), from_srgb(blend.g), from_srgb(blend.b));
    return blend;
}

// ---- materials

const uint alpha_mask = 1u;
const uint alpha_blend = 2u;
const uint shadow_opacity = 1u;
const uint shadow_nothing = 2u;
const uint words_of_material = 12u;  // of four each

struct Material {
    vec3 diffuse;
    float opacity;
    vec3 specular;
    float shininess;
    vec3 emission;
    float k_s;
    vec3 tint;
    float k_t;
    float refraction_index;
    float metallic;
    float alpha_cutoff;
    float roughness;
    uint alpha_mode;
    uint shadow;
    bool is_ggx;
    bool is_unlit;
};

// A texture map: in the tables, with `texture_map_none` in its first word if there is none.
const uint texture_map_none = 0xffffffffu;

vec4 look_up(uint map, uvec4 triangle, float u, float v) {
    uvec4 head = tables[map];
    if (head.x == texture_map_none)
        return vec4(1.0);
    vec4 columns = uintBitsToFloat(tables[map + 1u]);
    vec2 moved = uintBitsToFloat(head.zw);
    vec2 place = texture_place(triangle, head.y & 1u, u, v);
    return texture_sample(tables[frame.tables_at.z + head.x], columns.xy * place.x + columns.zw * place.y + moved,
                          head.y >> 1 & 3u, head.y >> 3 & 3u);
}

uint material_at(uvec4 triangle) {
    return frame.tables_at.x + words_of_material * triangle.w;
}

uint base_map(uint material) {
    return material + 6u;
}
uint opacity_map(uint material) {
    return material + 8u;
}
uint emission_map(uint material) {
    return material + 10u;
}

Material read_material(uint at) {
    vec4 a = uintBitsToFloat(tables[at]);
    vec4 b = uintBitsToFloat(tables[at + 1u]);
    vec4 c = uintBitsToFloat(tables[at + 2u]);
    vec4 d = uintBitsToFloat(tables[at + 3u]);
    vec4 e = uintBitsToFloat(tables[at + 4u]);
    uvec4 kinds = tables[at + 5u];
    return Material(a.xyz, a.w, b.xyz, b.w, c.xyz, c.w, d.xyz, d.w, e.x, e.y, e.z, e.w, kinds.x, kinds.y,
                    (kinds.z & 1u) != 0u, (kinds.z & 2u) != 0u);
}

// Of the base map and the vertices.
vec4 base_at(uint at, uvec4 triangle, float u, float v) {
    return look_up(base_map(at), triangle, u, v) * vertex_colour(triangle, u, v);
}

float alpha_at(uint at, float opacity, float base, uvec4 triangle, float u, float v) {
    return clamp(opacity * base * look_up(opacity_map(at), triangle, u, v).r, 0.0, 1.0);
}

// A material at a point of a triangle: with textures and the colours of vertices.
struct Surface {
    vec3 diffuse;
    vec3 specular;
    float k_s;
    vec3 k_t;
    float alpha;  // of `AlphaMode::blend`, by which all but k_t is multiplied; else 1
};

Surface surface_at(uint at, Material material, uvec4 triangle, float u, float v) {
    vec4 base = base_at(at, triangle, u, v);
    Surface surface;
    surface.alpha = material.alpha_mode == alpha_blend ? alpha_at(at, material.opacity, base.a, triangle, u, v) : 1.0;
    surface.diffuse = surface.alpha * material.diffuse * base.rgb;
    surface.specular = surface.alpha * material.specular * mix(vec3(1.0), base.rgb, material.metallic);
    surface.k_s = surface.alpha * material.k_s;
    surface.k_t = 1.0 - surface.alpha * (1.0 - material.k_t * material.tint * base.rgb);
    return surface;
}

vec3 emission_at(uint at, Material material, uvec4 triangle, float u, float v) {
    vec3 emission = material.emission * look_up(emission_map(at), triangle, u, v).rgb;
    return material.is_unlit ? emission * vertex_colour(triangle, u, v).rgb : emission;
}

// ---- what rays ask on their way

bool ray_is_hole(uint number, float u, float v) {
    uvec4 triangle = corners[number];
    uint at = material_at(triangle);
    if (tables[at + 5u].x != alpha_mask)
        return false;
    float base = base_at(at, triangle, u, v).a;
    return alpha_at(at, uintBitsToFloat(tables[at].w), base, triangle, u, v) < uintBitsToFloat(tables[at + 4u].z);
}

float ray_share(uint number, float u, float v) {
    uvec4 triangle = corners[number];
    uint at = material_at(triangle);
    uvec4 kinds = tables[at + 5u];
    if (kinds.y == shadow_nothing)
        return 1.0;
    vec4 tint = uintBitsToFloat(tables[at + 3u]);
    vec4 base = base_at(at, triangle, u, v);
    float k_t = kinds.y == shadow_opacity ? tint.w * dot(tint.rgb * base.rgb, vec3(0.2126, 0.7152, 0.0722)) : 0.0;
    float alpha = alpha_at(at, uintBitsToFloat(tables[at].w), base.a, triangle, u, v);
    if (kinds.x == alpha_mask)
        return alpha < uintBitsToFloat(tables[at + 4u].z) ? 1.0 : k_t;
    return kinds.x == alpha_blend ? 1.0 - alpha * (1.0 - k_t) : k_t;
}
