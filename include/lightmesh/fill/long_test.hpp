// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/ray_ends.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/light_shape.hpp>
#include <lightmesh/mesh/light_table.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// V(L, x), the visibility of a light from a light point. A long test answers for one unit at a time (see
/// `brick.hpp`). Here what all of them share, and the one by rays.

namespace lightmesh::detail {

/// The eight light points of a cell.
using CellPoints = std::array<glm::vec3, 8>;

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

/// What a long test is asked: does the light at place first + l, l < count <= 8, see points[p]? Lights that
/// no point within `radius` of the cell can be reached by are dark and cost nothing. The answer has bit 8 l +
/// p set for yes.
struct LongTestUnit {
    const LightTable& lights;
    std::size_t first;
    int count;
    const CellPoints& points;
    float radius;

    /// Calls visit(light, l), with the light's number, for the lights that need an answer.
    template <class Visitor>
    void for_each_light(Visitor&& visit) const {
        for (int l = 0; l < count; ++l) {
            const std::size_t light = lights.order().light_at(first + static_cast<std::size_t>(l));
            if (lights.in_range(light, points.front(), points.back(), radius))
                visit(light, l);
        }
    }
};

/// Segments of a unit that are yet to be traced, and the bits they decide.
class PendingSegments {
public:
    void add(const Segment& segment, int bit) {
        segments_[size_] = segment;
        bits_[size_++] = static_cast<std::uint8_t>(bit);
    }

    /// The bits of the segments that are open.
    template <Intersector Tracer>
    std::uint64_t trace_all(const Tracer& tracer, LongTestCost& cost) const {
        std::array<std::uint8_t, most_segments> hit;
        trace(tracer, std::span(segments_).first(size_), std::span(hit).first(size_));
        cost.rays += size_;
        std::uint64_t open = 0;
        for (std::size_t i = 0; i < size_; ++i)
            open |= static_cast<std::uint64_t>(hit[i] == 0) << bits_[i];
        return open;
    }

private:
    std::size_t size_ = 0;
    std::array<Segment, most_segments> segments_;
    std::array<std::uint8_t, most_segments> bits_;
};

/// Long tests by rays of the user's tracer.
class RayLongTest {
public:
    template <Intersector Tracer>
    std::uint64_t operator()(const Tracer& tracer, const LongTestUnit& unit, LongTestCost& cost) const {
        PendingSegments pending;
        unit.for_each_light([&](std::size_t light, int l) {
            for (int p = 0; p < 8; ++p)
                pending.add(unit.lights.long_segment(light, unit.points[static_cast<std::size_t>(p)]),
                            8 * l + p);
            cost.tests += 8;
        });
        return pending.trace_all(tracer, cost);
    }

    std::size_t bytes() const { return 0; }
};

}  // namespace lightmesh::detail
