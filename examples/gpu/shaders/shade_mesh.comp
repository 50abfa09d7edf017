#version 460
// SPDX-License-Identifier: MIT

// Shades each pixel's point by a light mesh. What the mesh does not know is written to the request buffer; the point
// waits until it does.

#extension GL_GOOGLE_include_directive : require
#define RAY_OPEN
#include "scene.glsl"
#include "rays.glsl"
#include "paths.glsl"
#include "lights.glsl"

#define LIGHTMESH_SET 1
#define LIGHTMESH_BINDING 0
#include <lightmesh/gpu/lightmesh.glsl>

layout(local_size_x = 64) in;

bool lightmesh_is_open(vec3 from, vec3 to) {
    return is_open(from, to);
}

void main() {
    uint pixel = gl_GlobalInvocationID.x;
    if (pixel >= batch.count)
        return;
    uint to_do = paths[2u * pixel + 1u].w;
    if ((to_do & waits_for_shadows) == 0u)
        return;
    PathPoint point = read_point(pixel);
    uvec4 triangle = corners[point.triangle];
    uint at = material_at(triangle);
    Material material = read_material(at);
    Surface surface = surface_at(at, material, triangle, point.u, point.v);
    vec3 sum = frame.ambient.rgb * surface.diffuse +
               surface.alpha * emission_at(at, material, triangle, point.u, point.v);
    // Of a ray along an edge the host may say another thing: it then never fills what the device lacks.
    vec3 asked = point.position + float(batch.attempt) * frame.ambient.w * point.normal;
    LightMeshBlend query = lightmesh_point(asked, point.normal, point.footprint);
    for (uint t = 0u; t < lightmesh_tile_count(); ++t) {
        LightMeshBlendTile tile = lightmesh_tile(query, t);
        if (tile.missing != uvec2(0u)) {
            if ((tile.why & ~lightmesh_not_filled) == 0u)
                return;
            this_round.is_failed = 1u;
        }
        uint size = lightmesh_tile_size(t);
        for (uint first = 0u; first < size; first += 4u) {
            vec4 lit = lightmesh_visibility_of_four(tile, first);
            for (uint k = 0u; k < 4u; ++k) {
                if (lit[k] == 0.0)
                    continue;
                Illumination found = illuminate(read_light(lightmesh_light_at(t, first + k)), point.position);
                sum += lit[k] * found.irradiance *
                       reflected_share(material, surface, point.shading_normal, point.ray_direction, found.to_light);
            }
        }
    }
    colours[pixel].rgb += point.weight * sum;
    paths[2u * pixel + 1u].w = to_do & ~waits_for_shadows;
}
