// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>

#include <cstdint>

/// A link is the bit "the segment between two neighbouring light points is open"; it depends on neither P nor
/// lights nor camera. Neighbours lie one step apart along x, y or z; a link is stored with the lower of them.

namespace lightmesh::detail {

/// Steps of one light point along an axis, for all light points of a brick at once (numbering as in
/// `bit_of`).
template <std::size_t Axis>
struct AxisSteps {
    static constexpr int one = 1 << Axis;  // from the even to the odd light point of a cell
    static constexpr int across_cells = 7 * one;
    static constexpr int across_bricks = 9 * one;

    /// Light points whose coordinate along the axis is c.
    static constexpr std::uint64_t at(int c) {
        std::uint64_t mask = 0;
        for (int bit = 0; bit < 64; ++bit) {
            const int coordinate = (bit >> Axis & 1) + 2 * (bit >> (Axis + 3) & 1);
            if (coordinate == c)
                mask |= std::uint64_t{1} << bit;
        }
        return mask;
    }

    /// Light points whose coordinate along the axis is at least c.
    static constexpr std::uint64_t from(int c) {
        std::uint64_t mask = 0;
        for (int i = c; i < brick_side; ++i)
            mask |= at(i);
        return mask;
    }

    /// The light points one step up from those of `points`, within the brick.
    static constexpr std::uint64_t up(std::uint64_t points) {
        return (points & (at(0) | at(2))) << one | (points & at(1)) << across_cells;
    }
    /// The light points one step down from those of `points`, within the brick.
    static constexpr std::uint64_t down(std::uint64_t points) {
        return (points & (at(1) | at(3))) >> one | (points & at(2)) >> across_cells;
    }
    /// The light points one step up from those of the brick below.
    static constexpr std::uint64_t up_from(std::uint64_t below) { return (below & at(3)) >> across_bricks; }
    /// The light points one step down from those of the brick above.
    static constexpr std::uint64_t down_from(std::uint64_t above) { return (above & at(0)) << across_bricks; }
};

}  // namespace lightmesh::detail
