// SPDX-License-Identifier: MIT

// Walks by ray queries, for rays.glsl. Opaque triangles are the first geometry, those that light may pass the second one.
// Along edges, and of triangles in one place, a ray may meet another one than through a BVH.

layout(set = 0, binding = 1) uniform accelerationStructureEXT ray_triangles;
layout(std430, set = 0, binding = 2) readonly buffer RayNumbers {
    uint ray_numbers[];  // how many triangles are opaque; the scene's numbers of these, and of all others
};

rayQueryEXT ray_query;

bool ray_is_finite(vec3 values) {
    return !any(isnan(values)) && !any(isinf(values));
}

void ray_begin(vec3 origin, vec3 way, float reach, bool is_any) {
    const float least = 1e-18;  // for "t > 0"
    // Queries are not defined for what is not finite: such a ray meets nothing.
    bool is_ray = ray_is_finite(origin) && ray_is_finite(way) && reach >= least;
    rayQueryInitializeEXT(ray_query, ray_triangles, is_any ? gl_RayFlagsTerminateOnFirstHitEXT : gl_RayFlagsNoneEXT,
                          is_ray ? 0xffu : 0u, is_ray ? origin : vec3(0.0), least, is_ray ? way : vec3(1.0),
                          is_ray ? reach : 1.0);
}

uint ray_number(int geometry, int triangle) {
    return ray_numbers[1u + uint(triangle) + (geometry == 0 ? 0u : ray_numbers[0])];
}

bool ray_walk(vec3 origin, vec3 way, bool is_any, bool from_target, inout RayHit hit, out RayHit next) {
    // Only triangles that light may pass are candidates.
    if (rayQueryProceedEXT(ray_query)) {
        vec2 weights = rayQueryGetIntersectionBarycentricsEXT(ray_query, false);
        next = RayHit(ray_number(rayQueryGetIntersectionGeometryIndexEXT(ray_query, false),
                                 rayQueryGetIntersectionPrimitiveIndexEXT(ray_query, false)),
                      rayQueryGetIntersectionTEXT(ray_query, false), weights.x, weights.y);
        return true;
    }
    if (rayQueryGetIntersectionTypeEXT(ray_query, true) == gl_RayQueryCommittedIntersectionTriangleEXT) {
        vec2 weights = rayQueryGetIntersectionBarycentricsEXT(ray_query, true);
        hit = RayHit(ray_number(rayQueryGetIntersectionGeometryIndexEXT(ray_query, true),
                                rayQueryGetIntersectionPrimitiveIndexEXT(ray_query, true)),
                     rayQueryGetIntersectionTEXT(ray_query, true), weights.x, weights.y);
    }
    return false;
}

void ray_take(RayHit next, inout RayHit hit) {
    rayQueryConfirmIntersectionEXT(ray_query);
}
