// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/depth_view.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/segment.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

/// Scenes of solid boxes, traced in double: what maps and their renderers are held against.

namespace test {

struct BoxScene {
    std::vector<lightmesh::Bounds> boxes;

    /// Distance from `origin` along `way` (in lengths of it) to the nearest surface, inner sides included;
    /// infinity if none.
    double hit(const glm::dvec3& origin, const glm::dvec3& way, double t_near = 0.0) const {
        double nearest = std::numeric_limits<double>::infinity();
        for (const lightmesh::Bounds& box : boxes)
            nearest = (std::min)(nearest, hit_box(box, origin, way, t_near));
        return nearest;
    }

    /// Is anything strictly between?
    bool blocked(const glm::dvec3& from, const glm::dvec3& to) const { return hit(from, to - from) < 1.0; }

private:
    static double hit_box(const lightmesh::Bounds& box, const glm::dvec3& origin, const glm::dvec3& way,
                          double t_near) {
        double enter = -std::numeric_limits<double>::infinity();
        double leave = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
            const double low = static_cast<double>(box.low[axis]) - origin[axis];
            const double high = static_cast<double>(box.high[axis]) - origin[axis];
            if (way[axis] == 0.0) {
                if (low > 0.0 || high < 0.0)
                    return std::numeric_limits<double>::infinity();
                continue;
            }
            enter = (std::max)(enter, (std::min)(low / way[axis], high / way[axis]));
            leave = (std::min)(leave, (std::max)(low / way[axis], high / way[axis]));
        }
        if (enter > leave || leave <= t_near)
            return std::numeric_limits<double>::infinity();
        return enter > t_near ? enter : leave;
    }
};

/// Traces box scenes: a `lightmesh::Intersector`.
struct BoxTracer {
    const BoxScene* scene;

    bool occluded(const lightmesh::Segment& segment) const {
        return scene->blocked(glm::dvec3(segment.origin), glm::dvec3(segment.target));
    }
};

/// Renders box scenes by one ray through the middle of each texel, and counts what it is asked for.
struct BoxRenderer {
    const BoxScene* scene;
    std::size_t* views = nullptr;

    void render_depth(const lightmesh::DepthView& view, std::span<float> distance) {
        if (views != nullptr)
            ++*views;
        for (int row = 0; row < view.resolution; ++row) {
            for (int column = 0; column < view.resolution; ++column) {
                const lightmesh::DepthRay ray = view.ray(column, row);
                const auto place = static_cast<std::size_t>(row * view.resolution + column);
                const double t_near =
                    static_cast<double>(view.z_near / glm::dot(ray.direction, view.forward));
                distance[place] =
                    static_cast<float>(scene->hit(glm::dvec3(ray.origin), glm::dvec3(ray.direction), t_near));
            }
        }
    }
};

}  // namespace test
