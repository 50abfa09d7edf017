// SPDX-License-Identifier: MIT
#include "scene.hpp"

#include "instances.hpp"

#include <cstdint>
#include <iterator>
#include <vector>

namespace demo {

std::vector<lightmesh::Light> shapes_of_lights(const Scene& scene) {
    std::vector<lightmesh::Light> shapes;
    shapes.reserve(scene.lights.size());
    for (const SceneLight& light : scene.lights)
        shapes.push_back(light.shape);
    return shapes;
}

std::vector<std::uint32_t> indices_of(const Scene& scene) {
    require_no_instances(scene, "a list of triangles");
    std::vector<std::uint32_t> indices;
    indices.reserve(3 * scene.triangles.size());
    for (const Triangle& triangle : scene.triangles)
        indices.insert(indices.end(), std::begin(triangle.vertex), std::end(triangle.vertex));
    return indices;
}

}  // namespace demo
