// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/support/rounded.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>
#include <variant>

namespace lightmesh::detail {

/// The directions into which a light shines: within an angle of an axis. Exact for angles down to 1e-4 and up
/// to pi, where the cosine of the angle would have lost all its digits.
struct LightCone {
    glm::dvec3 axis{0.0};           ///< of length 1
    double tangent_squared = 1e30;  ///< of the angle, or of pi less the angle if that is the smaller
    bool is_wide = false;           ///< more than half of all directions
    bool is_everything = true;

    bool operator==(const LightCone&) const = default;

    static LightCone everything() { return {}; }
    static LightCone around(const glm::vec3& direction, double angle) {
        if (angle >= static_cast<double>(std::numbers::pi_v<float>))
            return {};
        const double tangent = std::tan(angle);
        return {rounded_unit(glm::dvec3(unit_or_zero(direction))), (std::min)(tangent * tangent, 1e30),
                angle > 0.5 * std::numbers::pi, false};
    }
    /// Everything before a plane, without the plane.
    static LightCone in_front_of(const glm::dvec3& unit_normal) { return {unit_normal, 1e30, false, false}; }

    /// True if an offset from the light, of any length, leads along one of the directions.
    bool contains(const glm::vec3& offset) const {
        if (is_everything)
            return true;
        const glm::dvec3 w(offset);
        const double along = rounded_dot(axis, w);
        const glm::dvec3 across = rounded_cross(axis, w);
        const double across_squared = rounded_dot(across, across);
        const double limit = tangent_squared * along * along;
        return is_wide ? along >= 0.0 || across_squared >= limit : along >= 0.0 && across_squared <= limit;
    }
};

/// A light as a mesh knows it, whatever its kind.
struct LightShape {
    bool is_directional = false;
    /// The centre; of a directional light the unit vector towards it.
    glm::vec3 at{0.0f};
    LightCone cone;
    float range = std::numeric_limits<float>::infinity();

    bool operator==(const LightShape&) const = default;

    /// Not even the place where it is.
    bool reaches_nothing() const { return range == 0.0f; }
};

/// The light must be one that `check_light` accepts.
inline LightShape shape_of(const Light& light) {
    return std::visit(
        [](const auto& kind) -> LightShape {
            using Kind = std::remove_cvref_t<decltype(kind)>;
            if constexpr (std::is_same_v<Kind, DirectionalLight>) {
                return {.is_directional = true, .at = -unit_or_zero(kind.direction), .cone = {}};
            } else if constexpr (std::is_same_v<Kind, SpotLight>) {
                return {.at = kind.position,
                        .cone = LightCone::around(kind.axis, static_cast<double>(kind.cone)),
                        .range = kind.range};
            } else if constexpr (std::is_same_v<Kind, RectLight>) {
                const glm::dvec3 u(unit_or_zero(kind.half_u));
                const glm::dvec3 v(unit_or_zero(kind.half_v));
                return {.at = kind.position,
                        .cone = LightCone::in_front_of(rounded_unit(rounded_cross(u, v))),
                        .range = kind.range};
            } else {
                return {.at = kind.position, .cone = {}, .range = kind.range};
            }
        },
        light);
}

}  // namespace lightmesh::detail
