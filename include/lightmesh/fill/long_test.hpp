// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/ray_ends.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/light_shape.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// V(L, x), the visibility of a light from light points. Here what all long tests share, and the one by rays.

namespace lightmesh::detail {

/// The most light points that a long test is asked about at once: those of a brick.
inline constexpr std::size_t most_in_long_test = 64;

/// What long tests have cost so far.
struct LongTestCost {
    std::uint64_t tests = 0;
    std::uint64_t rays = 0;
};

/// How far from the light the rays of long tests start; what is nearer hides nothing (see `light_end`). 0 for
/// directional lights, which are nowhere.
inline float light_clearance(const Light& light, float step) {
    const LightShape shape = shape_of(light);
    return shape.is_directional ? 0.0f : end_offset(shape.at, step);
}

/// The light points of `points`, up to 64, that a light is seen from, bit i for points[i]: by rays.
template <Intersector Tracer>
std::uint64_t trace_long_test(const Tracer& tracer, const LightTable& lights, std::size_t light,
                              std::span<const glm::vec3> points, LongTestCost& cost) {
    std::array<Segment, most_in_long_test> segments;
    std::array<std::uint8_t, most_in_long_test> hit;
    for (std::size_t i = 0; i < points.size(); ++i)
        segments[i] = lights.long_segment(light, points[i]);
    trace(tracer, std::span<const Segment>(segments).first(points.size()),
          std::span(hit).first(points.size()));
    cost.rays += points.size();
    std::uint64_t open = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        open |= static_cast<std::uint64_t>(hit[i] == 0) << i;
    return open;
}

/// Long tests by rays of the user's tracer.
class RayLongTests {
public:
    static constexpr LongTest kind = LongTest::rays;

    template <Intersector Tracer>
    std::uint64_t operator()(const Tracer& tracer, const LightTable& lights, std::size_t light,
                             std::span<const glm::vec3> points, LongTestCost& cost) const {
        cost.tests += points.size();
        return trace_long_test(tracer, lights, light, points, cost);
    }

    std::size_t bytes() const { return 0; }
};

}  // namespace lightmesh::detail
