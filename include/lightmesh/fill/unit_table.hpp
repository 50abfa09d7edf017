// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/support/mask_table.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

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

/// Units of all levels of a mesh, the finest first; as many tables as it took.
struct UnitsByLevel {
    std::vector<UnitTable> levels;

    bool is_empty() const {
        return std::ranges::all_of(levels, [](const UnitTable& level) { return level.entries().empty(); });
    }
    /// Throws std::bad_alloc.
    void add(const UnitsByLevel& other) {
        if (levels.size() < other.levels.size())
            levels.resize(other.levels.size());
        for (std::size_t k = 0; k < other.levels.size(); ++k)
            levels[k].add(other.levels[k]);
    }
};

}  // namespace lightmesh::detail
