// SPDX-License-Identifier: MIT
#pragma once

#include "embree_rays.hpp"
#include "render/across.hpp"
#include "scene/random.hpp"
#include "scene/scene.hpp"

#include <lightmesh/lights.hpp>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <variant>
#include <vector>

namespace bench {

/// The share of a sphere lamp that is open from a point, by `count` rays, a multiple of 16, to places of its
/// disc: place(i) gives the i-th, from its middle.
template <class Place>
double open_share(Occlusion& tracer, const glm::vec3& from, const glm::vec3& lamp, float radius, int count,
                  const Place& place) {
    const glm::vec3 way = lamp - from;
    const float distance = glm::length(way);
    const auto [right, up] = demo::across(way / distance);
    const float share = (std::max)(0.3f, 1.0f - 1.15f * radius / distance);
    int open = 0;
    for (int first = 0; first < count; first += 16) {
        alignas(64) RTCRay16 rays;
        alignas(64) std::array<int, 16> valid;
        valid.fill(-1);
        for (int i = 0; i < 16; ++i) {
            const glm::vec2 around = place(first + i);
            set_ray(rays, static_cast<std::size_t>(i), from,
                    from + share * (way + around.x * right + around.y * up));
        }
        tracer.trace(valid.data(), rays);
        for (const float end : rays.tfar)
            open += end < 0.0f ? 0 : 1;
    }
    return static_cast<double>(open) / static_cast<double>(count);
}

/// The same without any pattern.
inline float open_share(Occlusion& tracer, const glm::vec3& from, const glm::vec3& lamp, float radius,
                        int count, demo::Random& random) {
    // Jittered over equal areas: 4 x 4 strata in each packet.
    return static_cast<float>(open_share(tracer, from, lamp, radius, count, [&](int i) {
        const float ring = (static_cast<float>(i % 16 / 4) + random.uniform()) / 4.0f;
        const float turn = (static_cast<float>(i % 4) + random.uniform()) / 4.0f;
        return demo::circle_point(turn) * (radius * std::sqrt(ring));
    }));
}

/// A scene's point lights as spheres.
inline std::vector<lightmesh::Light> sphere_lamps(const demo::Scene& scene, float radius) {
    std::vector<lightmesh::Light> lamps;
    for (const demo::SceneLight& light : scene.lights) {
        auto lamp = std::get<lightmesh::PointLight>(light.shape);
        lamp.radius = radius;
        lamps.emplace_back(lamp);
    }
    return lamps;
}

}  // namespace bench
