// SPDX-License-Identifier: MIT
#include "render/illumination.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
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

/// Of a disc across the axis, with an edge that is soft in the cosine.
float disc_fall_off(const lightmesh::SpotLight& spot, float inner_cone, const glm::vec3& to_light) {
    const float cosine = -glm::dot(glm::normalize(spot.axis), to_light);
    const float outer = std::cos(spot.cone);
    if (cosine <= outer || cosine <= 0.0f)
        return 0.0f;
    const float inner = std::cos((std::min)(inner_cone, spot.cone));
    return inner > outer ? cosine * glm::smoothstep(outer, inner, cosine) : cosine;
}

/// By how much less a disc that faces the point lights it than a point of the same strength.
float disc_share(float radius, float distance) {
    const float ratio = radius / distance;
    const float slant = std::sqrt(1.0f + ratio * ratio);
    return 2.0f / (slant * (slant + 1.0f));
}

/// The irradiance vector of a rectangle of radiance 1, towards it; 0 behind it.
glm::dvec3 irradiance_vector(const lightmesh::RectLight& pane, const glm::vec3& point) {
    const glm::dvec3 centre = glm::dvec3(pane.position) - glm::dvec3(point);
    const glm::dvec3 u(pane.half_u);
    const glm::dvec3 v(pane.half_v);
    if (glm::dot(glm::cross(u, v), centre) >= 0.0)
        return glm::dvec3(0.0);
    const std::array<glm::dvec3, 4> corners{centre - u - v, centre - u + v, centre + u + v, centre + u - v};
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 normal = glm::cross(corners[i], corners[(i + 1) % corners.size()]);
        const double length = glm::length(normal);
        if (length > 0.0)
            sum += normal *
                   (std::atan2(length, glm::dot(corners[i], corners[(i + 1) % corners.size()])) / length);
    }
    return 0.5 * sum;
}

/// Of a rectangle with all of its pieces.
Illumination from_pane(const lightmesh::RectLight& pane, const glm::vec3& intensity, const glm::vec3& point) {
    const glm::dvec3 whole = irradiance_vector(pane, point);
    const double length = glm::length(whole);
    if (!(length > 0.0))
        return {glm::vec3(0.0f), glm::vec3(0.0f)};
    const float area = 4.0f * glm::length(glm::cross(pane.half_u, pane.half_v));
    const float distance = glm::distance(pane.position, point);
    return {glm::vec3(whole / length),
            intensity * (static_cast<float>(length) / area * window(distance, pane.range))};
}

/// `disc_radius`: of a disc that faces the point, 0 for a point.
Illumination from_position(const glm::vec3& position, float range, const glm::vec3& intensity,
                           const glm::vec3& point, float disc_radius = 0.0f) {
    const glm::vec3 way = position - point;
    const float distance = glm::length(way);
    if (!(distance > 0.0f))
        return {glm::vec3(0.0f), glm::vec3(0.0f)};
    Illumination found{way / distance, intensity * (window(distance, range) / (distance * distance))};
    if (disc_radius > 0.0f)
        found.irradiance *= disc_share(disc_radius, distance);
    return found;
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
        found.irradiance *= light.fall_off == FallOff::lamps
                                ? disc_fall_off(*spot, light.inner_cone, found.to_light)
                                : cone_fall_off(*spot, light.inner_cone, found.to_light);
        return found;
    }
    if (const auto* pane = std::get_if<lightmesh::RectLight>(&light.shape)) {
        if (light.fall_off == FallOff::lamps)
            return from_pane(*pane, light.intensity, point);
        Illumination found = from_position(pane->position, pane->range, light.intensity, point);
        const glm::vec3 front = glm::normalize(glm::cross(pane->half_u, pane->half_v));
        found.irradiance *= (std::max)(-glm::dot(front, found.to_light), 0.0f);
        return found;
    }
    const auto& lamp = std::get<lightmesh::PointLight>(light.shape);
    Illumination found = from_position(lamp.position, lamp.range, light.intensity, point,
                                       light.fall_off == FallOff::lamps ? lamp.radius : 0.0f);
    if (light.facing != glm::vec3(0.0f))
        found.irradiance *= std::abs(glm::dot(light.facing, found.to_light));
    return found;
}

LightTable::LightTable(std::span<const SceneLight> lights)
    : lights_(lights), blocks_((lights.size() + lights_at_once - 1) / lights_at_once) {
    for (std::size_t l = 0; l < lights.size(); ++l) {
        Block& block = blocks_[l / lights_at_once];
        const std::size_t i = l % lights_at_once;
        const auto* lamp = std::get_if<lightmesh::PointLight>(&lights[l].shape);
        if (lamp == nullptr || lights[l].facing != glm::vec3(0.0f)) {
            block.others.push_back(i);
            continue;
        }
        for (int axis = 0; axis < 3; ++axis) {
            block.position[axis][i] = lamp->position[axis];
            block.intensity[axis][i] = lights[l].intensity[axis];
        }
        block.range[i] = lamp->range;
        block.disc_radius[i] = lights[l].fall_off == FallOff::lamps ? lamp->radius : 0.0f;
    }
}

/// What `from_position` says, of all at once.
void LightTable::illuminate(std::size_t first, const glm::vec3& point, const OfLights& lit,
                            Illuminations& found) const {
    const Block& block = blocks_[first / lights_at_once];
    const OfLights x = block.position[0] - point.x;
    const OfLights y = block.position[1] - point.y;
    const OfLights z = block.position[2] - point.z;
    OfLights distance = x * x + y * y + z * z;
    take_roots(distance);
    const OfLights way = distance / block.range;
    OfLights strength = 1.0f - way * way * way * way;
    raise_to(strength, 0.0f);
    limit_to(strength, 1.0f);
    strength /= distance * distance;
    const OfLights ratio = block.disc_radius / distance;
    OfLights slant = 1.0f + ratio * ratio;
    take_roots(slant);
    const OfLights share = 2.0f / (slant * (slant + 1.0f));  // 1 of a point
    const OfLights none{};
    const auto is_there = distance > none;
    const OfLights* const to_light[3]{&x, &y, &z};
    for (int axis = 0; axis < 3; ++axis) {
        found.to_light[axis] = is_there ? *to_light[axis] / distance : none;
        found.irradiance[axis] = is_there ? block.intensity[axis] * strength * share : none;
    }
    for (const std::size_t i : block.others) {
        if (lit[i] == 0.0f)
            continue;
        const Illumination one = demo::illuminate(lights_[first + i], point);
        for (int axis = 0; axis < 3; ++axis) {
            found.to_light[axis][i] = one.to_light[axis];
            found.irradiance[axis][i] = one.irradiance[axis];
        }
    }
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
