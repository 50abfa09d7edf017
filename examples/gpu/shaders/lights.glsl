// SPDX-License-Identifier: MIT

// What lights do, as illumination.cpp has it, and what surfaces do with it, as shading.cpp.

const uint light_point = 0u;
const uint light_directional = 1u;
const uint light_spot = 2u;
const uint light_rect = 3u;
const uint words_of_light = 8u;  // of four each

struct LightData {
    uint kind;
    bool is_lamp;  // FallOff::lamps
    vec3 position;
    vec3 intensity;
    float range;
    vec3 axis;    // of unit length: along directional light, along spots, the front of rectangles
    float outer;  // cosine of a spot's cone
    vec3 half_u;
    float inner;  // cosine of a spot's inner cone
    vec3 half_v;
    float size;  // of `area`
    vec3 facing;
    float radius;
    float area;  // of rectangles
};

LightData read_light(uint number) {
    uint at = frame.tables_at.y + words_of_light * number;
    uvec4 head = tables[at];
    vec4 a = uintBitsToFloat(tables[at + 1u]);
    vec4 b = uintBitsToFloat(tables[at + 2u]);
    vec4 c = uintBitsToFloat(tables[at + 3u]);
    vec4 d = uintBitsToFloat(tables[at + 4u]);
    vec4 e = uintBitsToFloat(tables[at + 5u]);
    vec4 f = uintBitsToFloat(tables[at + 6u]);
    return LightData(head.x, head.y != 0u, a.xyz, b.xyz, b.w, c.xyz, c.w, d.xyz, d.w, e.xyz, e.w, f.xyz, f.w, a.w);
}

// The effect of a light on a point if nothing stands between them.
struct Illumination {
    vec3 to_light;
    vec3 irradiance;
};

float range_window(float distance, float range) {
    float share = min(distance / range, 2.0);
    return clamp(1.0 - share * share * share * share, 0.0, 1.0);
}

float cone_fall_off(LightData light, vec3 to_light) {
    float cosine = -dot(light.axis, to_light);
    if (cosine < light.outer)
        return 0.0;
    float share = clamp((cosine - light.outer) / max(0.001, light.inner - light.outer), 0.0, 1.0);
    return share * share;
}

float disc_fall_off(LightData light, vec3 to_light) {
    float cosine = -dot(light.axis, to_light);
    if (cosine <= light.outer || cosine <= 0.0)
        return 0.0;
    return light.inner > light.outer ? cosine * smoothstep(light.outer, light.inner, cosine) : cosine;
}

// The irradiance vector of a rectangle of radiance 1, towards it; 0 behind it.
vec3 irradiance_vector(LightData light, vec3 point) {
    vec3 centre = light.position - point;
    if (dot(light.axis, centre) >= 0.0)
        return vec3(0.0);
    vec3 u = light.half_u;
    vec3 v = light.half_v;
    vec3 corner[4] = vec3[](centre - u - v, centre - u + v, centre + u + v, centre + u - v);
    // The cross products of corners beside each other, without the part that cancels out.
    vec3 normals[4] = vec3[](2.0 * cross(centre - u, v), 2.0 * cross(centre + v, u), 2.0 * cross(v, centre + u),
                             2.0 * cross(u, centre - v));
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        float size = length(normals[i]);
        if (size > 0.0)
            sum += normals[i] * (atan(size, dot(corner[i], corner[i + 1 & 3])) / size);
    }
    return 0.5 * sum;
}

Illumination illuminate(LightData light, vec3 point) {
    if (light.kind == light_directional)
        return Illumination(-light.axis, light.intensity);
    vec3 way = light.position - point;
    float far = length(way);
    if (light.kind == light_rect && light.is_lamp) {
        vec3 whole = irradiance_vector(light, point);
        float size = length(whole);
        if (!(size > 0.0))
            return Illumination(vec3(0.0), vec3(0.0));
        return Illumination(whole / size, light.intensity * (size / light.area * range_window(far, light.range)));
    }
    if (!(far > 0.0))
        return Illumination(vec3(0.0), vec3(0.0));
    Illumination found = Illumination(way / far, light.intensity * (range_window(far, light.range) / (far * far)));
    if (light.kind == light_spot) {
        found.irradiance *= light.is_lamp ? disc_fall_off(light, found.to_light) : cone_fall_off(light, found.to_light);
    } else if (light.kind == light_rect) {
        found.irradiance *= max(-dot(light.axis, found.to_light), 0.0);
    } else {
        if (light.is_lamp) {
            float ratio = light.radius / far;
            float slant = sqrt(1.0 + ratio * ratio);
            found.irradiance *= 2.0 / (slant * (slant + 1.0));
        }
        if (light.facing != vec3(0.0))
            found.irradiance *= abs(dot(light.facing, found.to_light));
    }
    return found;
}

// The light's end of a shadow ray from a point off the surface.
vec3 end_of_ray(LightData light, vec3 origin) {
    if (light.kind == light_directional)
        return origin - frame.background.w * light.axis;
    vec3 way = origin - light.position;
    float far = length(way);
    float offset = frame.ambient.w;
    return light.position + way * (far > 2.0 * offset ? offset / far : 0.5);
}

// ---- surfaces

// Schlick's approximation.
float grazing(float cosine) {
    float rest = clamp(1.0 - cosine, 0.0, 1.0);
    return rest * rest * rest * rest * rest;
}

vec3 rough_reflection(Surface surface, float roughness, vec3 normal, vec3 to_eye, vec3 to_light) {
    float to_n = dot(normal, to_light);
    float from_n = max(dot(normal, to_eye), 1e-4);
    vec3 halfway = normalize(to_light + to_eye);
    float half_n = max(dot(normal, halfway), 0.0);
    float half_to = max(dot(to_light, halfway), 0.0);
    float width = max(roughness * roughness, 0.01);
    float squared = width * width;
    float spread = half_n * half_n * (squared - 1.0) + 1.0;
    float facets = squared / (spread * spread);
    float masking = 0.5 / (to_n * sqrt(squared + (1.0 - squared) * from_n * from_n) +
                           from_n * sqrt(squared + (1.0 - squared) * to_n * to_n));
    vec3 head_on = surface.specular;
    vec3 fresnel = head_on + (clamp(50.0 * head_on, 0.0, 1.0) - head_on) * grazing(half_to);
    float edge = 0.5 + 2.0 * half_to * half_to * roughness - 1.0;
    float matt = (1.0 + edge * grazing(to_n)) * (1.0 + edge * grazing(from_n));
    return to_n * (matt * surface.diffuse + facets * masking * fresnel);
}

// The share of irradiance that a surface sends back along a ray; 0 from behind.
vec3 reflected_share(Material material, Surface surface, vec3 normal, vec3 ray_direction, vec3 to_light) {
    float lambert = dot(normal, to_light);
    if (lambert <= 0.0)
        return vec3(0.0);
    if (material.is_ggx)
        return rough_reflection(surface, material.roughness, normal, -ray_direction, to_light);
    vec3 share = lambert * surface.diffuse;
    if (surface.specular != vec3(0.0)) {
        float highlight = max(0.0, dot(normal, normalize(to_light - ray_direction)));
        if (highlight > 0.0)
            share += pow(highlight, material.shininess) * surface.specular;
    }
    return share;
}
