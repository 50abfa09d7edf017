// SPDX-License-Identifier: MIT
#pragma once

#include <glm/mat4x3.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <vector>

namespace demo {

/// Triangles of a scene that are not drawn where they lie: instances of them are.
struct MeshPart {
    std::uint32_t first_vertex;
    std::uint32_t vertex_count;
    std::uint32_t first_triangle;
    std::uint32_t triangle_count;
};

/// A part in its place.
struct Instance {
    std::uint32_t part;         ///< number in Scene::parts
    glm::mat4x3 transform;      ///< from the part's coordinates to the world's
    std::uint32_t surface = 0;  ///< that tells its `Scene::surfaces` from those of other instances
};

/// A point of a part, in the world.
glm::vec3 placed(const Instance& instance, const glm::vec3& point);

/// A normal of a part in the world, of any length; of mirror images on the other side.
glm::vec3 placed_normal(const Instance& instance, const glm::vec3& normal);

/// True if it is a mirror image of its part.
bool is_mirrored(const Instance& instance);

struct Scene;

/// The number of triangles that lie where they are drawn: the first ones.
std::uint32_t own_triangles(const Scene& scene);

/// The vertices of these.
std::uint32_t own_vertices(const Scene& scene);

/// The number of triangles that are drawn, each instance's counted.
std::uint64_t drawn_triangles(const Scene& scene);

/// Throws std::invalid_argument that names `what` if the scene has instances, for what knows only triangles
/// that lie where they are drawn.
void require_no_instances(const Scene& scene, const char* what);

}  // namespace demo
