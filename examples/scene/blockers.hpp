// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace demo {

/// Triangles that throw full shadows, three indices each.
struct Blockers {
    std::vector<glm::vec3> positions;
    std::vector<std::uint32_t> indices;
};

/// For what cannot ask a texture, such as rasterisers and shadow volumes: the given triangles, cut into small
/// ones where a mask has holes, without those that let half of the light through or more.
Blockers cut_blockers(const Scene& scene, std::span<const std::uint32_t> triangles);

/// All triangles of a scene, those that light may pass cut by `cut_blockers`.
Blockers all_blockers(const Scene& scene);

/// True if light may pass some surface of the scene.
bool has_translucent(const Scene& scene);

}  // namespace demo
