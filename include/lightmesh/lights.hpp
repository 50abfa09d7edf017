// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <limits>
#include <variant>

namespace lightmesh {

/// Shines from one point in all directions. World units.
struct PointLight {
    glm::vec3 position{0.0f};  ///< finite
    /// Points farther away than this get S = 0 and cost no ray. Greater than 0; infinity: no limit.
    float range = std::numeric_limits<float>::infinity();
};

/// Shines everywhere along one direction, like the sun.
struct DirectionalLight {
    /// The way the light travels, from the light to the scene; any length but 0.
    glm::vec3 direction{0.0f, 0.0f, -1.0f};
};

/// Shines from one point into a cone. Points outside the cone get S = 0 and cost no ray; the soft fall-off
/// towards its edge is the renderer's.
struct SpotLight {
    glm::vec3 position{0.0f};  ///< finite
    /// The middle of the cone, from the light outwards; any length but 0.
    glm::vec3 axis{0.0f, 0.0f, -1.0f};
    /// Half the opening angle: from the axis to the edge, in radians, in (0, pi].
    float cone = 0.7853982f;
    /// As for `PointLight`.
    float range = std::numeric_limits<float>::infinity();
};

/// Where light comes from; its colour and strength stay with the renderer (Omega in equation (1)).
using Light = std::variant<PointLight, DirectionalLight, SpotLight>;

}  // namespace lightmesh
