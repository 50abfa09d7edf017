// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/query/kernels/kernel_types.hpp>
#include <lightmesh/query/kernels/shared.hpp>
#include <lightmesh/support/processor.hpp>

#if defined(LIGHTMESH_HAS_AVX2_KERNEL)

#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

/// 8 light points, or 32 lights, at a time.

namespace lightmesh::detail::avx2 {

LIGHTMESH_AVX2 inline void fill_points(const AxisDistances& distances, int first, std::int32_t* square,
                                       std::int32_t* height) {
    const __m256i number =
        _mm256_add_epi32(_mm256_set1_epi32(first), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    const __m256i distance = _mm256_add_epi32(
        _mm256_set1_epi32(distances.first), _mm256_sll_epi32(number, _mm_cvtsi32_si128(distances.step_bits)));
    _mm256_store_si256(reinterpret_cast<__m256i*>(square), _mm256_mullo_epi32(distance, distance));
    _mm256_store_si256(reinterpret_cast<__m256i*>(height),
                       _mm256_mullo_epi32(distance, _mm256_set1_epi32(distances.slope)));
}

LIGHTMESH_AVX2 inline void fill_bricks(const AxisDistances& distances, int first, int,
                                       std::int32_t* least_square, std::int32_t* greatest_height) {
    const __m256i number =
        _mm256_add_epi32(_mm256_set1_epi32(4 * first), _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
    const __m256i low = _mm256_add_epi32(_mm256_set1_epi32(distances.first),
                                         _mm256_sll_epi32(number, _mm_cvtsi32_si128(distances.step_bits)));
    const std::int32_t side = 3 * (1 << distances.step_bits);
    const __m256i past_high = _mm256_sub_epi32(_mm256_set1_epi32(-side), low);
    const __m256i gap = _mm256_max_epi32(_mm256_max_epi32(low, past_high), _mm256_setzero_si256());
    _mm256_store_si256(reinterpret_cast<__m256i*>(least_square), _mm256_mullo_epi32(gap, gap));
    const __m256i height = _mm256_mullo_epi32(low, _mm256_set1_epi32(distances.slope));
    _mm256_store_si256(reinterpret_cast<__m256i*>(greatest_height),
                       _mm256_add_epi32(height, _mm256_set1_epi32((std::max)(side * distances.slope, 0))));
}

// The lanes are 2x4 light points of one z: lane l is (l % 2, l / 2).
LIGHTMESH_AVX2 inline __m256i along_x(const std::int32_t* entries) {
    return _mm256_broadcastq_epi64(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(entries)));
}
LIGHTMESH_AVX2 inline __m256i along_y(const std::int32_t* entries) {
    const __m128i four = _mm_load_si128(reinterpret_cast<const __m128i*>(entries));
    return _mm256_permutevar8x32_epi32(_mm256_castsi128_si256(four),
                                       _mm256_setr_epi32(0, 0, 1, 1, 2, 2, 3, 3));
}

struct RowMasks {
    template <class Give>
    LIGHTMESH_AVX2 void operator()(const AxisEntries& square, const AxisEntries& height,
                                   const Hemisphere& hemisphere, Give&& give) const {
        // What y and z leave for x.
        __m256i square_left[4];
        __m256i height_left[4];
        const __m256i radius =
            _mm256_sub_epi32(_mm256_set1_epi32(hemisphere.radius_squared), along_y(square[1]));
        const __m256i lowest =
            _mm256_sub_epi32(_mm256_set1_epi32(hemisphere.lowest_height), along_y(height[1]));
        for (int z = 0; z < 4; ++z) {
            square_left[z] = _mm256_sub_epi32(radius, _mm256_set1_epi32(square[2][z]));
            height_left[z] = _mm256_sub_epi32(lowest, _mm256_set1_epi32(height[2][z]));
        }
        for (int b = 0; b < hemisphere.bricks.x; ++b) {
            __m256i inside[2][4];
            for (int x = 0; x < 2; ++x) {
                const __m256i square_x = along_x(square[0] + 4 * b + 2 * x);
                const __m256i height_x = along_x(height[0] + 4 * b + 2 * x);
                for (int z = 0; z < 4; ++z)
                    inside[x][z] = _mm256_and_si256(_mm256_cmpgt_epi32(square_left[z], square_x),
                                                    _mm256_cmpgt_epi32(height_x, height_left[z]));
            }
            // Packed, the bytes of each 128 bits are those of two cells.
            std::uint64_t mask = 0;
            for (int half = 0; half < 2; ++half) {
                const __m256i cells =
                    _mm256_packs_epi16(_mm256_packs_epi32(inside[0][2 * half], inside[0][2 * half + 1]),
                                       _mm256_packs_epi32(inside[1][2 * half], inside[1][2 * half + 1]));
                mask |= static_cast<std::uint64_t>(static_cast<std::uint32_t>(_mm256_movemask_epi8(cells)))
                        << (32 * half);
            }
            give(b, mask);
        }
    }
};

LIGHTMESH_AVX2 inline std::size_t find_masks(const Hemisphere& hemisphere, BrickMask* masks) {
    return find_masks_by_rows(hemisphere, masks, fill_points, fill_bricks, RowMasks{});
}

/// One bit for each of 64 lanes, from the masks of eight vectors.
LIGHTMESH_AVX2 inline std::uint64_t bits_of(const __m256 (&lanes)[8]) {
    std::uint64_t bits = 0;
    for (int half = 0; half < 2; ++half) {
        const auto pair = [&lanes, half](int i) LIGHTMESH_AVX2 {
            return _mm256_packs_epi32(_mm256_castps_si256(lanes[4 * half + i]),
                                      _mm256_castps_si256(lanes[4 * half + i + 1]));
        };
        // Packing has left fours of lanes in the order 0, 2, 4, 6, 1, 3, 5, 7.
        const __m256i in_order = _mm256_permutevar8x32_epi32(_mm256_packs_epi16(pair(0), pair(2)),
                                                             _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7));
        bits |= static_cast<std::uint64_t>(static_cast<std::uint32_t>(_mm256_movemask_epi8(in_order)))
                << (32 * half);
    }
    return bits;
}

/// In floats; in doubles only where rounding might decide.
LIGHTMESH_AVX2 inline std::uint64_t find_facing(const LightColumns& lights, const glm::vec3& point,
                                                const glm::vec3& normal) {
    const __m256 band = _mm256_set1_ps(facing_band(lights, point));
    const __m256 magnitude = _mm256_castsi256_ps(_mm256_set1_epi32(0x7fffffff));
    const __m256 normal_x = _mm256_set1_ps(normal.x);
    const __m256 normal_y = _mm256_set1_ps(normal.y);
    const __m256 normal_z = _mm256_set1_ps(normal.z);
    __m256 faces[8];
    __m256 is_unsure[8];
    __m256 inside[8];
    __m256 is_near_range[8];
    __m256 any_unsure = _mm256_setzero_ps();
    const auto along_normal = [&](__m256 x, __m256 y, __m256 z) LIGHTMESH_AVX2 {
        return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(normal_x, x), _mm256_mul_ps(normal_y, y)),
                             _mm256_mul_ps(normal_z, z));
    };
    const auto note_height = [&](std::size_t k, __m256 height) LIGHTMESH_AVX2 {
        faces[k] = _mm256_cmp_ps(height, _mm256_setzero_ps(), _CMP_GE_OQ);
        is_unsure[k] = _mm256_cmp_ps(_mm256_and_ps(height, magnitude), band, _CMP_NGT_UQ);
        any_unsure = _mm256_or_ps(any_unsure, is_unsure[k]);
    };
    if (!lights.has_ranges) {
        const __m256 of_point = _mm256_set1_ps(normal.x * point.x + normal.y * point.y + normal.z * point.z);
        for (std::size_t k = 0; k < 8; ++k) {
            const std::size_t l = 8 * k;
            const __m256 of_light =
                along_normal(_mm256_load_ps(&lights.at_x[l]), _mm256_load_ps(&lights.at_y[l]),
                             _mm256_load_ps(&lights.at_z[l]));
            note_height(k, _mm256_sub_ps(of_light, _mm256_mul_ps(of_point, _mm256_load_ps(&lights.w[l]))));
        }
    } else {
        // A sum of squares is right to some 2^-22 of itself.
        const __m256 more = _mm256_set1_ps(1.0f + 0x1p-20f);
        for (std::size_t k = 0; k < 8; ++k) {
            const std::size_t l = 8 * k;
            const __m256 w = _mm256_load_ps(&lights.w[l]);
            const auto offset = [&](const LightColumns::Column& at, float p) LIGHTMESH_AVX2 {
                return _mm256_sub_ps(_mm256_load_ps(&at[l]), _mm256_mul_ps(w, _mm256_set1_ps(p)));
            };
            const __m256 x = offset(lights.at_x, point.x);
            const __m256 y = offset(lights.at_y, point.y);
            const __m256 z = offset(lights.at_z, point.z);
            note_height(k, along_normal(x, y, z));
            const __m256 squares =
                _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y)), _mm256_mul_ps(z, z));
            const __m256 distance = _mm256_mul_ps(w, squares);
            const __m256 range = _mm256_load_ps(&lights.coarse_range_squared[l]);
            inside[k] = _mm256_cmp_ps(_mm256_mul_ps(distance, more), range, _CMP_LE_OQ);
            is_near_range[k] =
                _mm256_andnot_ps(inside[k], _mm256_cmp_ps(distance, _mm256_mul_ps(range, more), _CMP_NGT_UQ));
        }
    }
    std::uint64_t facing = bits_of(faces) & lights.exists;
    std::uint64_t unsure = _mm256_movemask_ps(any_unsure) != 0 ? bits_of(is_unsure) & lights.exists : 0;
    if (lights.has_ranges) {
        const std::uint64_t near_range = bits_of(is_near_range);
        unsure |= facing & near_range;
        facing &= bits_of(inside) | near_range;
    }
    for (; unsure != 0; unsure &= unsure - 1) {
        const auto l = static_cast<std::size_t>(std::countr_zero(unsure));
        const std::uint64_t bit = unsure & (~unsure + 1);
        facing = lights.faces_in_range(l, point, normal) ? facing | bit : facing & ~bit;
    }
    return facing;
}

