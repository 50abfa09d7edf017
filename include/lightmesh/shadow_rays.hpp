// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/ray_ends.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <span>

namespace lightmesh {

/// The hard shadows of equation (1), to compare with: the segments that a light mesh traces for points
/// without neighbours, with the same ends and for the same lights.
class ShadowRays {
public:
    /// `resolution`, world units, is what is small in the scene: ends stay off surfaces and lights by 2^-11
    /// of it, besides what floats there cannot tell; a mesh takes the step of its grid. Throws
    /// std::invalid_argument that names the value for a resolution out of (0, 1e18] and for lights that
    /// `LightMesh` would refuse.
    ShadowRays(std::span<const Light> lights, float resolution)
        : resolution_(resolution), table_(lights, grid_of(resolution)) {}

    /// Number of lights.
    std::size_t size() const { return table_.size(); }

    /// True if the light can reach the point at all: chi of equation (3), range and cone. `normal` is the
    /// geometric normal on the shaded side; its length does not matter.
    bool can_light(std::size_t light, const glm::vec3& point, const glm::vec3& normal) const {
        return table_.can_light(light, point, detail::unit_or_zero(normal));
    }

    /// The segment from the surface to the light; that to a directional light is 2^24 resolutions long.
    Segment segment(std::size_t light, const glm::vec3& point, const glm::vec3& normal) const {
        return table_.shadow_segment(light,
                                     detail::surface_end(point, detail::unit_or_zero(normal), resolution_));
    }

    /// Calls visit(light, segment) for all lights that can reach the point.
    template <class Visitor>
    void for_each(const glm::vec3& point, const glm::vec3& normal, Visitor&& visit) const {
        const glm::vec3 unit_normal = detail::unit_or_zero(normal);
        const glm::vec3 end = detail::surface_end(point, unit_normal, resolution_);
        for (std::size_t light = 0; light < size(); ++light)
            if (table_.can_light(light, point, unit_normal))
                visit(light, table_.shadow_segment(light, end));
    }

private:
    static Grid grid_of(float resolution) {
        detail::require(resolution > 0.0f && resolution <= Grid::largest_coordinate,
                        "the resolution of shadow rays", resolution, "greater than 0 and at most 1e18");
        return Grid(Settings{.radius = resolution, .quality = 1.0f});
    }

    float resolution_;
    detail::LightTable table_;
};

}  // namespace lightmesh
