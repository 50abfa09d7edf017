// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/kernels/kernel_types.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

/// Functions that kernels share. These functions become part of whichever kernel calls them, and so are
/// compiled for its processor.

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
    static constexpr int max_bricks = 16;  // those of two vectors
    alignas(64) std::int32_t square[3][max_points];
    alignas(64) std::int32_t height[3][max_points];
    alignas(64) std::int32_t least_square[3][max_bricks];
    alignas(64) std::int32_t greatest_height[3][max_bricks];
};

/// Distances of light points along an axis from the surface point, in fixed-point numbers: that of light
/// point i is first + (i << step_bits); and the normal's component along the axis.
struct AxisDistances {
    std::int32_t first;
    std::int32_t step_bits;
    std::int32_t slope;
};

/// Entries past the box are not used. fill_points(distances, i, square, height) fills eight entries from
/// light point i on: with the squares of the distances and their products with the slope.
/// fill_bricks(distances, b, count, least_square, greatest_height) fills those of up to eight bricks from
/// brick b on.
template <class FillPoints, class FillBricks>
LIGHTMESH_PART_OF_KERNEL void fill_tables(const Hemisphere& hemisphere, AxisTables& tables,
                                          FillPoints&& fill_points, FillBricks&& fill_bricks) {
    for (int axis = 0; axis < 3; ++axis) {
        const int bricks = hemisphere.bricks[axis];
        const AxisDistances distances{-hemisphere.position[axis], hemisphere.fraction_bits,
                                      hemisphere.slope[axis]};
        for (int first = 0; first < brick_side * bricks; first += 8)
            fill_points(distances, first, tables.square[axis] + first, tables.height[axis] + first);
        for (int first = 0; first < bricks; first += 8)
            fill_bricks(distances, first, (std::min)(bricks - first, 8), tables.least_square[axis] + first,
                        tables.greatest_height[axis] + first);
    }
}

/// `Kernels::find_masks`, row by row of bricks along x. Light points belong to the hemisphere whose squared
/// distance is less than its `radius_squared` and whose height is greater than its `lowest_height`.
/// row_masks(square, height, hemisphere, give) calls give(x, light points) for all bricks of a row. The
/// entries for x are those of the whole row, those for y and z those of its bricks.
template <class FillPoints, class FillBricks, class RowMasks>
LIGHTMESH_PART_OF_KERNEL std::size_t find_masks_by_rows(const Hemisphere& around, BrickMask* masks,
                                                        FillPoints&& fill_points, FillBricks&& fill_bricks,
                                                        RowMasks&& row_masks) {
    // A copy, which no pointer leads to: its numbers stay in registers.
    const Hemisphere hemisphere = around;
    AxisTables tables;
    fill_tables(hemisphere, tables, fill_points, fill_bricks);
    const glm::ivec3 bricks = hemisphere.bricks;
    std::int32_t greatest_height_x = tables.greatest_height[0][0];
    for (int x = 1; x < bricks.x; ++x)
        greatest_height_x = (std::max)(greatest_height_x, tables.greatest_height[0][x]);
    std::size_t size = 0;
    for (int z = 0; z < bricks.z; ++z) {
        for (int y = 0; y < bricks.y; ++y) {
            // Only whole rows are left out: where bricks are is as good as random, and a wrong guess of the
            // processor takes longer than a brick's masks.
            if (tables.least_square[2][z] + tables.least_square[1][y] >= hemisphere.radius_squared ||
                tables.greatest_height[2][z] + tables.greatest_height[1][y] + greatest_height_x <=
                    hemisphere.lowest_height)
                continue;
            row_masks(AxisEntries{tables.square[0], &tables.square[1][4 * y], &tables.square[2][4 * z]},
                      AxisEntries{tables.height[0], &tables.height[1][4 * y], &tables.height[2][4 * z]},
                      hemisphere, [&](int x, std::uint64_t points) {
                          masks[size] = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                                         static_cast<std::uint8_t>(z), points};
                          size += points != 0 ? 1u : 0u;
                      });
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

/// The number of lights of the tile that the float test of `find_facing` can tell for sure: the height over
/// the tangent plane must be greater than this, which is more than what rounding can do to it.
LIGHTMESH_PART_OF_KERNEL float facing_band(const LightColumns& lights, const glm::vec3& point) {
    return 0x1p-20f * (lights.largest_at + std::abs(point.x) + std::abs(point.y) + std::abs(point.z));
}

}  // namespace lightmesh::detail
