// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

namespace lightmesh {

/// A straight piece of space between two points, in world units: what an `Intersector` is asked about.
///
/// The library has already moved the ends off surfaces and lights (see `fill/ray_ends.hpp`): an adapter
/// tests what lies strictly between them and adds no epsilon of its own. With a ray tracer that takes origin,
/// direction and length: direction = target - origin, not normalised, and blockers at 0 < t < 1.
struct Segment {
    glm::vec3 origin;  ///< where it begins
    glm::vec3 target;  ///< where it ends
};

/// The first surface on a segment: what the optional member `closest_hit` of an `Intersector` returns.
struct Hit {
    float distance;    ///< from Segment::origin, world units
    glm::vec3 normal;  ///< the geometric normal there, of length 1, to either side
};

}  // namespace lightmesh
