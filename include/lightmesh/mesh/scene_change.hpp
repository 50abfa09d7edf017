// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/bounds.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_shape.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

/// The things that a box in which the scene has changed may have to do with.

namespace lightmesh::detail {

/// Throws std::invalid_argument that names the first box that is none: with a corner that is not finite, or
/// whose lower corner is above the upper one.
inline void check_changed(std::span<const Bounds> boxes) {
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const auto& [low, high] = boxes[i];
        const std::string name = "changed box " + to_text(i);
        require(is_finite(low), name + ": Bounds::low", low, "finite");
        require(is_finite(high), name + ": Bounds::high", high, "finite");
        require(low.x <= high.x && low.y <= high.y && low.z <= high.z, name + ": Bounds::low", low,
                "at most Bounds::high");
    }
}

/// True if two boxes have a point in common.
inline bool meets(const Bounds& a, const Bounds& b) {
    return a.low.x <= b.high.x && a.low.y <= b.high.y && a.low.z <= b.high.z && a.high.x >= b.low.x &&
           a.high.y >= b.low.y && a.high.z >= b.low.z;
}
inline bool meets_any(const Bounds& box, std::span<const Bounds> others) {
    return std::ranges::any_of(others, [&](const Bounds& other) { return meets(box, other); });
}

/// A box that is wider to all sides.
inline Bounds widened(const Bounds& box, float margin) {
    return {box.low - margin, box.high + margin};
}

/// The greatest distance between points of two boxes.
inline double farthest_between(const Bounds& a, const Bounds& b) {
    return glm::length((glm::max)(glm::abs(glm::dvec3(b.high) - glm::dvec3(a.low)),
                                  glm::abs(glm::dvec3(a.high) - glm::dvec3(b.low))));
}

/// The box around the light points of all bricks from one to another.
inline Bounds bounds_of(const Grid& grid, const glm::ivec3& first_brick, const glm::ivec3& last_brick) {
    return {grid.position(grid_pos_of(first_brick, 0)), grid.position(grid_pos_of(last_brick, 63))};
}

/// The distance to which a segment between a point and a light goes on.
enum class SegmentEnd {
    at_point,
    beyond_point,  ///< on and on, away from the light
};

/// True if any segment between a box and a light meets another box: exact, but for rounding to the safe side.
/// `extent`: segments end in a box of these half sides around the light's centre; of a directional light at
/// distance 1.
inline bool crosses(const Bounds& from, const LightShape& light, const Bounds& box,
                    SegmentEnd end = SegmentEnd::at_point, const glm::dvec3& extent = glm::dvec3(0.0)) {
    // The points at share t of the way are the box `from`, shrunk to 1 - t, and the light's, shrunk to t, one
    // moved over the other: all axes must overlap at the same t. A directional light is never reached: t goes
    // on without end.
    constexpr double infinity = std::numeric_limits<double>::infinity();
    double first = end == SegmentEnd::beyond_point ? -infinity : 0.0;
    double last = light.is_directional ? infinity : 1.0;
    const auto keep_below = [&](double at_start, double slope, double limit) {
        // at_start + slope * t <= limit
        if (slope > 0.0)
            last = (std::min)(last, (limit - at_start) / slope);
        else if (slope < 0.0)
            first = (std::max)(first, (limit - at_start) / slope);
        else if (at_start > limit)
            last = -infinity;
    };
    // A tracer in floats errs by its largest coordinates.
    const auto size = [](const glm::vec3& corner) {
        return static_cast<double>(largest_component(corner));
    };
    const double slack = 1e-6 * (size(from.low) + size(from.high) + size(box.low) + size(box.high));
    for (int axis = 0; axis < 3; ++axis) {
        const auto low = static_cast<double>(from.low[axis]);
        const auto high = static_cast<double>(from.high[axis]);
        const double least = static_cast<double>(light.at[axis]) - extent[axis];
        const double most = static_cast<double>(light.at[axis]) + extent[axis];
        keep_below(low, light.is_directional ? least : least - low,
                   static_cast<double>(box.high[axis]) + slack);
        keep_below(-high, light.is_directional ? -most : high - most,
                   slack - static_cast<double>(box.low[axis]));
    }
    return first <= last + 1e-9 * std::abs(last) + 1e-12;
}

/// The way that long tests of a light look at the scene: what a changed box can have to do with.
struct LightSight {
    double angle = 0.0;     ///< how far beside a segment something counts, at distance 1 from the light
    double distance = 0.0;  ///< the same, wherever it is; world units
    SegmentEnd end = SegmentEnd::at_point;
    bool fits_scene = false;  ///< all of it may change with the bounds of the scene
};

/// The effect of changed boxes on one light.
class LightChange {
public:
    LightChange(const LightShape& shape, const LightSight& sight, std::span<const Bounds> boxes)
        : shape_(shape), end_(sight.end) {
        boxes_.reserve(boxes.size());
        for (const Bounds& box : boxes) {
            double width = sight.distance;
            if (!shape.is_directional && sight.angle != 0.0)
                width += sight.angle * farthest_between({shape.at, shape.at}, box);
            boxes_.push_back(widened(box, static_cast<float>(1.001 * width)));
        }
    }

    /// True if the light may look different now from somewhere in a box.
    bool concerns(const Bounds& from) const {
        return std::ranges::any_of(boxes_,
                                   [&](const Bounds& box) { return crosses(from, shape_, box, end_); });
    }

private:
    LightShape shape_;
    SegmentEnd end_;
    std::vector<Bounds> boxes_;  ///< wider by what the light sees beside a segment
};

}  // namespace lightmesh::detail
