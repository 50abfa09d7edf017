// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/query/kernels/portable.hpp>

#if defined(__AVX512F__) && defined(__AVX512BW__) && defined(__AVX512DQ__) && defined(__AVX512VL__) &&       \
    defined(__AVX512BITALG__)

#include <immintrin.h>

namespace lightmesh::detail {

/// 16 light points, or 64 lights, at a time.
struct Avx512Kernel {
    static void row_masks(const AxisEntries& square, const AxisEntries& height, std::int32_t radius_squared,
                          std::int32_t lowest_height, int bricks, std::uint64_t* masks) {
        // What y and z leave for x, in the four pairs of cells that a brick has over (y, z).
        __m512i square_left[4];
        __m512i height_left[4];
        for (int z = 0; z < 2; ++z) {
            const __m512i radius =
                _mm512_sub_epi32(_mm512_set1_epi32(radius_squared), along_z(square[2] + 2 * z));
            const __m512i lowest =
                _mm512_sub_epi32(_mm512_set1_epi32(lowest_height), along_z(height[2] + 2 * z));
            for (int y = 0; y < 2; ++y) {
                square_left[2 * z + y] = _mm512_sub_epi32(radius, along_y(square[1] + 2 * y));
                height_left[2 * z + y] = _mm512_sub_epi32(lowest, along_y(height[1] + 2 * y));
            }
        }
        for (int b = 0; b < bricks; ++b) {
            const __m512i square_x = along_x(square[0] + 4 * b);
            const __m512i height_x = along_x(height[0] + 4 * b);
            __mmask16 inside[4];
            for (int yz = 0; yz < 4; ++yz)
                inside[yz] = _mm512_mask_cmpgt_epi32_mask(_mm512_cmplt_epi32_mask(square_x, square_left[yz]),
                                                          height_x, height_left[yz]);
            const __mmask32 low = _mm512_kunpackw(inside[1], inside[0]);
            const __mmask32 high = _mm512_kunpackw(inside[3], inside[2]);
            masks[b] = _cvtmask64_u64(_mm512_kunpackd(high, low));
        }
    }

    static void add_lit(const CellRow* rows, int row_count, std::uint32_t groups, std::uint16_t* counts) {
        const __mmask64 lights = bytes_of(groups);
        const auto low_lights = static_cast<__mmask32>(lights);
        const auto high_lights = static_cast<__mmask32>(lights >> 32);
        __m512i low = _mm512_maskz_loadu_epi16(low_lights, counts);
        __m512i high = _mm512_maskz_loadu_epi16(high_lights, counts + 32);
        constexpr int rows_per_flush = 31;
        for (int first = 0; first < row_count; first += rows_per_flush) {
            const int last = first + rows_per_flush < row_count ? first + rows_per_flush : row_count;
            __m512i sums = _mm512_setzero_si512();
            for (int r = first; r < last; ++r) {
                const __m512i points = _mm512_set1_epi8(static_cast<char>(rows[r].points));
                const __m512i lit = _mm512_maskz_loadu_epi8(lights, rows[r].lit);
                sums = _mm512_add_epi8(sums, _mm512_popcnt_epi8(_mm512_and_si512(lit, points)));
            }
            low = _mm512_add_epi16(low, _mm512_cvtepu8_epi16(_mm512_maskz_extracti64x4_epi64(0xf, sums, 0)));
            high =
                _mm512_add_epi16(high, _mm512_cvtepu8_epi16(_mm512_maskz_extracti64x4_epi64(0xf, sums, 1)));
        }
        _mm512_mask_storeu_epi16(counts, low_lights, low);
        _mm512_mask_storeu_epi16(counts + 32, high_lights, high);
    }

private:
    /// 0xff in each byte whose bit is set in `groups`.
    static std::uint64_t bytes_of(std::uint32_t groups) {
        const std::uint64_t one_bit_a_byte = (groups * 0x0101010101010101u) & 0x8040201008040201u;
        return (((one_bit_a_byte + 0x7f7f7f7f7f7f7f7fu) | one_bit_a_byte) >> 7 & 0x0101010101010101u) * 0xff;
    }

    // The maskz_ forms with full masks are the plain instructions, without g++ 12's false warnings about the
    // plain forms. The lanes are two cells side by side along x: lane l is light point l % 8 of cell l / 8.
    static __m512i spread(const std::int32_t* entries, __m512i lanes) {
        const __m128i four = _mm_loadu_si128(reinterpret_cast<const __m128i*>(entries));
        return _mm512_maskz_permutexvar_epi32(0xffff, lanes, _mm512_castsi128_si512(four));
    }
    static __m512i along_x(const std::int32_t* entries) {
        return spread(entries, _mm512_setr_epi32(0, 1, 0, 1, 0, 1, 0, 1, 2, 3, 2, 3, 2, 3, 2, 3));
    }
    static __m512i along_y(const std::int32_t* entries) {
        return spread_two(entries, _mm512_setr_epi32(0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1));
    }
    static __m512i along_z(const std::int32_t* entries) {
        return spread_two(entries, _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1));
    }
    static __m512i spread_two(const std::int32_t* entries, __m512i lanes) {
        const __m128i two = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(entries));
        return _mm512_maskz_permutexvar_epi32(0xffff, lanes, _mm512_castsi128_si512(two));
    }
};

}  // namespace lightmesh::detail

#define LIGHTMESH_HAS_AVX512_KERNEL 1
#endif