LIGHTMESH_AVX2 inline void add_to(std::uint16_t* counts, __m128i sums, bool subtract) {
    auto* at = reinterpret_cast<__m256i*>(counts);
    const __m256i wide = _mm256_cvtepu8_epi16(sums);
    const __m256i before = _mm256_loadu_si256(at);
    _mm256_storeu_si256(at, subtract ? _mm256_sub_epi16(before, wide) : _mm256_add_epi16(before, wide));
}

LIGHTMESH_AVX2 inline void flush(const __m256i (&sums)[2], bool subtract, std::uint16_t* counts) {
    for (int half = 0; half < 2; ++half) {
        add_to(counts + 32 * half, _mm256_castsi256_si128(sums[half]), subtract);
        add_to(counts + 32 * half + 16, _mm256_extracti128_si256(sums[half], 1), subtract);
    }
}

/// A byte of `flush`'s sums holds at most 255, and a cell adds at most 8.
inline constexpr std::size_t cells_per_flush = 31;

LIGHTMESH_AVX2 inline void add_rows(const RowPoints* rows, std::size_t size, bool subtract,
                                    std::uint16_t* counts) {
    const __m256i low_bits = _mm256_set1_epi8(0x0f);
    const __m256i bit_counts =
        _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4));
    for (std::size_t first = 0; first < size; first += cells_per_flush) {
        const std::size_t last = (std::min)(first + cells_per_flush, size);
        __m256i sums[2] = {_mm256_setzero_si256(), _mm256_setzero_si256()};
        for (std::size_t r = first; r < last; ++r) {
            const __m256i points = _mm256_set1_epi8(static_cast<char>(rows[r].points));
            for (int half = 0; half < 2; ++half) {
                const auto* bytes = reinterpret_cast<const __m256i*>(rows[r].row + 32 * half);
                const __m256i lit = _mm256_and_si256(_mm256_loadu_si256(bytes), points);
                const __m256i low = _mm256_and_si256(lit, low_bits);
                const __m256i high = _mm256_and_si256(_mm256_srli_epi16(lit, 4), low_bits);
                sums[half] =
                    _mm256_add_epi8(sums[half], _mm256_add_epi8(_mm256_shuffle_epi8(bit_counts, low),
                                                                _mm256_shuffle_epi8(bit_counts, high)));
            }
        }
        flush(sums, subtract, counts);
    }
}

