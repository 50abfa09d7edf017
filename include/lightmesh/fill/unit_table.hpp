// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/support/mask_table.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// A tile of lights of the brick of these coordinates.
struct BrickTileKey {
    glm::ivec3 brick{0};
    std::size_t tile = 0;

    bool operator==(const BrickTileKey&) const = default;
    std::size_t hash() const {
        std::uint64_t hash = tile;
        for (int axis = 0; axis < 3; ++axis) {
            hash = (hash ^ static_cast<std::uint32_t>(brick[axis])) * 0x9e3779b97f4a7c15u;
            hash ^= hash >> 29;
        }
        return static_cast<std::size_t>(hash);
    }
};

/// Any number of units (see `BrickTile::known`) of one level.
using UnitTable = MaskTable<BrickTileKey>;

}  // namespace lightmesh::detail
