// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

namespace lightmesh {

/// A point to be lit, with what a renderer knows about it. World units.
struct SurfacePoint {
    glm::vec3 position{0.0f};  ///< P
    /// The geometric normal at P, on the side that is shaded; its length does not matter.
    glm::vec3 normal{0.0f};
    /// The width of the pixel's cone at P, across the ray and not stretched by the surface's slope: the
    /// pixel's angle times the length of the path from the eye, through mirrors and glass the whole path. 0,
    /// NaN or negative: unknown. It chooses how fine the stored values are that serve the point (see
    /// `LightMesh`, `VisibilityCache`); what is stored never depends on it.
    float footprint = 0.0f;
    /// The interpolated normal of smooth shading, of any length, for a `VisibilityCache`; zero, not finite or
    /// on the other side than `normal`: there is none. Light that ends at a facet's plane would show the
    /// facets. With this it fades out as on the smooth surface: a lamp counts if it is above this normal's
    /// plane, and where a facet's plane hides some of it, up to `CacheSettings::lamp_rays` rays, and two
    /// more, tell how much is open, always.
    glm::vec3 shading_normal{0.0f};
};

}  // namespace lightmesh
