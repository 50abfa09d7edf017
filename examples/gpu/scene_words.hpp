// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.hpp"

#include <glm/vec4.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace demo {

/// A scene as scene.glsl and lights.glsl read it, but for its BVH.
struct SceneWords {
    std::vector<glm::uvec4> corners;  ///< of each triangle, and its material
    std::vector<float> vertices;      ///< one after the other: position, then what of `attributes` there is
    std::vector<glm::uvec4> tables;   ///< materials, lights, textures, the sRGB curve
    std::vector<std::uint32_t> texels;
    glm::uvec4 tables_at{0};   ///< where the four of `tables` begin
    glm::uvec4 attributes{0};  ///< where in a vertex: normal, colour, both texture coordinates; 0: none
    std::uint32_t words_of_vertex = 3;
};

/// `sizes`: of the lights where shadow rays end, as `sizes_at_ends` gives them.
SceneWords words_of(const Scene& scene, std::span<const float> sizes);

/// `SceneWords::vertices` alone.
std::vector<float> vertices_of(const Scene& scene);
/// The lights of `SceneWords::tables` alone.
std::vector<glm::uvec4> lights_of(const Scene& scene, std::span<const float> sizes);

}  // namespace demo
