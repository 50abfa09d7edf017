// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.hpp"

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>

namespace demo {

/// A `lightmesh::Occluders`: the triangles of a scene, which must outlive this.
class SceneOccluders {
public:
    explicit SceneOccluders(const Scene& scene) : scene_(&scene) {}

    std::size_t triangle_count() const { return scene_->triangles.size(); }
    std::array<glm::vec3, 3> triangle(std::size_t i) const {
        const auto& vertex = scene_->triangles[i].vertex;
        return {scene_->positions[vertex[0]], scene_->positions[vertex[1]], scene_->positions[vertex[2]]};
    }

private:
    const Scene* scene_;
};

}  // namespace demo
