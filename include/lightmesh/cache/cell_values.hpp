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
    /// Four records on surfaces, four in the air at their lattice points, and the centre, or in its place
    /// what the shafts of the first four say.
    static constexpr std::size_t record_count = 12;
    static constexpr std::size_t first_in_air = 4;
    static constexpr std::size_t centre = 8;
    static constexpr std::size_t first_shaft = 8;

    std::size_t tile;
    std::array<RowBytes, record_count> rows;

    void begin(std::size_t of_tile) {
        tile = of_tile;
        for (RowBytes& row : rows)
            row.known = 0;
    }
    std::uint64_t known(std::size_t record) const { return rows[record].known; }
    std::uint64_t octet(std::size_t record, std::size_t o) const { return rows[record].octets[o]; }
};

}  // namespace lightmesh::detail
