// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/kernels/kernel_types.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

/// What kernels share. These functions become part of whichever kernel calls them, and so are compiled for
/// its processor.

#if defined(__GNUC__)
#define LIGHTMESH_PART_OF_KERNEL [[gnu::always_inline]] inline
#else
#define LIGHTMESH_PART_OF_KERNEL inline
#endif

namespace lightmesh::detail {

/// Entries of `AxisTables` for the four light points of a brick along x, y and z.
using AxisEntries = std::array<const std::int32_t*, 3>;

/// For each light point along an axis its part of the squared distance, and of the height over the tangent
/// plane; for each brick along the axis the least of the former and the greatest of the latter.
struct AxisTables {
    static constexpr int max_points = brick_side * Hemisphere::max_bricks_per_axis;
    alignas(64) std::int32_t square[3][max_points];
    alignas(64) std::int32_t height[3][max_points];
    std::int32_t least_square[3][Hemisphere::max_bricks_per_axis];
    std::int32_t greatest_height[3][Hemisphere::max_bricks_per_axis];
    std::int32_t greatest_height_x;
};

/// fill_block(first, step, slope, square, height) fills eight entries: distance i is first + i * step,
/// square[i] the square of it, height[i] the product with the slope.
template <class FillBlock>
LIGHTMESH_PART_OF_KERNEL void fill_tables(const Hemisphere& hemisphere, AxisTables& tables,
                                          FillBlock&& fill_block) {
    for (int axis = 0; axis < 3; ++axis) {
        const int bricks = hemisphere.bricks[axis];
        const std::int32_t position = hemisphere.position[axis];
        const std::int32_t slope = hemisphere.slope[axis];
        const int bits = hemisphere.fraction_bits;
        // Entries past the box are not used.
        for (int first = 0; first < brick_side * bricks; first += 8)
            fill_block((first << bits) - position, 1 << bits, slope, tables.square[axis] + first,
                       tables.height[axis] + first);
        std::int32_t greatest = (std::numeric_limits<std::int32_t>::min)();
        for (int b = 0; b < bricks; ++b) {
            const std::int32_t low = ((4 * b) << bits) - position;
            const std::int32_t gap = (std::max)((std::max)(low, -low - (3 << bits)), 0);
            tables.least_square[axis][b] = gap * gap;
            const std::int32_t* height = tables.height[axis] + 4 * b;
            tables.greatest_height[axis][b] = (std::max)(height[0], height[3]);
            greatest = (std::max)(greatest, tables.greatest_height[axis][b]);
        }
        if (axis == 0)
            tables.greatest_height_x = greatest;
    }
}

/// `Kernels::find_masks`, given how to find those of a row of bricks along x: row_masks(square, height,
/// radius_squared, lowest_height, bricks, masks) sets masks[b] to the light points of brick b whose squared
/// distance is less than `radius_squared` and whose height is greater than `lowest_height`. The entries for x
/// are those of the whole row, those for y and z those of its bricks.
template <class FillBlock, class RowMasks>
LIGHTMESH_PART_OF_KERNEL std::size_t find_masks_by_rows(const Hemisphere& hemisphere, BrickMask* masks,
                                                        FillBlock&& fill_block, RowMasks&& row_masks) {
    AxisTables tables;
    fill_tables(hemisphere, tables, fill_block);
    std::size_t size = 0;
    const glm::ivec3 bricks = hemisphere.bricks;
    for (int z = 0; z < bricks.z; ++z) {
        for (int y = 0; y < bricks.y; ++y) {
            if (tables.least_square[2][z] + tables.least_square[1][y] >= hemisphere.radius_squared ||
                tables.greatest_height[2][z] + tables.greatest_height[1][y] + tables.greatest_height_x <=
                    hemisphere.lowest_height)
                continue;
            std::uint64_t row[Hemisphere::max_bricks_per_axis + 1];
            row_masks(AxisEntries{tables.square[0], &tables.square[1][4 * y], &tables.square[2][4 * z]},
                      AxisEntries{tables.height[0], &tables.height[1][4 * y], &tables.height[2][4 * z]},
                      hemisphere.radius_squared, hemisphere.lowest_height, bricks.x, row);
            for (int x = 0; x < bricks.x; ++x) {
                masks[size] = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                               static_cast<std::uint8_t>(z), row[x]};
                size += row[x] != 0 ? 1u : 0u;
            }
        }
    }
    return size;
}

/// The part of `Kernels::add_words` for the lights that some light points of a cell see.
LIGHTMESH_PART_OF_KERNEL void add_mixed(const WordPoints& cell, bool subtract, std::uint16_t* counts) {
    if (cell.mixed == nullptr)
        return;
    std::uint64_t bytes = cell.mixed[1];
    for (std::uint64_t rest = cell.mixed[0]; rest != 0; rest &= rest - 1, bytes >>= 8) {
        const auto lit = std::popcount(static_cast<std::uint32_t>(bytes & cell.points));
        std::uint16_t& count = counts[std::countr_zero(rest)];
        count = static_cast<std::uint16_t>(subtract ? count - lit : count + lit);
    }
}

/// Of `points`, from `first` on, as many as a byte can sum up; returns where they end.
LIGHTMESH_PART_OF_KERNEL std::size_t end_of_byte_sums(const WordPoints* points, std::size_t first,
                                                      std::size_t size) {
    std::size_t last = first;
    for (unsigned sum = 0; last < size && sum + points[last].count <= 255; ++last)
        sum += points[last].count;
    return last;
}

/// How many lights of the tile the float test of `find_facing` can tell for sure: the height over the tangent
/// plane must be greater than this, which is more than what rounding can do to it.
LIGHTMESH_PART_OF_KERNEL float facing_band(const LightColumns& lights, const glm::vec3& point) {
    return 0x1p-20f * (lights.largest_at + std::abs(point.x) + std::abs(point.y) + std::abs(point.z));
}

}  // namespace lightmesh::detail
