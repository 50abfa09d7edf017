// SPDX-License-Identifier: MIT
#pragma once

#include "plain.hpp"

#include <lightmesh/segment.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <optional>
#include <vector>

namespace test {

/// Knows where segments meet surfaces.
struct HitTracer {
    const std::vector<Triangle>* triangles;

    bool occluded(const lightmesh::Segment& segment) const {
        return PlainTracer{triangles}.occluded(segment);
    }
    std::optional<lightmesh::Hit> closest_hit(const lightmesh::Segment& segment) const {
        const Vec origin(segment.origin);
        const Vec way = Vec(segment.target) - origin;
        double nearest = 2.0;
        Vec normal(0.0);
        for (const Triangle& t : *triangles) {
            if (!crosses(origin, Vec(segment.target), t))
                continue;
            const Vec n = glm::cross(t.b - t.a, t.c - t.a);
            const double at = glm::dot(t.a - origin, n) / glm::dot(way, n);
            if (at < nearest) {
                nearest = at;
                normal = glm::normalize(n);
            }
        }
        if (nearest > 1.0)
            return std::nullopt;
        return lightmesh::Hit{static_cast<float>(nearest * glm::length(way)), glm::vec3(normal)};
    }
};

}  // namespace test
