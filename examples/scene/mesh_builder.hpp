// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>

namespace demo {

/// Appends simple shapes to a scene, each with the number of triangles its comment names. Shapes are given in
/// a local frame that `place` sets: origin, turn about z, uniform scale. Triangles are counter-clockwise seen
/// from outside.
class MeshBuilder {
public:
    explicit MeshBuilder(Scene& scene) : scene_(scene) {}

    /// Returns the index for `use`.
    std::uint32_t add_material(const Material& material);

    /// The material of all that follows.
    void use(std::uint32_t material) { material_ = material; }

    /// The local frame of all that follows: p -> origin + scale * (p turned about z by `turns` full turns).
    void place(glm::vec3 origin, float turns = 0.0f, float scale = 1.0f);
    glm::vec3 to_world(glm::vec3 p) const;

    std::size_t triangle_count() const { return scene_.triangles.size(); }

    /// A vertex with its shading normal (unit length) in the local frame; returns the index for `face`.
    std::uint32_t vertex(glm::vec3 position, glm::vec3 normal);
    /// 1 triangle between vertices made before.
    void face(std::uint32_t a, std::uint32_t b, std::uint32_t c);

    /// 1 flat triangle.
    void triangle(glm::vec3 a, glm::vec3 b, glm::vec3 c);
    /// 2 flat triangles, a planar quadrilateral.
    void quad(glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d);
    /// 12 triangles; 10 without the face at the bottom.
    void box(glm::vec3 low, glm::vec3 high, bool with_bottom = true);
    /// 20 * frequency^2 triangles: an icosahedron with edges cut into `frequency` parts, smooth normals.
    void ball(glm::vec3 centre, float radius, int frequency);
    /// 2 * sides triangles, or `sides` when `to_radius` is 0: a smooth tube or cone without caps.
    void tube(glm::vec3 from, glm::vec3 to, float from_radius, float to_radius, int sides);
    /// `sides` triangles: a flat disc.
    void disc(glm::vec3 centre, glm::vec3 normal, float radius, int sides);

private:
    Scene& scene_;
    std::uint32_t material_ = 0;
    glm::vec3 origin_{0.0f};
    glm::vec2 turn_{1.0f, 0.0f};
    float scale_ = 1.0f;
};

}  // namespace demo
