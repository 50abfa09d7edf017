// SPDX-License-Identifier: MIT
#pragma once

#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/lights.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <variant>
#include <vector>

/// What a visibility cache is held against.

namespace test {

/// The share of a lamp that is open, by many rays in double: plain, without any pattern of the library.
inline double share_of(const std::vector<Triangle>& scene, const lightmesh::Light& light, const Vec& point,
                       const Vec& normal, int count, Random& random) {
    const Vec from = point + 1e-5 * normal;
    int open = 0;
    for (int i = 0; i < count; ++i) {
        Vec to(0.0);
        double share = 1.0;
        const double ring = std::sqrt((i + random.uniform(0.0, 1.0)) / count);
        const double turn = 2.0 * std::numbers::pi * random.uniform(0.0, 1.0);
        const auto on_disc = [&](const Vec& axis, double radius) {
            const Vec other = std::abs(axis.z) < 0.9 ? Vec(0, 0, 1) : Vec(1, 0, 0);
            const Vec right = glm::normalize(glm::cross(axis, other));
            return radius * ring * (std::cos(turn) * right + std::sin(turn) * glm::cross(right, axis));
        };
        if (const auto* sun = std::get_if<lightmesh::DirectionalLight>(&light)) {
            const Vec axis = -glm::normalize(Vec(sun->direction));
            to = from + 100.0 * (axis + on_disc(axis, std::tan(static_cast<double>(sun->angular_radius))));
        } else if (const auto* pane = std::get_if<lightmesh::RectLight>(&light)) {
            to = Vec(pane->position) + random.uniform(-1.0, 1.0) * Vec(pane->half_u) +
                 random.uniform(-1.0, 1.0) * Vec(pane->half_v);
            share = 0.9999;
        } else {
            const auto& lamp = std::get<lightmesh::PointLight>(light);
            const Vec way = Vec(lamp.position) - from;
            const double distance = glm::length(way);
            to = Vec(lamp.position) + on_disc(way / distance, static_cast<double>(lamp.radius));
            share = std::max(0.3, 1.0 - 1.15 * static_cast<double>(lamp.radius) / distance);
        }
        open += blocked(from, from + share * (to - from), scene) ? 0 : 1;
    }
    return static_cast<double>(open) / count;
}

/// Over all pairs of a point and a lamp whose middle it faces.
struct LampErrors {
    double mean = 0.0;
    double misses = 0.0;  ///< share beyond .3
};

/// Those of a cache to lamps of so many rays. S is 0 where the middle of a lamp is below the surface, or
/// where the point is behind a rectangle.
template <class Cache>
LampErrors errors_of(const Cache& cache, const std::vector<Triangle>& scene,
                     const std::vector<lightmesh::Light>& lights, const std::vector<SurfacePoint>& points,
                     int rays) {
    LampErrors errors;
    double pairs = 0.0;
    Random random(77);
    for (const SurfacePoint& point : points) {
        for (std::size_t l = 0; l < lights.size(); ++l) {
            const float found = cache.visibility(point.position, point.normal, l);
            CHECK(found >= 0.0f);
            CHECK(found <= 1.0f);
            Vec way(0.0);
            if (const auto* sun = std::get_if<lightmesh::DirectionalLight>(&lights[l]))
                way = -Vec(sun->direction);
            else if (const auto* pane = std::get_if<lightmesh::RectLight>(&lights[l]))
                way = Vec(pane->position) - Vec(point.position);
            else
                way = Vec(std::get<lightmesh::PointLight>(lights[l]).position) - Vec(point.position);
            if (glm::dot(way, Vec(point.normal)) < 0.0) {
                CHECK(found == 0.0f);
                continue;
            }
            if (const auto* pane = std::get_if<lightmesh::RectLight>(&lights[l]))
                if (glm::dot(way, glm::cross(Vec(pane->half_u), Vec(pane->half_v))) > 0.0) {
                    CHECK(found == 0.0f);
                    continue;
                }
            const double error =
                std::abs(static_cast<double>(found) -
                         share_of(scene, lights[l], Vec(point.position), Vec(point.normal), rays, random));
            errors.mean += error;
            errors.misses += error > 0.3 ? 1.0 : 0.0;
            pairs += 1.0;
        }
    }
    errors.mean /= pairs;
    errors.misses /= pairs;
    return errors;
}

}  // namespace test
