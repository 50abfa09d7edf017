// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/row.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// The values of a tile's lights at the records of a cell, side by side, as far as they have been read.
struct CellValues {
    static constexpr std::size_t no_tile = ~std::size_t{0};
    /// Four records on surfaces, four in the air at their lattice points, and the centre.
    static constexpr std::size_t record_count = 9;
    static constexpr std::size_t first_in_air = 4;
    static constexpr std::size_t centre = 8;

    std::size_t tile;
    std::array<std::uint64_t, record_count> known;
    std::array<std::array<std::uint64_t, record_count>, 8> octets;

    /// Of the first four, if they are shaft rows, the lights of which a record does not tell what lies
    /// around.
    std::array<std::uint64_t, first_in_air> misses;

    void begin(std::size_t of_tile) {
        tile = of_tile;
        known.fill(0);
        misses.fill(0);
    }
    void set(std::size_t record, const RowBytes& row) {
        known[record] = row.known;
        for (std::size_t o = 0; o < 8; ++o)
            octets[o][record] = row.octets[o];
    }
    /// The same for a shaft row.
    void set_shaft(std::size_t record, const RowBytes& row) {
        set(record, row);
        misses[record] = 0;
        for (std::size_t o = 0; o < 8; ++o)
            misses[record] |= std::uint64_t{read_shaft_bytes(octets[o][record])} << 8 * o;
    }
};

}  // namespace lightmesh::detail
