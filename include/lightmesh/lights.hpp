// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <limits>
#include <variant>

/// A source of light. Colour and strength stay with the renderer (Omega in equation (1)).
///
/// A `LightMesh` asks for the visibility of a light's centre: sizes play no part there. A `VisibilityCache`
/// asks which share of a lamp of that size is visible.

namespace lightmesh {

/// Shines from one point, or from a sphere around it, in all directions. World units.
struct PointLight {
    glm::vec3 position{0.0f};  ///< finite
    /// Points farther away than this get S = 0 and cost no ray. In [0, 1e18], or infinity: no limit. With 0
    /// the light reaches nothing, not even its own place: it is switched off.
    float range = std::numeric_limits<float>::infinity();
    /// Of the lamp: finite, not negative; 0: a point.
    float radius = 0.0f;
};

/// Shines everywhere along one direction, like the sun.
struct DirectionalLight {
    /// The way the light travels, from the light to the scene; any length but 0.
    glm::vec3 direction{0.0f, 0.0f, -1.0f};
    /// Half the angle that the lamp fills in the sky, in radians, in [0, pi / 2); 0: a point. The sun has
    /// 0.00465.
    float angular_radius = 0.0f;
};

/// Shines from one point, or from a sphere around it, into a cone. Points outside the cone get S = 0 and cost
/// no ray; the soft fall-off towards its edge is the renderer's.
struct SpotLight {
    glm::vec3 position{0.0f};  ///< finite
    /// The middle of the cone, from the light outwards; any length but 0.
    glm::vec3 axis{0.0f, 0.0f, -1.0f};
    /// Half the opening angle: from the axis to the edge, in radians, in (0, pi].
    float cone = 0.7853982f;
    /// As for `PointLight`.
    float range = std::numeric_limits<float>::infinity();
    /// As for `PointLight`.
    float radius = 0.0f;
};

/// A rectangle, or a parallelogram, that shines from one side, along cross(half_u, half_v). Points on its
/// plane and behind it get S = 0 and cost no ray.
struct RectLight {
    glm::vec3 position{0.0f};  ///< the centre; finite
    /// From the centre to the middle of one side; finite, of any length but 0.
    glm::vec3 half_u{0.5f, 0.0f, 0.0f};
    /// From the centre to the middle of another side; finite, not parallel to `half_u`.
    glm::vec3 half_v{0.0f, 0.5f, 0.0f};
    /// As for `PointLight`, from the centre.
    float range = std::numeric_limits<float>::infinity();
};

/// A source of light.
using Light = std::variant<PointLight, DirectionalLight, SpotLight, RectLight>;

}  // namespace lightmesh
