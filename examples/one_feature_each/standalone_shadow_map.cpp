// SPDX-License-Identifier: MIT
//
// A shadow map without a light mesh: hard shadows of one light, filtered ones, and a ray where the map cannot
// tell.
#include "scene.hpp"

#include <lightmesh/shadows/shadow_map.hpp>

int main() {
    const lightmesh::PointLight light{.position = {-4.0f, 0.0f, 8.0f}};
    const lightmesh::ShadowMap map{scene::DepthRenderer{}, light,
                                   lightmesh::ShadowMapSettings{.resolution = 256}};

    std::vector<float> hard, filtered;
    for (const glm::vec3& point : scene::floor_points()) {
        hard.push_back(map.visible(point) ? 1.0f : 0.0f);
        filtered.push_back(map.visibility(point, 8.0f));  // the mean over 17 x 17 texels
    }
    scene::print_row("hard", hard);
    scene::print_row("filtered", filtered);
    std::cout << map.rendered() << " of " << map.views().size() << " pictures were needed\n";

    // In the air, where fog may ask: most look-ups are certain, all others are worth a ray.
    int certain = 0, traced = 0, wrong = 0;
    for (glm::vec3 point : scene::floor_points(2000)) {
        point.z = 0.5f;
        const bool truth = !scene::Tracer{}.occluded({point, light.position});
        const lightmesh::ShadowMapLookup found = map.look_up(point);
        if (found == lightmesh::ShadowMapLookup::edge) {
            ++traced;  // and the ray decides
        } else {
            ++certain;
            wrong += (found == lightmesh::ShadowMapLookup::lit) == truth ? 0 : 1;
        }
    }
    std::cout << "in the air: " << certain << " points certain, " << traced << " for a ray, " << wrong
              << " wrong\n";
    return wrong == 0 ? 0 : 1;
}
