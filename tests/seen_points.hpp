// SPDX-License-Identifier: MIT
#pragma once

#include "render/embree_scene.hpp"
#include "render/view.hpp"

#include <lightmesh/surface_point.hpp>

#include <vector>

namespace test {

/// What the eye sees in a small picture, from left to right and from top to bottom.
inline std::vector<lightmesh::SurfacePoint> seen_points(const demo::EmbreeScene& scene, int side) {
    const demo::View view(scene.scene().camera, side, side);
    std::vector<lightmesh::SurfacePoint> points;
    for (int i = 0; i < side * side; ++i) {
        const float column = static_cast<float>(i % side) + 0.5f;
        const float row = static_cast<float>(i / side) + 0.5f;
        if (const auto hit = scene.trace(view.origin(column, row), view.direction(column, row), 1e30f))
            points.push_back({.position = hit->position, .normal = hit->geometric_normal});
    }
    return points;
}

}  // namespace test
