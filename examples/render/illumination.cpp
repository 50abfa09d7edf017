// SPDX-License-Identifier: MIT
#include "render/illumination.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <variant>

namespace demo {

namespace {

/// The window that KHR_lights_punctual recommends: ends at the range.
float window(float distance, float range) {
    const float share = distance / range;
    return glm::clamp(1.0f - share * share * share * share, 0.0f, 1.0f);
}

float cone_fall_off(const lightmesh::SpotLight& spot, float inner_cone, const glm::vec3& to_light) {
    const float cosine = -glm::dot(glm::normalize(spot.axis), to_light);
    const float outer = std::cos(spot.cone);
    if (cosine < outer)
        return 0.0f;
    const float inner = std::cos((std::min)(inner_cone, spot.cone));
    // KHR_lights_punctual: linear in the cosine, squared.
    const float share = glm::clamp((cosine - outer) / (std::max)(0.001f, inner - outer), 0.0f, 1.0f);
    return share * share;
}

Illumination from_position(const glm::vec3& position, float range, const glm::vec3& intensity,
                           const glm::vec3& point) {
    const glm::vec3 way = position - point;
    const float distance = glm::length(way);
    if (!(distance > 0.0f))
        return {glm::vec3(0.0f), glm::vec3(0.0f)};
    return {way / distance, intensity * (window(distance, range) / (distance * distance))};
}

/// The light's end of a ray: off what the lamp hangs on, but at most half of the way.
glm::vec3 short_of(const glm::vec3& lamp, const glm::vec3& point, float offset) {
    const glm::vec3 way = point - lamp;
    const float distance = glm::length(way);
    return distance > 2.0f * offset ? lamp + way * (offset / distance) : lamp + 0.5f * way;
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
    Illumination found = from_position(lamp.position, lamp.range, light.intensity, point);
    if (light.facing != glm::vec3(0.0f))
        found.irradiance *= std::abs(glm::dot(light.facing, found.to_light));
    return found;
}

lightmesh::Segment shadow_segment(const SceneLight& light, const glm::vec3& point, const glm::vec3& normal,
                                  float offset, float far_away) {
    const glm::vec3 origin = point + offset * normal;
    if (const auto* sun = std::get_if<lightmesh::DirectionalLight>(&light.shape))
        return {origin, origin - far_away * glm::normalize(sun->direction)};
    const auto position = [&light] {
        if (const auto* spot = std::get_if<lightmesh::SpotLight>(&light.shape))
            return spot->position;
        if (const auto* pane = std::get_if<lightmesh::RectLight>(&light.shape))
            return pane->position;
        return std::get<lightmesh::PointLight>(light.shape).position;
    };
    return {origin, short_of(position(), origin, offset)};
}

}  // namespace demo
