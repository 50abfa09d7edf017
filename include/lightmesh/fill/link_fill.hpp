// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/mesh_data.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace lightmesh::detail {

/// Finds the links of the cells in `missing` (one bit a cell) by rays and stores them: from each light point
/// one step up along x, y and z. Returns the number of rays.
template <Intersector Tracer>
std::uint64_t fill_links(MeshData& data, const Tracer& tracer, const Brick& brick, std::uint32_t missing) {
    std::uint64_t rays = 0;
    const glm::ivec3 coord = brick.position();
    for (std::uint32_t rest = missing; rest != 0; rest &= rest - 1) {
        const int cell = std::countr_zero(rest);
        std::array<Segment, 24> segments;
        std::array<std::uint8_t, 24> hit;
        for (int axis = 0; axis < 3; ++axis) {
            for (int p = 0; p < 8; ++p) {
                const glm::ivec3 pos = grid_pos_of(coord, 8 * cell + p);
                glm::ivec3 next = pos;
                ++next[axis];
                segments[static_cast<std::size_t>(8 * axis + p)] = {data.grid().position(pos),
                                                                    data.grid().position(next)};
            }
        }
        trace(tracer, std::span<const Segment>(segments), std::span(hit));
        std::array<std::uint64_t, 3> open{};
        for (std::size_t i = 0; i < segments.size(); ++i)
            if (hit[i] == 0)
                open[i / 8] |= std::uint64_t{1} << (static_cast<std::size_t>(8 * cell) + i % 8);
        data.publish_links(brick, cell, open);
        rays += segments.size();
    }
    return rays;
}

}  // namespace lightmesh::detail
