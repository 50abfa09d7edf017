// SPDX-License-Identifier: MIT
#pragma once

#include "render/embree_scene.hpp"
#include "render/illumination.hpp"
#include "scene/scene.hpp"

#include <glm/vec3.hpp>

#include <span>

namespace demo {

/// Light that a hit sends to where its ray came from, without mirrored and refracted rays: A + sum_i S_i *
/// Omega_i of equation (1), and the surface's own emission. `lights` are the scene's, `lit` holds S of each,
/// `ambient` the share of the ambient light that arrives.
glm::vec3 shade(const Scene& scene, const LightTable& lights, const Hit& hit, const glm::vec3& ray_direction,
                std::span<const float> lit, float ambient = 1.0f);

/// Direction of the refracted ray; of the mirrored one for total internal reflection.
glm::vec3 refracted(const Hit& hit, const glm::vec3& direction, float refraction_index);

}  // namespace demo
