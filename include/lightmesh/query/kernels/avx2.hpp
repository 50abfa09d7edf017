// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/query/kernels/portable.hpp>

#if defined(__AVX2__)

#include <immintrin.h>

namespace lightmesh::detail {

/// 8 light points, or 32 lights, at a time.
struct Avx2Kernel {
    static void row_masks(const AxisEntries& square, const AxisEntries& height, std::int32_t radius_squared,
                          std::int32_t lowest_height, int bricks, std::uint64_t* masks) {
        // What y and z leave for x, in the four pairs of cells that a brick has over (y, z).
        __m256i square_left[4];
        __m256i height_left[4];
        for (int yz = 0; yz < 4; ++yz) {
            const int y = 2 * (yz % 2);
            const int z = 2 * (yz / 2);
            square_left[yz] =
                _mm256_sub_epi32(_mm256_sub_epi32(_mm256_set1_epi32(radius_squared), along_y(square[1] + y)),
                                 along_z(square[2] + z));
            height_left[yz] =
                _mm256_sub_epi32(_mm256_sub_epi32(_mm256_set1_epi32(lowest_height), along_y(height[1] + y)),
                                 along_z(height[2] + z));
        }
        for (int b = 0; b < bricks; ++b) {
            std::uint64_t mask = 0;
            for (int x = 0; x < 2; ++x) {
                const __m256i square_x = along_x(square[0] + 4 * b + 2 * x);
                const __m256i height_x = along_x(height[0] + 4 * b + 2 * x);
                for (int yz = 0; yz < 4; ++yz) {
                    const __m256i inside = _mm256_and_si256(_mm256_cmpgt_epi32(square_left[yz], square_x),
                                                            _mm256_cmpgt_epi32(height_x, height_left[yz]));
                    const int cell = _mm256_movemask_ps(_mm256_castsi256_ps(inside));
                    mask |= static_cast<std::uint64_t>(cell) << (8 * (2 * yz + x));
                }
            }
            masks[b] = mask;
        }
    }

    static void add_lit(const CellRow* rows, int row_count, std::uint32_t groups, std::uint16_t* counts) {
        for (int half = 0; half < 2; ++half)
            if (const std::uint32_t in_half = groups >> (4 * half) & 0xf; in_half != 0)
                add_lit_half(rows, row_count, 32 * half, in_half, counts + 32 * half);
    }

private:
    /// For the 32 lights from `first_light` on; `groups` has a bit for each 8 of them.
    static void add_lit_half(const CellRow* rows, int row_count, int first_light, std::uint32_t groups,
                             std::uint16_t* counts) {
        const __m256i lights = lights_of(groups);
        const __m256i low_bits = _mm256_set1_epi8(0x0f);
        const __m256i bit_counts =
            _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4));
        constexpr int rows_per_flush = 31;
        for (int first = 0; first < row_count; first += rows_per_flush) {
            const int last = first + rows_per_flush < row_count ? first + rows_per_flush : row_count;
            __m256i sums = _mm256_setzero_si256();
            for (int r = first; r < last; ++r) {
                const __m256i points = _mm256_set1_epi8(static_cast<char>(rows[r].points));
                const auto* lit_bytes = reinterpret_cast<const long long*>(rows[r].lit + first_light);
                const __m256i lit = _mm256_and_si256(_mm256_maskload_epi64(lit_bytes, lights), points);
                const __m256i low = _mm256_and_si256(lit, low_bits);
                const __m256i high = _mm256_and_si256(_mm256_srli_epi16(lit, 4), low_bits);
                sums = _mm256_add_epi8(sums, _mm256_shuffle_epi8(bit_counts, low));
                sums = _mm256_add_epi8(sums, _mm256_shuffle_epi8(bit_counts, high));
            }
            add_to(counts, _mm256_castsi256_si128(sums));
            add_to(counts + 16, _mm256_extracti128_si256(sums, 1));
        }
    }

    static void add_to(std::uint16_t* counts, __m128i sums) {
        auto* at = reinterpret_cast<__m256i*>(counts);
        _mm256_storeu_si256(at, _mm256_add_epi16(_mm256_loadu_si256(at), _mm256_cvtepu8_epi16(sums)));
    }

    /// All ones in the 64 bits of each group.
    static __m256i lights_of(std::uint32_t groups) {
        const __m256i bits = _mm256_setr_epi64x(1, 2, 4, 8);
        const __m256i chosen = _mm256_set1_epi64x(static_cast<long long>(groups));
        return _mm256_cmpeq_epi64(_mm256_and_si256(chosen, bits), bits);
    }

    // The lanes are the light points of a cell: lane l is (l % 2, l / 2 % 2, l / 4).
    static __m256i along_x(const std::int32_t* entries) { return _mm256_broadcastq_epi64(two(entries)); }
    static __m256i along_y(const std::int32_t* entries) {
        return _mm256_permutevar8x32_epi32(_mm256_castsi128_si256(two(entries)),
                                           _mm256_setr_epi32(0, 0, 1, 1, 0, 0, 1, 1));
    }
    static __m256i along_z(const std::int32_t* entries) {
        return _mm256_permutevar8x32_epi32(_mm256_castsi128_si256(two(entries)),
                                           _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1));
    }
    static __m128i two(const std::int32_t* entries) {
        return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(entries));
    }
};

}  // namespace lightmesh::detail

#define LIGHTMESH_HAS_AVX2_KERNEL 1
#endif
