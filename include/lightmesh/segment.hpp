// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

namespace lightmesh {

/// A straight piece of space between two points, in world units: what an `Intersector` is asked about.
///
/// The library has already moved the ends off surfaces and lights (see `fill/ray_ends.hpp`): an adapter
/// tests what lies strictly between them and adds no epsilon of its own. With a ray tracer that takes origin,
/// direction and length: direction = target - origin, and blockers at 0 < t < 1.
struct Segment {
    glm::vec3 origin;  ///< where it begins
    glm::vec3 target;  ///< where it ends
};

}  // namespace lightmesh
