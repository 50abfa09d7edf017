// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// The data of a light mesh, as plain structs that point to each other by index: the same in memory and in a
/// snapshot.
///
///     region 8x8x8 bricks -> brick 4x4x4 light points -> tile of 64 lights -> cells of 2x2x2 light points
///                                        |
///                                        +-> links, floods
///
/// Indices are stored plus one: 0 stands for "nothing".
///
/// A cell has the bits of all lights side by side, a byte each: a load, an AND and a look-up count 16 to 64
/// lights at once. It is found cell by cell, too, so that a query at the rim of a brick traces no more of it.
/// The other way round, one word of 64 light points for each light that sees a brick in part, takes 8 bytes
/// for each such light; a cell takes 16 to 64 for all of them, a brick of eight 128 to 512. So words would be
/// smaller where less than 16 lights of a tile see a brick in part.

namespace lightmesh::detail {

inline constexpr int brick_side = 4;   ///< light points
inline constexpr int region_side = 8;  ///< bricks
inline constexpr int cells_per_brick = 8;

/// Lights are handled in tiles of 64, and within a tile in groups of 8.
inline constexpr std::size_t lights_per_tile = 64;
inline constexpr std::size_t lights_per_group = 8;

/// The number of a light point within its brick, from its coordinates there, each in 0..3. Points are
/// numbered cell by cell: bits 8c .. 8c+7 of a mask are the 2x2x2 light points of cell c.
constexpr int bit_of(int x, int y, int z) {
    return 8 * (x / 2 + 2 * (y / 2) + 4 * (z / 2)) + x % 2 + 2 * (y % 2) + 4 * (z % 2);
}

/// The coordinates of a light point within its brick: the inverse of `bit_of`.
inline glm::ivec3 coord_of(int bit) {
    const int cell = bit / 8;
    return {2 * (cell % 2) + bit % 2, 2 * (cell / 2 % 2) + bit / 2 % 2, 2 * (cell / 4) + bit / 4 % 2};
}

/// The brick that holds a light point, by its position in the grid, along one axis and along all.
inline int brick_of(int coordinate) {
    return coordinate >> 2;
}
inline glm::ivec3 brick_of(const glm::ivec3& grid_pos) {
    return {brick_of(grid_pos.x), brick_of(grid_pos.y), brick_of(grid_pos.z)};
}
/// The number of a light point within its brick, by its position in the grid.
inline int bit_in_brick(const glm::ivec3& grid_pos) {
    return bit_of(grid_pos.x & 3, grid_pos.y & 3, grid_pos.z & 3);
}
/// The position in the grid of light point `bit` of a brick.
inline glm::ivec3 grid_pos_of(const glm::ivec3& brick_coord, int bit) {
    return brick_side * brick_coord + coord_of(bit);
}

inline constexpr std::uint64_t every_byte = 0x0101010101010101u;

/// 0xff in each byte of a brick's mask that is not 0: the cells with light points in it, for all groups of
/// lights.
constexpr std::uint64_t cells_in(std::uint64_t mask) {
    constexpr std::uint64_t low = 0x7f7f7f7f7f7f7f7fu;
    const std::uint64_t highest_bits = (((mask & low) + low) | mask) & ~low;
    return (highest_bits >> 7) * 0xff;
}

/// The same with one bit a cell.
constexpr std::uint32_t cell_bits(std::uint64_t mask) {
    return static_cast<std::uint32_t>((cells_in(mask) & 0x8040201008040201u) * every_byte >> 56);
}

/// The inverse: the light points of cells.
constexpr std::uint64_t points_of_cells(std::uint32_t cells) {
    return cells_in(every_byte * cells & 0x8040201008040201u);
}

/// One cell and all lights of a tile: bit p of byte l is V(L, x) of light l from the cell's light point p.
/// Does not change as long as its index is known.
struct alignas(16) CellRow {
    std::array<std::uint8_t, lights_per_tile> bytes;
};

/// The place of a cell's visibilities. Cells that few lights see by half, most of all outside foliage, take
/// two words and a byte for each such light; the others take a `CellRow`. Those that know no more than what
/// is uniform in their brick (see `BrickTile`) take nothing.
struct CellIndex {
    std::uint32_t value = 0;

    static CellIndex row(std::uint32_t index) { return {2 * (index + 1)}; }
    static CellIndex words(std::uint32_t index) { return {2 * (index + 1) + 1}; }

