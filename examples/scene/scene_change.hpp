// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <lightmesh/bounds.hpp>

#include <cstddef>
#include <vector>

namespace demo {

/// The differences between a scene and a later state of it.
struct SceneChange {
    /// True if there are other triangles, materials, colours, texture coordinates, or another number of
    /// lights: nothing that was found of the one scene is true of the other. The next two are empty then.
    bool is_another_scene = false;
    /// Numbers of the lights whose shapes differ: place, direction, cone, range or size, not the strength.
    std::vector<std::size_t> lights;
    /// Boxes around the triangles of which a corner has moved, where they were and where they are: about one
    /// for each object that moved, at most `most_boxes`.
    std::vector<lightmesh::Bounds> boxes;
    bool camera = false;

    static constexpr std::size_t most_boxes = 32;

    /// True if shadows may differ.
    bool changes_shadows() const { return is_another_scene || !lights.empty() || !boxes.empty(); }
    /// True if triangles differ.
    bool changes_triangles() const { return is_another_scene || !boxes.empty(); }
};

/// Finds what differs, bit by bit; NaN equals itself. Textures are not looked at, since no animation changes
/// them.
SceneChange difference(const Scene& before, const Scene& after);

}  // namespace demo
