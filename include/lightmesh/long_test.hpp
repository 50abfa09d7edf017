// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/light_table.hpp>
#include <lightmesh/trace.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

/// V(L, x), the visibility of a light from a light point. A long test answers for one unit at a time (see
/// `brick.hpp`).

namespace lightmesh::detail {

/// The eight light points of a cell.
using CellPoints = std::array<glm::vec3, 8>;

/// What long tests have cost so far.
struct LongTestCost {
    std::uint64_t tests = 0;
    std::uint64_t rays = 0;
};

/// Long tests by rays of the user's tracer.
class RayLongTest {
public:
    /// Byte l of the result has bit p set if light first + l sees points[p]. Lights that no point within
    /// `radius` of the cell can be reached by are left dark and cost nothing. `count` lights, 1..8.
    template <Intersector Tracer>
    std::uint64_t operator()(const Tracer& tracer, const LightTable& lights, std::size_t first, int count,
                             const CellPoints& points, float radius, LongTestCost& cost) const {
        std::array<Segment, most_segments> segments;
        std::array<std::uint8_t, most_segments> hit;
        std::array<int, 8> tested;
        int tested_count = 0;
        for (int l = 0; l < count; ++l) {
            const std::size_t light = first + static_cast<std::size_t>(l);
            if (!lights.in_range(light, points.front(), points.back(), radius))
                continue;
            for (std::size_t p = 0; p < 8; ++p)
                segments[static_cast<std::size_t>(8 * tested_count) + p] =
                    lights.long_segment(light, points[p]);
            tested[static_cast<std::size_t>(tested_count++)] = l;
        }
        const auto size = static_cast<std::size_t>(8 * tested_count);
        trace(tracer, std::span(segments).first(size), std::span(hit).first(size));
        cost.tests += size;
        cost.rays += size;
        std::uint64_t lit = 0;
        for (std::size_t i = 0; i < size; ++i)
            if (hit[i] == 0)
                lit |= std::uint64_t{1} << (8 * static_cast<std::size_t>(tested[i / 8]) + i % 8);
        return lit;
    }
};

}  // namespace lightmesh::detail
