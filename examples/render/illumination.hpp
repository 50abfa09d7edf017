// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.hpp"

#include <lightmesh/segment.hpp>

#include <glm/vec3.hpp>

namespace demo {

/// The effect of a light on a point if nothing stands between them.
struct Illumination {
    glm::vec3 to_light;    ///< unit length
    glm::vec3 irradiance;  ///< on a surface that faces the light; 0 out of range and outside the cone
};

/// Inverse squares for point and spot lights, with the window to the range and the fall-off from `inner_cone`
/// to the cone that glTF's KHR_lights_punctual recommends. `FallOff::lamps`: the irradiance vector of a
/// rectangle (Arvo, "Analytic Methods for Simulated Light Transport", 1995; what lies below the horizon of
/// the surface counts too), that of a disc across the way to the point for a point light, and for spots the
/// cosine to the axis times a smooth step to the edge.
Illumination illuminate(const SceneLight& light, const glm::vec3& point);

/// The segment of a hard shadow ray. It leaves the surface by `offset` along the normal and ends as far short
/// of a lamp (world units); one to a directional light ends `far` away.
lightmesh::Segment shadow_segment(const SceneLight& light, const glm::vec3& point, const glm::vec3& normal,
                                  float offset, float far_away);

}  // namespace demo
