// SPDX-License-Identifier: MIT

// Walks by ray queries, for rays.glsl, through `ray_triangles`: opaque triangles are its first geometry, those that light
// may pass its second one. Whoever includes this has `ray_numbers` too. The device decides which triangles a ray meets: along
// edges, and of triangles in one place, it may be another one than a BVH of shaders tells.

rayQueryEXT ray_query;

void ray_begin(vec3 origin, vec3 way, float reach, bool is_any) {
    // A ray begins on a surface, which it does not meet.
    const float beyond_origin = 1e-18;
    rayQueryInitializeEXT(ray_query, ray_triangles, is_any ? gl_RayFlagsTerminateOnFirstHitEXT : gl_RayFlagsNoneEXT, 0xffu,
                          origin, beyond_origin, way, reach);
}

uint ray_number(int geometry, int triangle) {
    return ray_numbers[1u + uint(triangle) + (geometry == 0 ? 0u : ray_numbers[0])];
}

bool ray_walk(vec3 origin, vec3 way, bool is_any, bool from_target, inout RayHit hit, out RayHit next) {
    // Of opaque triangles it tells at the end.
    if (rayQueryProceedEXT(ray_query)) {
        next = RayHit(ray_number(rayQueryGetIntersectionGeometryIndexEXT(ray_query, false),
                                 rayQueryGetIntersectionPrimitiveIndexEXT(ray_query, false)),
                      rayQueryGetIntersectionTEXT(ray_query, false),
                      rayQueryGetIntersectionBarycentricsEXT(ray_query, false).x,
                      rayQueryGetIntersectionBarycentricsEXT(ray_query, false).y);
        return true;
    }
    if (rayQueryGetIntersectionTypeEXT(ray_query, true) == gl_RayQueryCommittedIntersectionTriangleEXT)
        hit = RayHit(ray_number(rayQueryGetIntersectionGeometryIndexEXT(ray_query, true),
                                rayQueryGetIntersectionPrimitiveIndexEXT(ray_query, true)),
                     rayQueryGetIntersectionTEXT(ray_query, true),
                     rayQueryGetIntersectionBarycentricsEXT(ray_query, true).x,
                     rayQueryGetIntersectionBarycentricsEXT(ray_query, true).y);
    return false;
}

void ray_take(RayHit next, inout RayHit hit) {
    rayQueryConfirmIntersectionEXT(ray_query);
}
