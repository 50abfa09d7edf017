// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

/// The two inner loops of a query, in plain C++: the definition that the other kernels must equal bit by bit.

namespace lightmesh::detail {

/// Entries of a `Hemisphere`'s tables for the four light points of a brick along x, y and z.
using AxisEntries = std::array<const std::int32_t*, 3>;

/// The visibilities of one cell (2x2x2 light points) for up to 64 lights, one byte a light, and the light
/// points in it that count.
struct CellRow {
    const std::uint8_t* lit;
    std::uint8_t points;
};

struct PortableKernel {
    /// For a row of bricks along x, masks[b] = the light points of brick b whose squared distance is less
    /// than `radius_squared` and whose height is greater than `lowest_height`; bits as in `bit_of`. The
    /// entries for x are those of the whole row, those for y and z those of its bricks.
    static void row_masks(const AxisEntries& square, const AxisEntries& height, std::int32_t radius_squared,
                          std::int32_t lowest_height, int bricks, std::uint64_t* masks) {
        for (int b = 0; b < bricks; ++b)
            masks[b] = brick_mask({square[0] + 4 * b, square[1], square[2]},
                                  {height[0] + 4 * b, height[1], height[2]}, radius_squared, lowest_height);
    }

    /// Adds to counts[l] the number of lit light points of light l, over all rows, for the lights of the
    /// groups of 8 in the bit mask `groups`; the bytes of other groups are not read and their counts stay.
    static void add_lit(const CellRow* rows, int row_count, std::uint32_t groups, std::uint16_t* counts) {
        if (groups == 0xff)
            add_lit_groups<8>(rows, row_count, 0, counts);
        else
            for (; groups != 0; groups &= groups - 1)
                add_lit_groups<1>(rows, row_count, static_cast<std::size_t>(std::countr_zero(groups)),
                                  counts);
    }

private:
    static std::uint64_t brick_mask(const AxisEntries& square, const AxisEntries& height,
                                    std::int32_t radius_squared, std::int32_t lowest_height) {
        std::uint64_t mask = 0;
        for (int cell = 0; cell < 8; ++cell) {
            const int x0 = 2 * (cell & 1);
            const int y0 = cell & 2;
            const int z0 = (cell & 4) / 2;
            std::uint8_t inside[8];
            for (int point = 0; point < 8; ++point) {
                const int x = x0 + (point & 1);
                const int y = y0 + ((point >> 1) & 1);
                const int z = z0 + (point >> 2);
                const bool in_ball = square[0][x] + square[1][y] + square[2][z] < radius_squared;
                const bool above = height[0][x] + height[1][y] + height[2][z] > lowest_height;
                inside[point] = static_cast<std::uint8_t>(in_ball & above);
            }
            mask |= gather_bits(inside) << (8 * cell);
        }
        return mask;
    }

    template <std::size_t Groups>
    static void add_lit_groups(const CellRow* rows, int row_count, std::size_t group, std::uint16_t* counts) {
        counts += 8 * group;
        // A byte holds at most 255, and a row adds at most 8.
        constexpr int rows_per_flush = 31;
        for (int first = 0; first < row_count; first += rows_per_flush) {
            const int last = first + rows_per_flush < row_count ? first + rows_per_flush : row_count;
            std::uint64_t sums[Groups] = {};
            for (int r = first; r < last; ++r) {
                const std::uint64_t points = rows[r].points * 0x0101010101010101u;
                std::uint64_t lit[Groups];
                std::memcpy(lit, rows[r].lit + 8 * group, sizeof lit);
                for (std::size_t g = 0; g < Groups; ++g)
                    sums[g] += popcount_bytes(lit[g] & points);
            }
            for (std::size_t i = 0; i < 8 * Groups; ++i)
                counts[i] = static_cast<std::uint16_t>(counts[i] + ((sums[i / 8] >> (8 * (i % 8))) & 0xff));
        }
    }

    /// Eight bytes, each 0 or 1, to eight bits; byte 0 becomes bit 0.
    static std::uint64_t gather_bits(const std::uint8_t (&bytes)[8]) {
        std::uint64_t word = 0;
        for (int i = 0; i < 8; ++i)
            word |= static_cast<std::uint64_t>(bytes[i]) << i;
        return word;
    }

    /// The number of bits set in each byte.
    static std::uint64_t popcount_bytes(std::uint64_t v) {
        v -= (v >> 1) & 0x5555555555555555u;
        v = (v & 0x3333333333333333u) + ((v >> 2) & 0x3333333333333333u);
        return (v + (v >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    }
};

}  // namespace lightmesh::detail
