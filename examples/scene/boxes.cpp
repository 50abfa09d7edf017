// SPDX-License-Identifier: MIT
#include "boxes.hpp"

#include "instances.hpp"

#include <numeric>

namespace demo {

Bounds placed(const Instance& instance, const Bounds& box) {
    std::array<glm::vec3, 8> corners;
    for (std::size_t corner = 0; corner < corners.size(); ++corner)
        corners[corner] = placed(instance, glm::vec3((corner & 1u) != 0 ? box.high.x : box.low.x,
                                                     (corner & 2u) != 0 ? box.high.y : box.low.y,
                                                     (corner & 4u) != 0 ? box.high.z : box.low.z));
    return around(corners);
}

std::vector<Bounds> boxes_of_parts(const Scene& scene) {
    std::vector<Bounds> boxes;
    for (const MeshPart& part : scene.parts)
        boxes.push_back(around(std::span(scene.positions).subspan(part.first_vertex, part.vertex_count)));
    return boxes;
}

Bounds bounds_of(const Scene& scene) {
    std::vector<Bounds> boxes;
    if (own_vertices(scene) > 0)
        boxes.push_back(around(std::span(scene.positions).first(own_vertices(scene))));
    const std::vector<Bounds> of_parts = boxes_of_parts(scene);
    for (const Instance& instance : scene.instances)
        boxes.push_back(placed(instance, of_parts[instance.part]));
    return boxes.empty() ? Bounds{} : std::reduce(boxes.begin(), boxes.end(), boxes[0], common);
}

}  // namespace demo
