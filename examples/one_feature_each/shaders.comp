#version 450
// SPDX-License-Identifier: MIT
#extension GL_GOOGLE_include_directive : require
// S of all lights at the points of shaders.cpp: a light mesh in a shader.
layout(local_size_x = 64) in;

#define LIGHTMESH_MAX_QUALITY 4  // the default quality
#include <lightmesh/gpu/lightmesh.glsl>

layout(std430, set = 1, binding = 0) readonly buffer Points { vec4 points[]; };
layout(std430, set = 1, binding = 1) buffer Visibilities { float visibilities[]; };

// The short ray: the balls of scene.hpp.
bool is_free_of(vec3 middle, float radius, vec3 from, vec3 to) {
    vec3 way = to - from;
    float t = clamp(dot(middle - from, way) / dot(way, way), 0.0, 1.0);
    return distance(from + t * way, middle) >= radius;
}
bool lightmesh_is_open(vec3 from, vec3 to) {
    return is_free_of(vec3(-2.0, 0.0, 0.8), 0.8, from, to) && is_free_of(vec3(2.0, 0.0, 2.5), 0.8, from, to);
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(points.length()))
        return;
    LightMeshPoint point = lightmesh_point(points[i].xyz, vec3(0.0, 0.0, 1.0));
    for (uint t = 0u; t < lightmesh_tile_count(); ++t) {
        LightMeshTile tile = lightmesh_tile(point, t);
        for (uint l = 0u; l < lightmesh_tile_size(t); ++l)
            visibilities[i * lightmesh.light_count + lightmesh_light_at(t, l)] =
                lightmesh_is_missing(tile, l) ? -1.0 : lightmesh_visibility(tile, l);
    }
}
