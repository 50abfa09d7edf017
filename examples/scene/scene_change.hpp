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
    /// lights: nothing that was found of the one scene is true of the other. All else is left out then.
    bool is_another_scene = false;
    /// True if triangles came or went, have other numbers, or let other light through, so that BVHs are to be
    /// built anew. `boxes` are around all those that differ.
    bool has_other_triangles = false;
    /// Numbers of the lights whose shapes differ: place, direction, cone, range or size, not the strength.
    std::vector<std::size_t> lights;
    /// Boxes around the triangles that moved, where they were and where they are: about one for each object
    /// that moved, at most `most_boxes`.
    std::vector<lightmesh::Bounds> boxes;
    bool camera = false;

    static constexpr std::size_t most_boxes = 32;

    /// True if shadows may differ.
    bool changes_shadows() const { return is_another_scene || !lights.empty() || !boxes.empty(); }
    /// True if triangles differ.
    bool changes_triangles() const { return is_another_scene || has_other_triangles || !boxes.empty(); }
};

/// Finds what differs, bit by bit; NaN equals itself. Textures are not looked at, since no animation changes
/// them. Lights and triangles that come or go are another scene.
SceneChange difference(const Scene& before, const Scene& after);

/// At most `SceneChange::most_boxes` around all of some boxes, which it sorts: two where they save a fair
/// share of one.
std::vector<lightmesh::Bounds> few_boxes(std::vector<lightmesh::Bounds>& boxes);

}  // namespace demo
