// SPDX-License-Identifier: MIT
#include "render/illumination.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <variant>

namespace demo {

namespace {

/// Ends at the range, as smoothly as the inverse square beside it.
float window(float distance, float range) {
    const float share = distance / range;
    const float rest = glm::clamp(1.0f - share * share * share * share, 0.0f, 1.0f);
    return rest * rest;
}

float cone_fall_off(const lightmesh::SpotLight& spot, float inner_cone, const glm::vec3& to_light) {
    const float cosine = -glm::dot(glm::normalize(spot.axis), to_light);
    const float outer = std::cos(spot.cone);
    if (cosine < outer)
        return 0.0f;
    const float inner = std::cos((std::min)(inner_cone, spot.cone));
    return inner > outer ? glm::smoothstep(outer, inner, cosine) : 1.0f;
}

Illumination from_position(const glm::vec3& position, float range, const glm::vec3& intensity,
                           const glm::vec3& point) {
    const glm::vec3 way = position - point;
    const float distance = glm::length(way);
    if (!(distance > 0.0f))
        return {glm::vec3(0.0f), glm::vec3(0.0f)};
    return {way / distance, intensity * (window(distance, range) / (distance * distance))};
}

}  // namespace

Illumination illuminate(const SceneLight& light, const glm::vec3& point) {
    if (const auto* sun = std::get_if<lightmesh::DirectionalLight>(&light.shape))
        return {-glm::normalize(sun->direction), light.intensity};
    if (const auto* spot = std::get_if<lightmesh::SpotLight>(&light.shape)) {
        Illumination found = from_position(spot->position, spot->range, light.intensity, point);
        found.irradiance *= cone_fall_off(*spot, light.inner_cone, found.to_light);
        return found;
    }
    if (const auto* pane = std::get_if<lightmesh::RectLight>(&light.shape)) {
        Illumination found = from_position(pane->position, pane->range, light.intensity, point);
        const glm::vec3 front = glm::normalize(glm::cross(pane->half_u, pane->half_v));
        found.irradiance *= (std::max)(-glm::dot(front, found.to_light), 0.0f);
        return found;
    }
    const auto& lamp = std::get<lightmesh::PointLight>(light.shape);
    return from_position(lamp.position, lamp.range, light.intensity, point);
}

lightmesh::Segment shadow_segment(const SceneLight& light, const glm::vec3& point, const glm::vec3& normal,
                                  float offset, float far_away) {
    const glm::vec3 origin = point + offset * normal;
    if (const auto* sun = std::get_if<lightmesh::DirectionalLight>(&light.shape))
        return {origin, origin - far_away * glm::normalize(sun->direction)};
    if (const auto* spot = std::get_if<lightmesh::SpotLight>(&light.shape))
        return {origin, spot->position};
    if (const auto* pane = std::get_if<lightmesh::RectLight>(&light.shape))
        return {origin, pane->position};
    return {origin, std::get<lightmesh::PointLight>(light.shape).position};
}

}  // namespace demo