/// 0xff in each byte whose bit is set.
LIGHTMESH_AVX2 inline __m256i bytes_of(std::uint32_t bits) {
    const __m256i which = _mm256_setr_epi8(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2,
                                           2, 2, 3, 3, 3, 3, 3, 3, 3, 3);
    const __m256i bit = _mm256_set1_epi64x(static_cast<long long>(0x8040201008040201u));
    const __m256i spread = _mm256_shuffle_epi8(_mm256_set1_epi32(static_cast<int>(bits)), which);
    return _mm256_cmpeq_epi8(_mm256_and_si256(spread, bit), bit);
}

LIGHTMESH_AVX2 inline void add_words(const WordPoints* points, std::size_t size, bool subtract,
                                     std::uint16_t* counts) {
    for (std::size_t first = 0, last = 0; first < size; first = last) {
        last = end_of_byte_sums(points, first, size);
        __m256i sums[2] = {_mm256_setzero_si256(), _mm256_setzero_si256()};
        for (std::size_t i = first; i < last; ++i) {
            const std::uint64_t lit = points[i].lit;
            if (lit != 0) {
                const __m256i count = _mm256_set1_epi8(static_cast<char>(points[i].count));
                for (int half = 0; half < 2; ++half)
                    sums[half] = _mm256_add_epi8(
                        sums[half],
                        _mm256_and_si256(bytes_of(static_cast<std::uint32_t>(lit >> (32 * half))), count));
            }
            add_mixed(points[i], subtract, counts);
        }
        flush(sums, subtract, counts);
    }
}

