// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <variant>

namespace lightmesh::detail {

template <class Lights>
concept LightRange = std::convertible_to<const Lights&, std::span<const Light>>;

/// Says in one sentence what a constructor asks of lights.
template <class Lights>
constexpr void check_light_range() {
    static_assert(LightRange<Lights>, "lightmesh: lights must be a contiguous range of `Light`, such as a "
                                      "`std::vector<Light>`, which holds lights of all kinds");
}

/// Lengths up to this, in world units, can be squared and added without overflow.
inline constexpr float largest_length = 1e18f;

inline void check_range(float range, const std::string& name) {
    require((range >= 0.0f && range <= largest_length) || range == std::numeric_limits<float>::infinity(),
            name, range, "in [0, 1e18], or infinity");
}

inline void check_radius(float radius, const std::string& name) {
    require(radius >= 0.0f && radius <= largest_length, name, radius, "in [0, 1e18]");
}

inline void check_light(const PointLight& light, const std::string& name) {
    require(is_finite(light.position), name + ": PointLight::position", light.position, "finite");
    check_range(light.range, name + ": PointLight::range");
    check_radius(light.radius, name + ": PointLight::radius");
}

inline void check_light(const DirectionalLight& light, const std::string& name) {
    require(is_finite(light.direction) && !is_zero(light.direction), name + ": DirectionalLight::direction",
            light.direction, "finite and not zero");
    require(light.angular_radius >= 0.0f && light.angular_radius < 0.5f * std::numbers::pi_v<float>,
            name + ": DirectionalLight::angular_radius", light.angular_radius, "in [0, pi / 2) radians");
}

inline void check_light(const SpotLight& light, const std::string& name) {
    require(is_finite(light.position), name + ": SpotLight::position", light.position, "finite");
    require(is_finite(light.axis) && !is_zero(light.axis), name + ": SpotLight::axis", light.axis,
            "finite and not zero");
    require(light.cone > 0.0f && light.cone <= std::numbers::pi_v<float>, name + ": SpotLight::cone",
            light.cone, "in (0, pi] radians");
    check_range(light.range, name + ": SpotLight::range");
    check_radius(light.radius, name + ": SpotLight::radius");
}

inline void check_light(const RectLight& light, const std::string& name) {
    require(is_finite(light.position), name + ": RectLight::position", light.position, "finite");
    const auto check_side = [&name](const glm::vec3& side, const char* which) {
        require(largest_component(side) > 0.0f && largest_component(side) <= largest_length,
                name + ": RectLight::" + which, side, "finite and not zero, with components up to 1e18");
    };
    check_side(light.half_u, "half_u");
    check_side(light.half_v, "half_v");
    require(largest_component(glm::cross(unit_or_zero(light.half_u), unit_or_zero(light.half_v))) > 1e-6f,
            name + ": RectLight::half_v", light.half_v, "not parallel to half_u");
    check_range(light.range, name + ": RectLight::range");
}

/// Throws std::invalid_argument that names the light and the value for anything that is not finite (but a
/// range may be infinite), lengths out of range, a direction, axis or side of length 0, parallel sides, and a
/// cone outside (0, pi].
inline void check_light(const Light& light, const std::string& name) {
    std::visit([&](const auto& kind) { check_light(kind, name); }, light);
}

/// The same for all of them, by their numbers.
inline void check_lights(std::span<const Light> lights) {
    for (std::size_t i = 0; i < lights.size(); ++i)
        check_light(lights[i], "light " + to_text(i));
}

}  // namespace lightmesh::detail
