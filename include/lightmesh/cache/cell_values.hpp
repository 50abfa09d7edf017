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
    /// A row; `is_shaft`: of bytes as `shaft_byte` makes them.
    void set(std::size_t record, const RowBytes& row, bool is_shaft) {
        rows[record] = row;
        if (!is_shaft)
            return;
        misses[record] = 0;
        for (std::size_t o = 0; o < 8; ++o)
            misses[record] |= std::uint64_t{read_shaft_bytes(rows[record].octets[o])} << 8 * o;
    }
    std::uint64_t known(std::size_t record) const { return rows[record].known; }
    std::uint64_t octet(std::size_t record, std::size_t o) const { return rows[record].octets[o]; }
};

}  // namespace lightmesh::detail
