#version 450
// With rays against a list of triangles: what `SolidTracer` of gpu_cache_test.cpp does, to the bit.
#extension GL_GOOGLE_include_directive : require

layout(std430, set = 1, binding = 3) readonly buffer Corners { vec4 corners[]; };

float volume_of(vec3 a, vec3 b, vec3 c, vec3 d) {
    precise vec3 x = b - a, y = c - a, z = d - a;
    precise vec3 across = vec3(y.y * z.z - z.y * y.z, y.z * z.x - z.z * y.x, y.x * z.y - z.x * y.y);
    precise float volume = (x.x * across.x + x.y * across.y) + x.z * across.z;
    return volume;
}

bool is_blocked(vec3 from, vec3 to) {
    for (int i = 0; i < corners.length(); i += 3) {
        vec3 a = corners[i].xyz, b = corners[i + 1].xyz, c = corners[i + 2].xyz;
        if ((volume_of(from, a, b, c) > 0.0) == (volume_of(to, a, b, c) > 0.0))
            continue;
        vec3 sides = vec3(volume_of(from, to, a, b), volume_of(from, to, b, c), volume_of(from, to, c, a));
        if (all(greaterThanEqual(sides, vec3(0.0))) || all(lessThanEqual(sides, vec3(0.0))))
            return true;
    }
    return false;
}
#define LIGHTMESH_OCCLUDED(from, to) is_blocked(from, to)
#include "cache_query.glsl"
