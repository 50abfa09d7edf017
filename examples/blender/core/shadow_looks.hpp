// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace demo {

/// All that decides how much light passes a scene's triangles, but for where their textures lie.
struct ShadowLooks {
    std::span<const Material> materials;
    std::vector<const Texture*> textures;  ///< as materials number them
};

/// The light that the materials of two states of a scene let through, by numbers: equal ones let the same
/// light through at the same texture coordinates; 0: none, anywhere. Colours, roughness and what else only
/// pictures show may differ.
struct Passing {
    std::vector<std::size_t> before;  ///< of the materials of the first state
    std::vector<std::size_t> after;
    std::vector<bool> has_texture;  ///< of numbers: whether texture coordinates count
};

Passing passing_of(const ShadowLooks& before, const ShadowLooks& after);

}  // namespace demo