    bool is_nothing() const { return value == 0; }
    bool is_words() const { return (value & 1) != 0; }
    std::uint32_t index() const { return value / 2 - 1; }
};

/// Of a cell kept in words: word 0 has a bit for each light that all eight light points see, word 1 for each
/// light that some see; from word 2 on a byte for each of the latter, bit p for light point p.
inline constexpr int most_mixed_in_words = 8;

/// The number of words that such a cell takes.
inline std::size_t words_of_cell(const std::uint64_t* words) {
    return words[1] != 0 ? 3 : 2;
}

/// 64 lights of one brick.
struct BrickTile {
    /// Bit 8 * cell + group: whether the lights of the group are known in the cell.
    std::uint64_t known;
    std::uint64_t uniform;  ///< lights that all light points of the brick see, or that none sees; if sampled
    std::uint64_t lit;      ///< of these the lights that are seen
    std::array<std::uint32_t, cells_per_brick> cells;  ///< `CellIndex` values
    std::uint32_t sampled;                             ///< one bit a group: whether `uniform` is known
    std::uint32_t unused;
};

/// The news that samples of a brick have brought of a tile's lights: see `BrickTile`.
struct UniformLights {
    std::uint32_t sampled = 0;
    std::uint64_t uniform = 0;
    std::uint64_t lit = 0;
};

/// One bit for each light of the groups in `groups` (one bit a group).
constexpr std::uint64_t lights_of_groups(std::uint32_t groups) {
    std::uint64_t lights = 0;
    for (std::uint32_t g = 0; g < 8; ++g)
        lights |= (groups >> g & 1) != 0 ? std::uint64_t{0xff} << (8 * g) : 0;
    return lights;
}
/// The lights of the groups that units have in a cell.
constexpr std::uint64_t lights_in_cell(std::uint64_t units, std::size_t cell) {
    return lights_of_groups(static_cast<std::uint32_t>(units >> (8 * cell)) & 0xff);
}

/// One bit for each group of which a unit is set.
constexpr std::uint32_t groups_with_units(std::uint64_t units) {
    units |= units >> 32;
    units |= units >> 16;
    units |= units >> 8;
    return static_cast<std::uint32_t>(units & 0xff);
}

/// 4x4x4 light points.
struct Brick {
    std::array<std::int32_t, 3> coord;  ///< of the first light point in the grid, over 4
    std::uint32_t floods;               ///< index of the flood that was added last (see `flood.hpp`)
    /// For x, y and z: light points whose link one step up is open. A link is the segment between two
    /// neighbouring light points; only those of cells in `links_known` say something.
    std::array<std::uint64_t, 3> links;
    /// With one tile of lights the index of that tile, or 0; with more of them the index, not plus one, of
    /// the first of their indices in `MeshView::tile_indices`.
    std::uint32_t tiles;
    std::uint8_t links_known;  ///< one bit a cell
    std::uint8_t lock;         ///< held by whoever changes tiles or floods
    std::uint16_t used;        ///< the last frame in which a query asked for it: see `MeshData::frame`

    glm::ivec3 position() const { return {coord[0], coord[1], coord[2]}; }
};

/// 8x8x8 places for bricks.
struct Region {
    std::uint64_t key;
    std::array<std::uint32_t, region_side * region_side * region_side> bricks;

    static std::size_t slot(const glm::ivec3& brick_coord) {
        return static_cast<std::size_t>((brick_coord.x & 7) | (brick_coord.y & 7) << 3 |
                                        (brick_coord.z & 7) << 6);
    }
    /// The key of the region that holds a brick.
    static std::uint64_t key_of(const glm::ivec3& brick_coord) {
        const auto bits = [](std::int32_t v) {
            return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v >> 3) & 0x1fffff);
        };
        return bits(brick_coord.x) | bits(brick_coord.y) << 21 | bits(brick_coord.z) << 42;
    }
};

/// All that a level of a mesh knows, as arrays. Each part but a region is named by one other, in the order in
/// which regions, bricks, tiles and cells stand.
struct LevelParts {
    std::span<const std::uint32_t> slots;  ///< of a `RegionTable`
    std::span<const Region> regions;       ///< in the order of their keys
    std::span<const Brick> bricks;
    std::span<const std::uint32_t> tile_indices;
    std::span<const BrickTile> tiles;
    std::span<const CellRow> rows;
    std::span<const std::uint64_t> words;
};

}  // namespace lightmesh::detail
