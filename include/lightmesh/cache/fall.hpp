// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace lightmesh::detail {

/// The place where something fell: how far, and the unit normal there, towards where it came from.
struct Landing {
    float fall;
    glm::vec3 normal;
};

/// By bisection with `occluded`: the greatest length, to within 2^-13 of `length`, over which the way from
/// `start` is open; nothing if all of it is.
template <Intersector Tracer>
std::optional<float> bisect_fall(const Tracer& tracer, const glm::vec3& start, const glm::vec3& down,
                                 float length, std::uint64_t& rays) {
    ++rays;
    if (!tracer.occluded({start, start + length * down}))
        return std::nullopt;
    float open = 0.0f;
    float part = 1.0f;
    for (int halving = 0; halving < 13; ++halving) {
        part *= 0.5f;
        ++rays;
        if (!tracer.occluded({start, start + (open + part) * length * down}))
            open += part;
    }
    return open * length;
}

/// The distance to the first surface from a point inside a solid, and the unit normal there, outwards; zero
/// where the adapter does not tell.
struct SolidExit {
    double distance;
    glm::dvec3 normal;
};

template <Intersector Tracer>
std::optional<SolidExit> find_exit(const Tracer& tracer, const glm::vec3& start, const glm::dvec3& direction,
                                   double length, std::uint64_t& rays) {
    if constexpr (ClosestHitIntersector<Tracer>) {
        ++rays;
        const auto hit = tracer.closest_hit({start, glm::vec3(glm::dvec3(start) + length * direction)});
        if (!hit || !std::isfinite(hit->distance))
            return std::nullopt;
        const glm::dvec3 normal(is_finite(hit->normal) ? unit_or_zero(hit->normal) : glm::vec3(0.0f));
        return SolidExit{static_cast<double>(hit->distance),
                         glm::dot(normal, direction) < 0.0 ? -normal : normal};
    } else {
        const auto distance =
            bisect_fall(tracer, start, glm::vec3(direction), static_cast<float>(length), rays);
        if (!distance)
            return std::nullopt;
        return SolidExit{static_cast<double>(*distance), glm::dvec3(0.0)};
    }
}

/// The distance by which a surface may lie above where it would go on from a place nearby, world units.
inline float landing_slack(float step) {
    return 0.004f * step;
}

/// The first surface below a point, within `length`.
template <Intersector Tracer>
std::optional<Landing> fall_onto_surface(const Tracer& tracer, const glm::vec3& start, const Facing& facing,
                                         float length, float step, std::uint64_t& rays) {
    const glm::vec3 up = facing.up();
    if constexpr (ClosestHitIntersector<Tracer>) {
        ++rays;
        const std::optional<Hit> hit = tracer.closest_hit({start, start - length * up});
        if (!hit || !std::isfinite(hit->distance))
            return std::nullopt;
        glm::vec3 normal = is_finite(hit->normal) ? unit_or_zero(hit->normal) : glm::vec3(0.0f);
        if (is_zero(normal))
            normal = up;
        return Landing{std::clamp(hit->distance, 0.0f, length),
                       glm::dot(normal, up) < 0.0f ? -normal : normal};
    } else {
        const std::optional<float> fall = bisect_fall(tracer, start, -up, length, rays);
        if (!fall)
            return std::nullopt;
        // Slopes from places beside it, on the side where the surface goes on.
        const float beside = 0.125f * step;
        glm::vec3 normal = up;
        for (const int axis : {facing.u(), facing.v()}) {
            for (const float side : {1.0f, -1.0f}) {
                glm::vec3 there = start;
                there[axis] += side * beside;
                const float moved = there[axis] - start[axis];
                const std::optional<float> other = bisect_fall(tracer, there, -up, length, rays);
                if (moved == 0.0f || !other || std::abs(*other - *fall) > 2.0f * std::abs(moved))
                    continue;
                normal[axis] = (*other - *fall) / moved;
                break;
            }
        }
        return Landing{*fall, glm::normalize(normal)};
    }
}

}  // namespace lightmesh::detail
