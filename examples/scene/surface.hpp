// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <cstddef>

namespace demo {

/// A material at a point of a triangle: with textures and the colours of vertices.
struct Surface {
    glm::vec3 diffuse;
    glm::vec3 specular;
    glm::vec3 emission;
    float k_s;
    glm::vec3 k_t;  ///< with its tint
};

/// At the weights u and v of the triangle's second and third vertex.
Surface surface_at(const Scene& scene, std::size_t triangle, float u, float v);
/// The same, of the triangle's material.
Surface surface_at(const Scene& scene, const Material& material, std::size_t triangle, float u, float v);

/// The share of light that a shadow ray brings through a surface, 0 to 1.
float share_let_through(const Scene& scene, std::size_t triangle, float u, float v);

/// True if a mask leaves a hole in the surface there.
bool is_hole(const Scene& scene, std::size_t triangle, float u, float v);

/// True if light can pass somewhere: false for what blocks everywhere, which needs no look at the surface.
bool may_let_light_through(const Material& material);

}  // namespace demo
