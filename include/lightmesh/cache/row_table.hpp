// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/record.hpp>
#include <lightmesh/support/mask_table.hpp>

#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// A tile of lights at a record.
struct RowKey {
    RecordKey record;
    std::size_t tile = 0;

    bool operator==(const RowKey&) const = default;
    std::size_t hash() const { return static_cast<std::size_t>(mix_bits(hash_of(record) + tile)); }
};

/// Any number of rows, with one bit for each light of the tile.
using RowTable = MaskTable<RowKey>;

}  // namespace lightmesh::detail
