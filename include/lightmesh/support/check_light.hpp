// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/vectors.hpp>

#include <numbers>
#include <string>
#include <variant>

namespace lightmesh::detail {

inline void check_light(const PointLight& light, const std::string& name) {
    require(is_finite(light.position), name + ": PointLight::position", light.position, "finite");
    require(light.range > 0.0f, name + ": PointLight::range", light.range, "greater than 0");
}

inline void check_light(const DirectionalLight& light, const std::string& name) {
    require(is_finite(light.direction) && !is_zero(light.direction), name + ": DirectionalLight::direction",
            light.direction, "finite and not zero");
}

inline void check_light(const SpotLight& light, const std::string& name) {
    require(is_finite(light.position), name + ": SpotLight::position", light.position, "finite");
    require(is_finite(light.axis) && !is_zero(light.axis), name + ": SpotLight::axis", light.axis,
            "finite and not zero");
    require(light.cone > 0.0f && light.cone <= std::numbers::pi_v<float>, name + ": SpotLight::cone",
            light.cone, "in (0, pi] radians");
    require(light.range > 0.0f, name + ": SpotLight::range", light.range, "greater than 0");
}

/// Throws std::invalid_argument that names the light and the value for anything that is not finite (but a
/// range may be infinite), a range that is not greater than 0, a direction or axis of length 0, and a cone
/// outside (0, pi].
inline void check_light(const Light& light, const std::string& name) {
    std::visit([&](const auto& kind) { check_light(kind, name); }, light);
}

}  // namespace lightmesh::detail
