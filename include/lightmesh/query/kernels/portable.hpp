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
        // What y and z leave for x, for the 8 light points of the cells at each of four (y, z).
        CellEntries square_left[4];
        CellEntries height_left[4];
        for (int yz = 0; yz < 4; ++yz) {
            for (int point = 0; point < 8; ++point) {
                const int y = 2 * (yz % 2) + point / 2 % 2;
                const int z = 2 * (yz / 2) + point / 4;
                square_left[yz][point] = radius_squared - square[1][y] - square[2][z];
                height_left[yz][point] = lowest_height - height[1][y] - height[2][z];
            }
        }
        for (int b = 0; b < bricks; ++b)
            masks[b] = brick_mask(square[0] + 4 * b, height[0] + 4 * b, square_left, height_left);
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
    /// One entry for each light point of a cell. All loops over them have this fixed length, for the sake of
    /// vector instructions.
    using CellEntries = std::int32_t[8];

    static std::uint64_t brick_mask(const std::int32_t* square, const std::int32_t* height,
                                    const CellEntries (&square_left)[4],
                                    const CellEntries (&height_left)[4]) {
        CellEntries cells = {};  // cells[p]: bit c is point p of cell c
        for (int x = 0; x < 2; ++x) {
            CellEntries square_x;
            CellEntries height_x;
            for (int point = 0; point < 8; ++point) {
                square_x[point] = square[2 * x + point % 2];
                height_x[point] = height[2 * x + point % 2];
            }
            for (int yz = 0; yz < 4; ++yz) {
                for (int point = 0; point < 8; ++point) {
                    const bool in_ball = square_x[point] < square_left[yz][point];
                    const bool above = height_x[point] > height_left[yz][point];
                    cells[point] |= (in_ball & above) ? 1 << (2 * yz + x) : 0;
                }
            }
        }
        std::uint8_t bytes[8];
        for (int point = 0; point < 8; ++point)
            bytes[point] = static_cast<std::uint8_t>(cells[point]);
        return transposed(bytes);
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
                for (std::size_t g = 0; g < Groups; ++g) {
                    std::uint64_t lit;
                    std::memcpy(&lit, rows[r].lit + 8 * (group + g), sizeof lit);
                    sums[g] += popcount_bytes(lit & points);
                }
            }
            for (std::size_t i = 0; i < 8 * Groups; ++i)
                counts[i] = static_cast<std::uint16_t>(counts[i] + ((sums[i / 8] >> (8 * (i % 8))) & 0xff));
        }
    }

    /// The 8x8 bits transposed: bit 8 i + j of the result is bit i of byte j. See Warren, "Hacker's Delight",
    /// section 7-3.
    static std::uint64_t transposed(const std::uint8_t (&bytes)[8]) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, bytes, sizeof bits);
        const auto swap = [&bits](int distance, std::uint64_t upper) {
            const std::uint64_t differing = (bits ^ (bits >> distance)) & upper;
            bits ^= differing ^ (differing << distance);
        };
        swap(7, 0x00aa00aa00aa00aau);
        swap(14, 0x0000cccc0000ccccu);
        swap(28, 0x00000000f0f0f0f0u);
        return bits;
    }

    /// The number of bits set in each byte.
    static std::uint64_t popcount_bytes(std::uint64_t v) {
        v -= (v >> 1) & 0x5555555555555555u;
        v = (v & 0x3333333333333333u) + ((v >> 2) & 0x3333333333333333u);
        return (v + (v >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    }
};

}  // namespace lightmesh::detail
