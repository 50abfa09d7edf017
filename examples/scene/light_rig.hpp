// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <glm/vec3.hpp>

namespace demo {

/// Where the sum of the strengths of all lights is wanted as that of point lights: a directional light counts
/// as the point lights that would light the ground of the scene as much.
glm::vec3 total_strength(const Scene& scene);

/// Adds six point lights around and above the scene, for files that bring none. Needs `camera.up`.
void add_light_rig(Scene& scene);

/// A view of the whole scene from the front, a little from the right and above. `up` is one of the axes.
Camera view_of_all(const Scene& scene, glm::vec3 up);

}  // namespace demo
