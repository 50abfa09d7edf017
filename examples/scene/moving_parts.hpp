// SPDX-License-Identifier: MIT
#pragma once

#include "animation.hpp"

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace demo {

/// A rigid motion: p -> to + turn * (p - from).
struct Motion {
    glm::dvec3 from{0.0};
    glm::dvec3 to{0.0};
    glm::dmat3 turn{1.0};
};

/// So many full turns, counter-clockwise about an axis of unit length through a point; the same on all
/// machines.
Motion turned_about(const glm::dvec3& point, const glm::dvec3& axis, double turns);

/// Some vertices and point lights of a scene that move as one.
struct MovingPart {
    std::vector<std::uint32_t> vertices;
    std::vector<std::size_t> lights;
    std::function<Motion(double seconds)> motion;  ///< from where they are in the scene
};

/// The vertices from number `first` on to the last one.
std::vector<std::uint32_t> vertices_from(const Scene& scene, std::size_t first);
/// The vertices that lie in a box.
std::vector<std::uint32_t> vertices_within(const Scene& scene, const glm::vec3& low, const glm::vec3& high);

/// The number of a material by its name, which must be there.
std::uint32_t material_named(const Scene& scene, const std::string& name);

/// Moves parts from where they are in `scene`, and the camera if `camera` is not empty. Puts the scene into
/// its pose at 0 s.
AnimatedScene animate(Scene scene, std::vector<MovingPart> parts, std::function<Camera(double)> camera,
                      double length);

}  // namespace demo
