// SPDX-License-Identifier: MIT
//
// A light mesh that looks into shadow maps instead of tracing rays to the lights, for renderers with a
// rasteriser. A picture is rendered when a query first needs it.
#include "scene.hpp"

#include <cmath>

int main() {
    const std::vector<glm::vec3> points = scene::floor_points();
    const std::vector<glm::vec3> normals(points.size(), scene::floor_normal);
    const lightmesh::Settings settings{.radius = 0.8f, .shadow_map_size = 256};
    const lightmesh::LightMesh by_maps{scene::Tracer{}, scene::DepthRenderer{}, scene::lights, settings};
    const lightmesh::LightMesh by_rays{scene::Tracer{}, scene::lights, settings};

    std::vector<float> maps(points.size() * scene::lights.size());
    std::vector<float> rays(maps.size());
    by_maps.visibility(points, normals, maps);
    by_rays.visibility(points, normals, rays);

    // The first light alone, as a row of digits.
    std::vector<float> first_by_maps, first_by_rays;
    float difference = 0.0f;
    for (std::size_t i = 0; i < maps.size(); ++i)
        difference += std::abs(maps[i] - rays[i]) / static_cast<float>(maps.size());
    for (std::size_t p = 0; p < points.size(); ++p) {
        first_by_maps.push_back(maps[p * scene::lights.size()]);
        first_by_rays.push_back(rays[p * scene::lights.size()]);
    }
    scene::print_row("shadow maps", first_by_maps);
    scene::print_row("rays", first_by_rays);
    std::cout << "long rays: " << by_maps.statistics().long_rays << " with maps, "
              << by_rays.statistics().long_rays << " without\n";
    std::cout << "mean difference below 1 %: " << (difference < 0.01f ? "yes" : "no") << '\n';
    return difference < 0.01f ? 0 : 1;
}
