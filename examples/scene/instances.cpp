// SPDX-License-Identifier: MIT
#include "instances.hpp"

#include "scene.hpp"

#include <glm/geometric.hpp>

#include <stdexcept>
#include <string>

namespace demo {

namespace {

/// The columns of a transform that turn and scale.
glm::dvec3 column(const Instance& instance, int number) {
    return glm::dvec3(instance.transform[number]);
}

}  // namespace

glm::vec3 placed(const Instance& instance, const glm::vec3& point) {
    const glm::dvec3 p(point);
    return p.x * column(instance, 0) + p.y * column(instance, 1) + p.z * column(instance, 2) +
           column(instance, 3);
}

glm::vec3 placed_normal(const Instance& instance, const glm::vec3& normal) {
    const glm::dvec3 n(normal);
    const glm::dvec3 x = column(instance, 0);
    const glm::dvec3 y = column(instance, 1);
    const glm::dvec3 z = column(instance, 2);
    return n.x * glm::cross(y, z) + n.y * glm::cross(z, x) + n.z * glm::cross(x, y);
}

bool is_mirrored(const Instance& instance) {
    return glm::dot(glm::cross(column(instance, 0), column(instance, 1)), column(instance, 2)) < 0.0;
}

std::uint32_t own_triangles(const Scene& scene) {
    return scene.parts.empty() ? static_cast<std::uint32_t>(scene.triangles.size())
                               : scene.parts[0].first_triangle;
}

std::uint32_t own_vertices(const Scene& scene) {
    return scene.parts.empty() ? static_cast<std::uint32_t>(scene.positions.size())
                               : scene.parts[0].first_vertex;
}

std::uint64_t drawn_triangles(const Scene& scene) {
    std::uint64_t count = own_triangles(scene);
    for (const Instance& instance : scene.instances)
        count += scene.parts[instance.part].triangle_count;
    return count;
}

void require_no_instances(const Scene& scene, const char* what) {
    if (!scene.instances.empty())
        throw std::invalid_argument(std::string(what) + " cannot draw the scene's " +
                                    std::to_string(scene.instances.size()) + " instances");
}

}  // namespace demo
