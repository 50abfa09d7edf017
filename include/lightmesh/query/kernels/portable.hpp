// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/query/kernels/kernel_types.hpp>
#include <lightmesh/query/kernels/shared.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

/// The inner loops of a query in plain C++: the definition that the other kernels must equal bit by bit.

namespace lightmesh::detail::portable {

/// One entry for each light point of a cell. All loops over them have this fixed length, for the sake of
/// vector instructions.
using CellEntries = std::int32_t[8];

/// The 8x8 bits transposed: bit 8 i + j of the result is bit i of byte j. See Warren, "Hacker's Delight",
/// section 7-3.
inline std::uint64_t transposed(const std::uint8_t (&bytes)[8]) {
    std::uint64_t bits = 0;
    for (int j = 0; j < 8; ++j)
        bits |= static_cast<std::uint64_t>(bytes[j]) << (8 * j);
    const auto swap = [&bits](int distance, std::uint64_t upper) {
        const std::uint64_t differing = (bits ^ (bits >> distance)) & upper;
        bits ^= differing ^ (differing << distance);
    };
    swap(7, 0x00aa00aa00aa00aau);
    swap(14, 0x0000cccc0000ccccu);
    swap(28, 0x00000000f0f0f0f0u);
    return bits;
}

inline std::uint64_t brick_mask(const std::int32_t* square, const std::int32_t* height,
                                const CellEntries (&square_left)[4], const CellEntries (&height_left)[4]) {
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

/// As `fill_tables` asks for.
inline void fill_points(const AxisDistances& distances, int first, std::int32_t* square,
                        std::int32_t* height) {
    for (int i = 0; i < 8; ++i) {
        const std::int32_t distance = distances.first + (first + i) * (1 << distances.step_bits);
        square[i] = distance * distance;
        height[i] = distance * distances.slope;
    }
}
inline void fill_bricks(const AxisDistances& distances, int first, int count, std::int32_t* least_square,
                        std::int32_t* greatest_height) {
    const std::int32_t side = 3 * (1 << distances.step_bits);
    for (int b = 0; b < count; ++b) {
        const std::int32_t low = distances.first + 4 * (first + b) * (1 << distances.step_bits);
        const std::int32_t gap = (std::max)((std::max)(low, -low - side), 0);
        least_square[b] = gap * gap;
        greatest_height[b] = low * distances.slope + (std::max)(side * distances.slope, 0);
    }
}

/// As `find_masks_by_rows` asks for.
struct RowMasks {
    template <class Give>
    void operator()(const AxisEntries& square, const AxisEntries& height, const Hemisphere& hemisphere,
                    Give&& give) const {
        // What y and z leave for x, for the 8 light points of the cells at each of four (y, z).
        CellEntries square_left[4];
        CellEntries height_left[4];
        for (int yz = 0; yz < 4; ++yz) {
            for (int point = 0; point < 8; ++point) {
                const int y = 2 * (yz % 2) + point / 2 % 2;
                const int z = 2 * (yz / 2) + point / 4;
                square_left[yz][point] = hemisphere.radius_squared - square[1][y] - square[2][z];
                height_left[yz][point] = hemisphere.lowest_height - height[1][y] - height[2][z];
            }
        }
        for (int b = 0; b < hemisphere.bricks.x; ++b)
            give(b, brick_mask(square[0] + 4 * b, height[0] + 4 * b, square_left, height_left));
    }
};

inline std::size_t find_masks(const Hemisphere& hemisphere, BrickMask* masks) {
    return find_masks_by_rows(hemisphere, masks, fill_points, fill_bricks, RowMasks{});
}

inline std::uint64_t find_facing(const LightColumns& lights, const glm::vec3& point,
                                 const glm::vec3& normal) {
    std::uint64_t facing = 0;
    for (std::size_t l = 0; l < lights_per_tile; ++l)
        facing |= static_cast<std::uint64_t>(lights.faces_in_range(l, point, normal)) << l;
    return facing;
}

/// The number of bits set in each byte.
inline std::uint64_t popcount_bytes(std::uint64_t v) {
    v -= (v >> 1) & 0x5555555555555555u;
    v = (v & 0x3333333333333333u) + ((v >> 2) & 0x3333333333333333u);
    return (v + (v >> 4)) & 0x0f0f0f0f0f0f0f0fu;
}

static_assert(std::endian::native == std::endian::little, "lightmesh: rows are read eight lights at a time");

/// A byte of a vector register's worth of sums holds at most 255, and a cell adds at most 8.
inline constexpr std::size_t cells_per_flush = 31;

inline void flush(const std::uint64_t (&sums)[8], bool subtract, std::uint16_t* counts) {
    for (std::size_t l = 0; l < lights_per_tile; ++l) {
        const auto sum = static_cast<std::uint16_t>((sums[l / 8] >> (8 * (l % 8))) & 0xff);
        counts[l] = static_cast<std::uint16_t>(subtract ? counts[l] - sum : counts[l] + sum);
    }
}

inline void add_rows(const RowPoints* rows, std::size_t size, bool subtract, std::uint16_t* counts) {
    for (std::size_t first = 0; first < size; first += cells_per_flush) {
        const std::size_t last = (std::min)(first + cells_per_flush, size);
        std::uint64_t sums[8] = {};
        for (std::size_t r = first; r < last; ++r) {
            const std::uint64_t points = rows[r].points * every_byte;
            for (std::size_t g = 0; g < 8; ++g) {
                std::uint64_t lit;
                std::memcpy(&lit, rows[r].row + 8 * g, sizeof lit);
                sums[g] += popcount_bytes(lit & points);
            }
        }
        flush(sums, subtract, counts);
    }
}

inline void add_words(const WordPoints* points, std::size_t size, bool subtract, std::uint16_t* counts) {
    for (std::size_t first = 0, last = 0; first < size; first = last) {
        last = end_of_byte_sums(points, first, size);
        std::uint64_t sums[8] = {};
        for (std::size_t i = first; i < last; ++i) {
            for (std::size_t g = 0; g < 8; ++g) {
                // A byte for each bit, 1 where it is set.
                const std::uint64_t lit = points[i].lit >> (8 * g) & 0xff;
                const std::uint64_t one_bit_a_byte = lit * every_byte & 0x8040201008040201u;
                sums[g] += ((one_bit_a_byte + 0x7f7f7f7f7f7f7f7fu) >> 7 & every_byte) * points[i].count;
            }
            add_mixed(points[i], subtract, counts);
        }
        flush(sums, subtract, counts);
    }
}

inline bool divide(const std::uint16_t* counts, int count, std::uint64_t reaching, float* values) {
    const auto whole = static_cast<float>(count);
    std::uint32_t mixed = 0;
    for (std::size_t l = 0; l < lights_per_tile; ++l) {
        const std::uint32_t lit = (reaching >> l & 1) != 0 ? counts[l] : 0;
        mixed |= lit * (static_cast<std::uint32_t>(count) - lit);
        values[l] = static_cast<float>(lit) / whole;
    }
    return mixed == 0;
}

}  // namespace lightmesh::detail::portable
