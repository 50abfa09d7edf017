// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.hpp"

#include <glm/vec2.hpp>

#include <span>
#include <vector>

namespace demo {

/// All that decides how much light passes a scene's triangles.
struct ShadowLooks {
    std::span<const Triangle> triangles;
    std::span<const Material> materials;
    std::vector<const Texture*> textures;    ///< as materials number them
    std::span<const glm::vec2> coordinates;  ///< of the vertices; empty: 0
};

/// True if each of the triangles lets the same light through as the other one of its number does, by the same
/// parts of its material and of its textures; where the triangles lie is not asked. Colours, roughness and
/// what else only pictures show may differ.
bool let_same_light_through(const ShadowLooks& a, const ShadowLooks& b);

}  // namespace demo
