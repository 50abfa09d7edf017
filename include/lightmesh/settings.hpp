// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/bounds.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <limits>
#include <optional>

namespace lightmesh {

/// The way to find V(P, x) of equation (2): does the surface point P see the light point x?
enum class ShortTest {
    none,    ///< Express: every neighbour counts as visible. Fastest; light and shadow leak through walls
             ///< thinner than r.
    linked,  ///< One ray to the nearest visible light point, and from there over cached links between light
             ///< points. Nearly as fast as none and nearly as tight as exact.
    exact,   ///< One ray of the `Intersector` per neighbour, where it can change the result.
};

/// The way to find V(L, x) of equation (3): does the light point x see the light?
enum class LongTest {
    rays,                 ///< a ray of the `Intersector`: LMM
    shadow_maps,          ///< a look-up in a depth map of the `DepthRenderer`: LMM+ATK
    shadow_volumes,       ///< shadow volumes of the `Occluders`: LMM+ATO
    refined_shadow_maps,  ///< depth maps, with a ray where a map cannot tell
};

/// The choices of a user for a light mesh.
struct Settings {
    /// r, the radius of the blur of a shadow's edge, in world units: in (0, 1e18].
    float radius = 1.0f;
    /// q, the light points per radius: the grid's step is r / q. In [1, 16].
    float quality = 4.0f;
    /// The test that keeps light and shadow from leaking through walls.
    ShortTest short_test = ShortTest::linked;
    /// True if long tests are found by samples: in each brick of 4x4x4 light points 16 for each light, and
    /// the others only if these disagree, else they are taken for the same. Saves a third of the rays in
    /// foliage and two thirds elsewhere. `ShortTest::exact` does without.
    bool adaptive_long_tests = true;
    /// Where pixels are wide, light points need not be dense: a point with a `SurfacePoint::footprint` is
    /// served by the finest level of the mesh, with radius and step 2^k times as wide, whose step is wider
    /// than this many footprints. On levels above 0 the blur's radius is q to 2 q times as many pixels; less
    /// is nearer to what r asks for, more makes the first frame faster. At least 0; 0: no levels.
    float footprint_scale = 1.0f;
    /// One point of the grid, in world units, of magnitude up to 1e18; all others lie at origin + h * (i, j,
    /// k). NaN, the default, stands for an uneven fraction of the step in each axis, so that walls at round
    /// coordinates do not lie on grid planes.
    glm::vec3 origin{std::numeric_limits<float>::quiet_NaN()};
    /// Side of a shadow map in texels, in [1, 16384]; only used with a `DepthRenderer`. Seen from a light at
    /// distance D, a texel is up to 2 D / shadow_map_size wide. Maps err where occluders, or the gaps between
    /// them, are not many texels wide: leaves far from a light need finer maps than walls.
    int shadow_map_size = 1024;
    /// True if a look-up that a shadow map cannot decide is decided by a ray: near-exact, for a few rays
    /// more. Only used with a `DepthRenderer`.
    bool refine_shadow_maps = false;
    /// The box around everything that throws shadows, world units; only used with a `DepthRenderer` that has
    /// no member `bounds`, for the shadow maps of directional lights.
    std::optional<Bounds> scene_bounds{};
    /// Bytes beyond which `LightMesh::begin_frame` forgets what has gone unused. Within a frame the mesh
    /// takes what it needs; shadow maps and volumes do not count.
    std::size_t memory_budget = (std::numeric_limits<std::size_t>::max)();
};

}  // namespace lightmesh
