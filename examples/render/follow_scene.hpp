// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene_change.hpp"

#include <lightmesh/lights.hpp>

#include <cstddef>
#include <span>

namespace demo {

/// Tells a light mesh or a visibility cache of a change, with all its lights as they are now: more than it
/// has are added.
template <class Mesh>
void follow_scene(Mesh& mesh, std::span<const lightmesh::Light> lights, const SceneChange& change) {
    const std::size_t known = mesh.light_count();
    for (std::size_t i = 0; i < lights.size(); ++i)
        if (i < known)
            mesh.set_light(i, lights[i]);
        else
            mesh.add_light(lights[i]);
    if (!change.boxes.empty())
        mesh.scene_changed(change.boxes);
}

}  // namespace demo