LIGHTMESH_AVX2 inline bool divide(const std::uint16_t* counts, int count, std::uint64_t reaching,
                                  float* values) {
    const __m256i bit =
        _mm256_setr_epi16(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, -32768);
    const __m256 whole = _mm256_set1_ps(static_cast<float>(count));
    const __m256i all = _mm256_set1_epi16(static_cast<short>(count));
    __m256i agree = _mm256_set1_epi8(-1);
    for (std::size_t l = 0; l < lights_per_tile; l += 16) {
        const __m256i reaches = _mm256_cmpeq_epi16(
            _mm256_and_si256(_mm256_set1_epi16(static_cast<short>(reaching >> l)), bit), bit);
        const __m256i lit =
            _mm256_and_si256(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(counts + l)), reaches);
        agree = _mm256_and_si256(agree, _mm256_or_si256(_mm256_cmpeq_epi16(lit, _mm256_setzero_si256()),
                                                        _mm256_cmpeq_epi16(lit, all)));
        const __m256i low = _mm256_cvtepu16_epi32(_mm256_castsi256_si128(lit));
        const __m256i high = _mm256_cvtepu16_epi32(_mm256_extracti128_si256(lit, 1));
        _mm256_storeu_ps(values + l, _mm256_div_ps(_mm256_cvtepi32_ps(low), whole));
        _mm256_storeu_ps(values + l + 8, _mm256_div_ps(_mm256_cvtepi32_ps(high), whole));
    }
    return _mm256_movemask_epi8(agree) == -1;
}

}  // namespace lightmesh::detail::avx2

#endif
