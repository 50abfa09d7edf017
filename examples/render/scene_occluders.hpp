// SPDX-License-Identifier: MIT
#pragma once

#include "scene/blockers.hpp"
#include "scene/scene.hpp"

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <memory>

namespace demo {

/// A `lightmesh::Occluders`: the triangles of a scene, which must outlive this; those that light may pass are
/// cut as `cut_blockers` does.
class SceneOccluders {
public:
    explicit SceneOccluders(const Scene& scene) : scene_(&scene) {
        require_no_instances(scene, "shadow volumes");
        if (has_translucent(scene))
            cut_ = std::make_shared<Blockers>(all_blockers(scene));
    }

    /// For this and all its copies, after the scene's triangles have moved.
    void update() {
        if (cut_)
            *cut_ = all_blockers(*scene_);
    }

    std::size_t triangle_count() const { return cut_ ? cut_->indices.size() / 3 : scene_->triangles.size(); }
    std::array<glm::vec3, 3> triangle(std::size_t i) const {
        if (cut_) {
            const std::uint32_t* index = &cut_->indices[3 * i];
            return {cut_->positions[index[0]], cut_->positions[index[1]], cut_->positions[index[2]]};
        }
        const auto& vertex = scene_->triangles[i].vertex;
        return {scene_->positions[vertex[0]], scene_->positions[vertex[1]], scene_->positions[vertex[2]]};
    }

private:
    const Scene* scene_;
    std::shared_ptr<Blockers> cut_;
};

}  // namespace demo
