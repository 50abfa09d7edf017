// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/pool.hpp>
#include <lightmesh/mesh/region_table.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/support/atomics.hpp>

#include <glm/vec3.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// The data that queries read: base addresses of all that is stored. The same over a live mesh, which may
/// grow meanwhile, and over a snapshot. Cheap to copy.
struct MeshView {
    const Settings* settings = nullptr;
    const Grid* grid = nullptr;
    const LightTable* lights = nullptr;
    RegionTable region_table;
    PoolView<Region> regions;
    PoolView<Brick> bricks;
    PoolView<std::uint32_t> tile_indices;  ///< where there are several tiles: see `Brick::tiles`
    PoolView<BrickTile> tiles;
    PoolView<CellRow> rows;
    PoolView<std::uint64_t> words;

    /// The brick of these coordinates, or null.
    const Brick* find_brick(const glm::ivec3& coord) const {
        const std::uint32_t region = region_table.find(regions, Region::key_of(coord));
        return region == 0 ? nullptr : find_brick(regions[region - 1], coord);
    }
    const Brick* find_brick(const Region& region, const glm::ivec3& coord) const {
        const std::uint32_t brick = load_acquire(region.bricks[Region::slot(coord)]);
        return brick == 0 ? nullptr : &bricks[brick - 1];
    }

    /// The place of the index of tile t of a brick.
    const std::uint32_t& tile_index(const Brick& brick, std::size_t t) const {
        return lights->tile_count() == 1 ? brick.tiles
                                         : tile_indices[brick.tiles + static_cast<std::uint32_t>(t)];
    }
    /// Tile t of a brick, or null if nothing of it is known.
    const BrickTile* find_tile(const Brick& brick, std::size_t t) const {
        const std::uint32_t tile = load_acquire(tile_index(brick, t));
        return tile == 0 ? nullptr : &tiles[tile - 1];
    }

    /// Of the units in `needed` (see `BrickTile::known`) those that a tile of a brick does not know.
    std::uint64_t missing(const Brick& brick, std::size_t t, std::uint64_t needed) const {
        const BrickTile* tile = find_tile(brick, t);
        return tile == nullptr ? needed : needed & ~load_acquire(tile->known);
    }

    /// Of lights that are uniform in a brick those that it sees.
    std::uint64_t sees_uniform(const Brick& brick, std::size_t t, std::uint64_t of_lights) const {
        return load_relaxed(find_tile(brick, t)->lit) & of_lights;
    }

    /// Bit p of the result: V(L, x) of the light in slot l of tile t from light point p of a cell whose unit
    /// is known.
    std::uint8_t lit_in_cell(const BrickTile& tile, int cell, std::size_t l) const {
        const std::uint64_t bit = std::uint64_t{1} << l;
        if ((load_acquire(tile.uniform) & bit) != 0)
            return (load_relaxed(tile.lit) & bit) != 0 ? 0xff : 0;
        const CellIndex at{load_acquire(tile.cells[static_cast<std::size_t>(cell)])};
        if (at.is_nothing())
            return 0;
        if (!at.is_words())
            return rows[at.index()].bytes[l];
        const std::uint64_t* record = &words[at.index()];
        if ((record[1] & bit) == 0)
            return (record[0] & bit) != 0 ? 0xff : 0;
        const int rank = std::popcount(record[1] & (bit - 1));
        return static_cast<std::uint8_t>(record[2 + rank / 8] >> (8 * (rank % 8)));
    }
};

}  // namespace lightmesh::detail
