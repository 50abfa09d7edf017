// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/row.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// The values of a tile's lights at the records of a cell, as far as they have been read.
struct CellValues {
    static constexpr std::size_t no_tile = ~std::size_t{0};
    /// Four records on surfaces, four in the air at their lattice points, and the centre.
    static constexpr std::size_t record_count = 9;
    static constexpr std::size_t first_in_air = 4;
    static constexpr std::size_t centre = 8;

    std::size_t tile;
    std::array<RowBytes, record_count> rows;
    /// Of the first four, if they are shaft rows, the lights of which a record does not tell what lies
    /// around.
    std::array<std::uint64_t, first_in_air> misses;

    void begin(std::size_t of_tile) {
        tile = of_tile;
        for (RowBytes& row : rows)
            row.known = 0;
        misses.fill(0);
    }
    /// A row of plain values, and the lights of which its record does not tell what lies around.
    void set(std::size_t record, const RowBytes& row, std::uint64_t of_misses) {
        rows[record] = row;
        if (record < first_in_air)
            misses[record] = of_misses;
    }
    std::uint64_t known(std::size_t record) const { return rows[record].known; }
    /// Of the lights, those that all of the first four know.
    std::uint64_t known_to_four() const { return known(0) & known(1) & known(2) & known(3); }
    /// The lights of which any of the first four does not tell what lies around.
    std::uint64_t misses_of_four() const { return misses[0] | misses[1] | misses[2] | misses[3]; }
    std::uint64_t octet(std::size_t record, std::size_t o) const { return rows[record].octets[o]; }
};

}  // namespace lightmesh::detail
