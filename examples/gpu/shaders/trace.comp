#version 460
// SPDX-License-Identifier: MIT

// Follows each pixel's rays to the next surface that adds to it, as renderer.cpp does: a point to shade a pixel and
// round.

#extension GL_GOOGLE_include_directive : require
#define RAY_CLOSEST
#include "scene.glsl"
#include "rays.glsl"
#include "paths.glsl"
#include "random.glsl"

layout(local_size_x = 64) in;

// Rays that add less than this to a pixel are not traced.
const float least_weight = 1.0 / 512.0;

struct PixelState {
    uvec2 random;
    uint sample_count;  // of samples that have begun
    uint waiting;
    uint secondary;
};

void push(uint pixel, inout PixelState state, PathRay ray) {
    uint at = 3u * state.waiting * batch.count + pixel;
    waiting_rays[at] = uvec4(floatBitsToUint(ray.origin), ray.depth);
    waiting_rays[at + batch.count] = floatBitsToUint(vec4(ray.direction, ray.width));
    waiting_rays[at + 2u * batch.count] = floatBitsToUint(vec4(ray.weight, 0.0));
    ++state.waiting;
}

PathRay pop(uint pixel, inout PixelState state) {
    --state.waiting;
    uint at = 3u * state.waiting * batch.count + pixel;
    uvec4 a = waiting_rays[at];
    vec4 b = uintBitsToFloat(waiting_rays[at + batch.count]);
    vec4 c = uintBitsToFloat(waiting_rays[at + 2u * batch.count]);
    return PathRay(uintBitsToFloat(a.xyz), b.xyz, c.xyz, a.w, b.w);
}

// The s-th place of a Hammersley set.
vec2 sample_place(uint s) {
    return vec2((float(s) + 0.5) / float(frame.picture.z), float(bitfieldReverse(s) >> 8) * (1.0 / 16777216.0));
}

// Of the view to a place in pixels, row 0 on top.
PathRay ray_from_eye(vec2 place) {
    float x = 2.0 * place.x / float(frame.picture.x) - 1.0;
    float y = 1.0 - 2.0 * place.y / float(frame.picture.y);
    vec3 aside = frame.middle.xyz + x * frame.right.xyz + y * frame.up.xyz;
    bool is_orthographic = frame.eye.w != 0.0;
    vec3 direction = is_orthographic ? frame.forward.xyz : normalize(frame.forward.xyz + aside);
    vec3 origin = is_orthographic ? frame.eye.xyz + aside : frame.eye.xyz;
    float ahead = frame.right.w / dot(direction, frame.forward.xyz);
    return PathRay(origin + ahead * direction, direction, vec3(1.0 / float(frame.picture.z)), 0u,
                   frame.forward.w + ahead * frame.middle.w);
}

void follow_on(uint pixel, inout PixelState state, PathRay ray, vec3 origin, vec3 direction, vec3 share, float width) {
    vec3 weight = share * ray.weight;
    if (max(max(weight.x, weight.y), weight.z) * float(frame.picture.z) < least_weight)
        return;
    ++state.secondary;
    push(pixel, state, PathRay(origin, direction, weight, ray.depth + 1u, width));
}

void main() {
    uint pixel = gl_GlobalInvocationID.x;
    if (pixel >= batch.count)
        return;
    uint number = batch.first + pixel;
    uvec2 place = uvec2(number % frame.picture.x, number / frame.picture.x);
    PixelState state;
    uvec4 counts = uvec4(0u);
    vec4 colour = vec4(0.0);
    if (batch.is_first_round != 0u) {
        state = PixelState(random_of(uvec2(number, 0u)), 0u, 0u, 0u);
    } else {
        uvec4 kept = paths[2u * pixel];
        counts = paths[2u * pixel + 1u];
        if (counts.w == 0u)
            return;
        state = PixelState(kept.xy, kept.z, kept.w, counts.y);
        colour = colours[pixel];
    }
    vec2 shift = vec2(0.0);
    if (frame.picture.z > 1u) {
        // The first two of the pixel's numbers, whatever was drawn since.
        uvec2 fresh = random_of(uvec2(number, 0u));
        shift.x = random_uniform(fresh);
        shift.y = random_uniform(fresh);
    }
    if (batch.is_first_round != 0u) {
        random_next(state.random);
        random_next(state.random);
    }
    uint to_do = 0u;
    while (to_do == 0u) {
        if (state.waiting == 0u) {
            if (state.sample_count == frame.picture.z)
                break;
            vec2 inside = frame.picture.z == 1u ? vec2(0.5) : fract(sample_place(state.sample_count) + shift);
            push(pixel, state, ray_from_eye(vec2(place) + inside));
            ++state.sample_count;
        }
        PathRay ray = pop(pixel, state);
        float reach = ray.depth == 0u ? frame.up.w / dot(ray.direction, frame.forward.xyz) : 1e30;
        RayHit hit = closest_hit(ray.origin, ray.direction, reach);
        if (hit.triangle == ~0u) {
            colour.rgb += ray.weight * frame.background.rgb;
            continue;
        }
        uvec4 triangle = corners[hit.triangle];
        vec3 a = vertex_vec3(triangle.x, 0u);
        vec3 b = vertex_vec3(triangle.y, 0u);
        vec3 c = vertex_vec3(triangle.z, 0u);
        PathPoint point;
        point.position = (1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c;
        vec3 normal = normalize(cross(b - a, c - a));
        bool from_inside = dot(normal, ray.direction) > 0.0;
        point.normal = from_inside ? -normal : normal;
        point.shading_normal = point.normal;
        if (frame.attributes.x != 0u) {
            vec3 smooth_normal = between(triangle, frame.attributes.x, hit.u, hit.v);
            float size = length(smooth_normal);
            if (size > 0.0)
                point.shading_normal = smooth_normal / (dot(smooth_normal, point.normal) < 0.0 ? -size : size);
        }
        point.ray_direction = ray.direction;
        point.weight = ray.weight;
        point.footprint = ray.width + frame.middle.w * distance(ray.origin, point.position);
        point.triangle = hit.triangle;
        point.u = hit.u;
        point.v = hit.v;
        point.seed = random_next(state.random);
        write_point(pixel, point);
        ++counts.x;
        to_do = has_point | waits_for_shadows;
        atomicAdd(this_round.point_count, 1u);
        if (ray.depth >= frame.picture.w)
            break;
        uint at = material_at(triangle);
        Material material = read_material(at);
        Surface surface = surface_at(at, material, triangle, hit.u, hit.v);
        vec3 way = frame.ambient.w * point.normal;
        vec3 mirrored = reflect(ray.direction, point.shading_normal);
        follow_on(pixel, state, ray, point.position + way, mirrored, vec3(surface.k_s), point.footprint);
        vec3 through = refract(ray.direction, point.shading_normal,
                               from_inside ? material.refraction_index : 1.0 / material.refraction_index);
        if (through == vec3(0.0))
            through = mirrored;
        bool enters = dot(through, point.normal) < 0.0;
        follow_on(pixel, state, ray, point.position + (enters ? -way : way), through, surface.k_t, point.footprint);
    }
    paths[2u * pixel] = uvec4(state.random, state.sample_count, state.waiting);
    paths[2u * pixel + 1u] = uvec4(counts.x, state.secondary, counts.z, to_do);
    colours[pixel] = colour;
}
