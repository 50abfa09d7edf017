// SPDX-License-Identifier: MIT
#pragma once

#include "blender/core/shadow_looks.hpp"
#include "scene/scene.hpp"
#include "scene/scene_change.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace demo {

/// What one object has in a scene.
struct Piece {
    /// Equal ones of two states of a scene have the same triangles in the same places, and let the same light
    /// through.
    std::uint64_t key = 0;
    std::uint32_t first_triangle = 0;
    std::uint32_t triangle_count = 0;
    std::optional<std::uint32_t> instance{};  ///< that shows the triangles, which are a part's then
};

/// A state of a scene, with all of its objects.
struct SceneState {
    const Scene& scene;
    const std::vector<Piece>& pieces;
};

/// What of the triangles differs as shadows see it: objects that came, went or moved, and triangles of
/// others, whatever their order. Lights and camera are not looked at.
SceneChange triangle_change(const SceneState& before, const SceneState& after, const Passing& passing);

}  // namespace demo
