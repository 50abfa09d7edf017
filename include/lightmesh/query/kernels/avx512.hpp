// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/query/kernels/avx2.hpp>
#include <lightmesh/query/kernels/kernel_types.hpp>
#include <lightmesh/query/kernels/shared.hpp>

#if defined(LIGHTMESH_HAS_AVX2_KERNEL)

#include <immintrin.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#define LIGHTMESH_HAS_AVX512_KERNEL 1
#define LIGHTMESH_AVX512                                                                                     \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx512bitalg,bmi,bmi2,popcnt")))

/// 16 light points, or 64 lights, at a time.

namespace lightmesh::detail::avx512 {

// The maskz_ forms with full masks are the plain instructions, without g++ 12's false warnings about the
// plain forms. The lanes are two cells side by side along x: lane l is light point l % 8 of cell l / 8.
LIGHTMESH_AVX512 inline __m512i along_x(const std::int32_t* entries) {
    const __m128i four = _mm_loadu_si128(reinterpret_cast<const __m128i*>(entries));
    return _mm512_maskz_permutexvar_epi32(0xffff,
                                          _mm512_setr_epi32(0, 1, 0, 1, 0, 1, 0, 1, 2, 3, 2, 3, 2, 3, 2, 3),
                                          _mm512_castsi128_si512(four));
}
LIGHTMESH_AVX512 inline __m512i spread_two(const std::int32_t* entries, __m512i lanes) {
    const __m128i two = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(entries));
    return _mm512_maskz_permutexvar_epi32(0xffff, lanes, _mm512_castsi128_si512(two));
}
LIGHTMESH_AVX512 inline __m512i along_y(const std::int32_t* entries) {
    return spread_two(entries, _mm512_setr_epi32(0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1));
}
LIGHTMESH_AVX512 inline __m512i along_z(const std::int32_t* entries) {
    return spread_two(entries, _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1));
}

struct RowMasks {
    template <class Give>
    LIGHTMESH_AVX512 void operator()(const AxisEntries& square, const AxisEntries& height,
                                     const Hemisphere& hemisphere, Give&& give) const {
        // What y and z leave for x, in the four pairs of cells that a brick has over (y, z).
        __m512i square_left[4];
        __m512i height_left[4];
        for (int z = 0; z < 2; ++z) {
            const __m512i radius =
                _mm512_sub_epi32(_mm512_set1_epi32(hemisphere.radius_squared), along_z(square[2] + 2 * z));
            const __m512i lowest =
                _mm512_sub_epi32(_mm512_set1_epi32(hemisphere.lowest_height), along_z(height[2] + 2 * z));
            for (int y = 0; y < 2; ++y) {
                square_left[2 * z + y] = _mm512_sub_epi32(radius, along_y(square[1] + 2 * y));
                height_left[2 * z + y] = _mm512_sub_epi32(lowest, along_y(height[1] + 2 * y));
            }
        }
        for (int b = 0; b < hemisphere.bricks.x; ++b) {
            const __m512i square_x = along_x(square[0] + 4 * b);
            const __m512i height_x = along_x(height[0] + 4 * b);
            __mmask16 inside[4];
            for (int yz = 0; yz < 4; ++yz)
                inside[yz] = _mm512_mask_cmpgt_epi32_mask(_mm512_cmplt_epi32_mask(square_x, square_left[yz]),
                                                          height_x, height_left[yz]);
            const __mmask32 low = _mm512_kunpackw(inside[1], inside[0]);
            const __mmask32 high = _mm512_kunpackw(inside[3], inside[2]);
            give(b, _cvtmask64_u64(_mm512_kunpackd(high, low)));
        }
    }
};

LIGHTMESH_AVX512 inline std::size_t find_masks(const Hemisphere& hemisphere, BrickMask* masks) {
    return find_masks_by_rows(hemisphere, masks, avx2::fill_points, avx2::fill_bricks, RowMasks{});
}

/// A byte of the sums holds at most 255, and a cell adds at most 8.
inline constexpr std::size_t cells_per_flush = 31;

LIGHTMESH_AVX512 inline void flush(__m512i sums, bool subtract, std::uint16_t* counts) {
    for (int half = 0; half < 2; ++half) {
        const __m256i bytes = half == 0 ? _mm512_maskz_extracti64x4_epi64(0xf, sums, 0)
                                        : _mm512_maskz_extracti64x4_epi64(0xf, sums, 1);
        const __m512i wide = _mm512_maskz_cvtepu8_epi16(0xffffffff, bytes);
        const __m512i before = _mm512_loadu_si512(counts + 32 * half);
        _mm512_storeu_si512(counts + 32 * half,
                            subtract ? _mm512_sub_epi16(before, wide) : _mm512_add_epi16(before, wide));
    }
}

LIGHTMESH_AVX512 inline void add_rows(const RowPoints* rows, std::size_t size, bool subtract,
                                      std::uint16_t* counts) {
    for (std::size_t first = 0; first < size; first += cells_per_flush) {
        const std::size_t last = (std::min)(first + cells_per_flush, size);
        __m512i sums = _mm512_setzero_si512();
        for (std::size_t r = first; r < last; ++r) {
            const __m512i points = _mm512_set1_epi8(static_cast<char>(rows[r].points));
            const __m512i lit = _mm512_and_si512(_mm512_loadu_si512(rows[r].row), points);
            sums = _mm512_add_epi8(sums, _mm512_popcnt_epi8(lit));
        }
        flush(sums, subtract, counts);
    }
}

LIGHTMESH_AVX512 inline void add_words(const WordPoints* points, std::size_t size, bool subtract,
                                       std::uint16_t* counts) {
    for (std::size_t first = 0, last = 0; first < size; first = last) {
        last = end_of_byte_sums(points, first, size);
        __m512i sums = _mm512_setzero_si512();
        for (std::size_t i = first; i < last; ++i) {
            const __m512i count = _mm512_set1_epi8(static_cast<char>(points[i].count));
            sums = _mm512_mask_add_epi8(sums, _cvtu64_mask64(points[i].lit), sums, count);
            add_mixed(points[i], subtract, counts);
        }
        flush(sums, subtract, counts);
    }
}

}  // namespace lightmesh::detail::avx512

#endif
