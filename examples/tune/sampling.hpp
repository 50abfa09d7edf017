// SPDX-License-Identifier: MIT
#pragma once

#include "render/embree_scene.hpp"
#include "render/renderer.hpp"

#include <glm/vec3.hpp>

#include <cstddef>
#include <vector>

namespace demo {

/// Shading points of a picture.
struct ShadingPoints {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;  ///< geometric
    std::vector<float> footprints;
    // All that the renderer asks for, mirrored ones included.
    std::vector<glm::vec3> all_positions;
    std::vector<glm::vec3> all_normals;
    std::vector<float> all_footprints;
};

/// Some of the points where `render` asks for visibility: about `count`, in runs of 64 that follow each other
/// in the picture, spread over it. Always the same. Throws std::runtime_error if the view shows no surface,
/// or Ctrl-C was pressed.
ShadingPoints sample_shading_points(const EmbreeScene& scene, const RenderOptions& options,
                                    std::size_t count);

}  // namespace demo
