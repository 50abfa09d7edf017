// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <cstddef>
#include <limits>

namespace lightmesh {

/// The choices of a user for a visibility cache.
struct CacheSettings {
    /// g, the step of the coarsest lattice of records that is used without a footprint, in world units: in
    /// (0, 1e18]. Objects much thinner than g keep their shadows by refinement where they are found; a
    /// quarter of the radius that suits a `LightMesh` is a good choice.
    float spacing = 0.25f;
    /// The number of times that g is halved along penumbrae: records lie down to g / 2^detail apart. In [0,
    /// 6].
    int detail = 3;
    /// Rays to one lamp from one record, at most, not counting eight to its rim: in [1, 256]. The rim and two
    /// rays first, the others only if those disagree; levels of g / 4 take up to a half, finer ones up to a
    /// quarter, but not below 16. Records with `shaft_rows` begin with 16 others instead, or with about a
    /// quarter of these if that is more. Records in the air, which stand in for such as do not fit, take no
    /// more than the rim and two, and finer ones eight or an eighth. Where something thin covers a point, or
    /// no record serves it, rays from the point itself are eight, and as many as those of the finest records
    /// if they disagree. A lamp of size 0 takes one; below 16 there is no rim.
    int lamp_rays = 64;
    /// One point of all lattices, in world units, of magnitude up to 1e18. NaN, the default, stands for an
    /// uneven fraction of the step of each level, so that walls at round coordinates do not lie on lattice
    /// planes.
    glm::vec3 origin{std::numeric_limits<float>::quiet_NaN()};
    /// Bytes beyond which nothing new is kept: queries still give the same values, but find them anew each
    /// time, until `VisibilityCache::begin_frame` forgets what has gone unused. It may be passed by what is
    /// reserved at once, about a megabyte.
    std::size_t memory_budget = (std::numeric_limits<std::size_t>::max)();
    /// True if rays from the point itself decide where the finest records that its footprint allows still
    /// disagree: sharp edges for small lamps and in small pictures, at up to `lamp_rays` rays for each point
    /// and light on such an edge, always.
    bool exact_edges = false;
    /// True if records of steps g, g / 2 and g / 4 have shaft rows, which look at what stands around them:
    /// from 16 places over a square of a step, one of them their own, one ray each to as many parts of a
    /// lamp (of step g / 4 from eight, two rays each). Where these disagree, and the record itself sees
    /// something else than they do together, there are finer records. Contact shadows of things down to a
    /// sixth of g are found, for about a sixth more rays to lamps, and a third more time for the first frame.
    /// Without, four rays a cell ask what lies between its records. Caches of a light mesh have none,
    /// whatever is said here.
    bool shaft_rows = true;
};

}  // namespace lightmesh
