// SPDX-License-Identifier: MIT
//
// A light mesh that finds what its points see from the scene's triangles, by shadow volumes, instead of
// tracing rays to the lights: `Occluders`.
#include "scene.hpp"

#include <algorithm>
#include <cmath>

using glm::vec3;

// A table top over the floor: two triangles.
constexpr std::array<std::array<vec3, 3>, 2> table_top{
    {{{{-2, -2, 2}, {2, -2, 2}, {2, 2, 2}}}, {{{-2, -2, 2}, {2, 2, 2}, {-2, 2, 2}}}}};

// The adapter for triangles, which the mesh keeps: each is asked for when the mesh is made, and after
// changes.
struct Triangles {
    std::size_t triangle_count() const { return table_top.size(); }
    std::array<vec3, 3> triangle(std::size_t i) const { return table_top[i]; }
};

// The adapter for rays: short tests still need them.
struct TableTracer {
    bool occluded(const lightmesh::Segment& segment) const {
        const float height = segment.target.z - segment.origin.z;
        const float t = (2.0f - segment.origin.z) / height;
        const vec3 hit = segment.origin + t * (segment.target - segment.origin);
        return t > 0.0f && t < 1.0f && std::abs(hit.x) <= 2.0f && std::abs(hit.y) <= 2.0f;
    }
};

int main() {
    const std::vector<vec3> points = scene::floor_points();
    const std::vector<vec3> normals(points.size(), scene::floor_normal);
    const std::vector<lightmesh::Light> light{lightmesh::PointLight{.position = {-4.0f, 0.0f, 7.0f}}};
    const lightmesh::Settings settings{.radius = 0.8f};
    const lightmesh::LightMesh by_volumes{TableTracer{}, Triangles{}, light, settings};
    const lightmesh::LightMesh by_rays{TableTracer{}, light, settings};

    std::vector<float> volumes(points.size());
    std::vector<float> rays(points.size());
    by_volumes.visibility(points, normals, volumes);
    by_rays.visibility(points, normals, rays);
    scene::print_row("volumes", volumes);
    scene::print_row("rays", rays);
    std::cout << "long rays: " << by_volumes.statistics().long_rays << " with volumes, "
              << by_rays.statistics().long_rays << " without\n";

    float greatest = 0.0f;
    for (std::size_t i = 0; i < rays.size(); ++i)
        greatest = std::max(greatest, std::abs(volumes[i] - rays[i]));
    std::cout << "the same within 1 %: " << (greatest < 0.01f ? "yes" : "no") << '\n';
    return greatest < 0.01f ? 0 : 1;
}
