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
    /// Four records on surfaces, four in the air at their lattice points, and the centre, or in its place
    /// what the shafts of the first four say.
    static constexpr std::size_t record_count = 12;
    static constexpr std::size_t first_in_air = 4;
    static constexpr std::size_t centre = 8;
    static constexpr std::size_t first_shaft = 8;

    std::size_t tile;
    std::array<std::uint64_t, record_count> known;
    std::array<std::array<std::uint64_t, record_count>, 8> octets;

    void begin(std::size_t of_tile) {
        tile = of_tile;
        known.fill(0);
    }
    void set(std::size_t record, const RowBytes& row) {
        known[record] = row.known;
        for (std::size_t o = 0; o < 8; ++o)
            octets[o][record] = row.octets[o];
    }
};

}  // namespace lightmesh::detail
