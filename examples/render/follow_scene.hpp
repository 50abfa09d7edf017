// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene_change.hpp"

#include <lightmesh/lights.hpp>

#include <cstddef>
#include <span>

namespace demo {

/// Tells a light mesh or a visibility cache of a change, with all its lights as they are now.
template <class Mesh>
void follow_scene(Mesh& mesh, std::span<const lightmesh::Light> lights, const SceneChange& change) {
    for (std::size_t i = 0; i < lights.size(); ++i)
        mesh.set_light(i, lights[i]);
    if (!change.boxes.empty())
        mesh.scene_changed(change.boxes);
}

}  // namespace demo
