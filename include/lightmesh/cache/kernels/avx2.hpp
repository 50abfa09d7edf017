// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/blend.hpp>
#include <lightmesh/cache/cell_values.hpp>
#include <lightmesh/cache/lamp_columns.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/taps.hpp>
#include <lightmesh/support/processor.hpp>

#if defined(LIGHTMESH_HAS_AVX2_KERNEL)

#include <glm/vec3.hpp>
#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

/// The functions of `CacheKernels`, eight lights at a time. All numbers stay below 2^31, so that signed
/// operations do.

namespace lightmesh::detail::avx2_cache {

/// The bytes of a word, the lowest first.
LIGHTMESH_AVX2 inline __m256i spread(const std::uint64_t& word) {
    return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(&word)));
}

/// All ones in the lanes of an octet's lights.
LIGHTMESH_AVX2 inline __m256i select(std::uint64_t lights, int o) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    const __m256i octet = _mm256_set1_epi32(static_cast<int>(lights >> 8 * o & 255u));
    return _mm256_cmpeq_epi32(_mm256_and_si256(octet, bit), bit);
}

LIGHTMESH_AVX2 inline __m256i load(const Lanes& lanes) {
    return _mm256_load_si256(reinterpret_cast<const __m256i*>(&lanes));
}
LIGHTMESH_AVX2 inline void store(Lanes& lanes, __m256i values) {
    _mm256_store_si256(reinterpret_cast<__m256i*>(&lanes), values);
}

/// Whether four values, after rounding to float, lie nearer than the square root of `range_squared`.
LIGHTMESH_AVX2 inline __m256d in_range(__m256d x, __m256d y, __m256d z, __m256d range_squared) {
    x = _mm256_cvtps_pd(_mm256_cvtpd_ps(x));
    y = _mm256_cvtps_pd(_mm256_cvtpd_ps(y));
    z = _mm256_cvtps_pd(_mm256_cvtpd_ps(z));
    const __m256d sum =
        _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y)), _mm256_mul_pd(z, z));
    return _mm256_cmp_pd(sum, range_squared, _CMP_LE_OQ);
}

LIGHTMESH_AVX2 inline std::uint64_t find_reaching(const LampColumns& lamps, std::size_t size,
                                                  const glm::vec3& point, const glm::vec3& normal) {
    const __m256d n_x = _mm256_set1_pd(static_cast<double>(normal.x));
    const __m256d n_y = _mm256_set1_pd(static_cast<double>(normal.y));
    const __m256d n_z = _mm256_set1_pd(static_cast<double>(normal.z));
    const __m256d p_x = _mm256_set1_pd(static_cast<double>(point.x));
    const __m256d p_y = _mm256_set1_pd(static_cast<double>(point.y));
    const __m256d p_z = _mm256_set1_pd(static_cast<double>(point.z));
    const __m256d height = _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(n_x, p_x), _mm256_mul_pd(n_y, p_y)),
                                         _mm256_mul_pd(n_z, p_z));
    const __m256d zero = _mm256_setzero_pd();
    std::uint64_t mask = 0;
    for (std::size_t i = 0; i < size; i += 4) {
        const __m256d x = _mm256_loadu_pd(&lamps.at_x[i]);
        const __m256d y = _mm256_loadu_pd(&lamps.at_y[i]);
        const __m256d z = _mm256_loadu_pd(&lamps.at_z[i]);
        const __m256d w = _mm256_loadu_pd(&lamps.w[i]);
        const __m256d facing = _mm256_sub_pd(
            _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(n_x, x), _mm256_mul_pd(n_y, y)), _mm256_mul_pd(n_z, z)),
            _mm256_mul_pd(w, height));
        __m256d reaches = _mm256_cmp_pd(facing, zero, _CMP_GE_OQ);
        if (lamps.has_ranges) {
            const __m256d is_near = in_range(_mm256_sub_pd(x, p_x), _mm256_sub_pd(y, p_y),
                                             _mm256_sub_pd(z, p_z), _mm256_loadu_pd(&lamps.range_squared[i]));
            reaches = _mm256_and_pd(reaches, _mm256_or_pd(is_near, _mm256_cmp_pd(w, zero, _CMP_EQ_OQ)));
        }
        mask |= static_cast<std::uint64_t>(_mm256_movemask_pd(reaches)) << i;
    }
    return mask;
}

LIGHTMESH_AVX2 inline void start(Blend& blend, std::uint64_t lights) {
    const __m256i whole = _mm256_set1_epi32(one_weight);
    for (int o = 0; o < 8; ++o) {
        store(blend.found[static_cast<std::size_t>(o)], _mm256_setzero_si256());
        store(blend.left[static_cast<std::size_t>(o)], _mm256_and_si256(select(lights, o), whole));
    }
}

LIGHTMESH_AVX2 inline void give_to_first(Blend& blend, const CellValues& values, std::uint64_t lights) {
    for (std::uint32_t octets = octets_of(lights); octets != 0; octets &= octets - 1) {
        const int o = std::countr_zero(octets);
        const auto i = static_cast<std::size_t>(o);
        const __m256i rest = load(blend.left[i]);
        const __m256i given = _mm256_and_si256(select(lights, o), rest);
        const __m256i value = _mm256_slli_epi32(spread(values.octets[i][0]), 8);
        store(blend.found[i], _mm256_add_epi32(load(blend.found[i]), _mm256_mullo_epi32(given, value)));
        store(blend.left[i], _mm256_sub_epi32(rest, given));
    }
}

LIGHTMESH_AVX2 inline void store_octet(__m256 values, std::size_t first, std::span<float> lit) {
    if (lit.size() - first >= 8) {
        _mm256_storeu_ps(lit.data() + first, values);
        return;
    }
    alignas(32) float octet[8];
    _mm256_store_ps(octet, values);
    std::copy_n(octet, lit.size() - first, lit.data() + first);
}

LIGHTMESH_AVX2 inline void write_blend(const Blend& blend, std::span<float> lit) {
    const __m256 scale =
        _mm256_set1_ps(1.0f / (static_cast<float>(one_value) * static_cast<float>(one_weight)));
    for (std::size_t first = 0; first < lit.size(); first += 8)
        store_octet(_mm256_mul_ps(_mm256_cvtepi32_ps(load(blend.found[first / 8])), scale), first, lit);
}

LIGHTMESH_AVX2 inline void write_first(const CellValues& values, std::uint64_t lights, std::span<float> lit) {
    const __m256 scale = _mm256_set1_ps(256.0f / static_cast<float>(one_value));
    for (std::size_t first = 0; first < lit.size(); first += 8) {
        const auto o = static_cast<int>(first / 8);
        __m256i octet = _mm256_setzero_si256();
        if ((lights >> first & 255u) != 0)
            octet = _mm256_and_si256(select(lights, o), spread(values.octets[first / 8][0]));
        store_octet(_mm256_mul_ps(_mm256_cvtepi32_ps(octet), scale), first, lit);
    }
}

/// beta = smoothstep(.05, .3) of a spread, in parts of one_weight.
LIGHTMESH_AVX2 inline __m256i share_of_next(__m256i spread) {
    __m256i t = _mm256_sub_epi32(spread, _mm256_set1_epi32(spread_low));
    t = _mm256_max_epi32(t, _mm256_setzero_si256());
    t = _mm256_slli_epi32(_mm256_min_epi32(t, _mm256_set1_epi32(spread_range)), 1);
    const __m256i square = _mm256_srli_epi32(_mm256_mullo_epi32(t, t), 15);
    const __m256i rest = _mm256_sub_epi32(_mm256_set1_epi32(3 * one_weight), _mm256_slli_epi32(t, 1));
    return _mm256_srli_epi32(_mm256_mullo_epi32(square, rest), 15);
}

/// How much more a difference counts where values are dark, in parts of 256.
LIGHTMESH_AVX2 inline __m256i dark_factor(__m256i value) {
    const __m256i twice = _mm256_min_epi32(_mm256_slli_epi32(value, 1), _mm256_set1_epi32(one_value));
    return _mm256_sub_epi32(_mm256_set1_epi32(512), _mm256_srli_epi32(twice, 8));
}

/// All ones in the lanes that `mark_missed` marks.
LIGHTMESH_AVX2 inline __m256i is_missed(__m256i probe, __m256i least, __m256i greatest) {
    const __m256i zero = _mm256_setzero_si256();
    const __m256i whole = _mm256_set1_epi32(255);
    const __m256i dark = _mm256_and_si256(_mm256_cmpeq_epi32(probe, zero),
                                          _mm256_cmpgt_epi32(least, _mm256_set1_epi32(open_from)));
    const __m256i bright = _mm256_and_si256(_mm256_cmpeq_epi32(probe, whole),
                                            _mm256_cmpgt_epi32(_mm256_set1_epi32(closed_to), greatest));
    const __m256i both = _mm256_and_si256(
        _mm256_cmpeq_epi32(probe, _mm256_set1_epi32(probe_sees_both)),
        _mm256_or_si256(_mm256_cmpeq_epi32(least, whole), _mm256_cmpeq_epi32(greatest, zero)));
    return _mm256_or_si256(_mm256_or_si256(dark, bright), both);
}

LIGHTMESH_AVX2 inline std::uint64_t blend_level(Blend& blend, std::uint64_t lights, const BlendLevel& level) {
    std::uint64_t next = 0;
    for (std::uint32_t octets = octets_of(lights); octets != 0; octets &= octets - 1) {
        const int o = std::countr_zero(octets);
        const auto i = static_cast<std::size_t>(o);
        const std::uint64_t* const words = level.values->octets[i].data();
        const std::uint64_t first = words[level.records[0]];
        std::uint64_t differences = 0;
        for (std::size_t k = 1; k < level.taps; ++k)
            differences |= words[level.records[k]] ^ first;
        const __m256i found = load(blend.found[i]);
        const __m256i left = load(blend.left[i]);
        const std::uint64_t doubts =
            (level.window != 0 ? words[CellValues::centre] ^ first : 0) | (level.misses >> 8 * o & 255u);
        const bool is_served = level.missing == 0 || first == 0;
        if (differences == 0 && (level.is_last || (level.force == 0 && is_served && doubts == 0))) {
            const __m256i value = _mm256_slli_epi32(spread(first), 8);
            store(blend.found[i], _mm256_add_epi32(found, _mm256_mullo_epi32(left, value)));
            store(blend.left[i], _mm256_setzero_si256());
            continue;
        }
        __m256i value = _mm256_set1_epi32(64);
        __m256i least = _mm256_set1_epi32(255);
        __m256i greatest = _mm256_setzero_si256();
        for (std::size_t k = 0; k < level.taps; ++k) {
            const __m256i bytes = spread(words[level.records[k]]);
            const __m256i weight = _mm256_set1_epi32(static_cast<int>(level.weights[k]));
            value = _mm256_add_epi32(value, _mm256_mullo_epi32(bytes, weight));
            least = _mm256_min_epi32(least, bytes);
            greatest = _mm256_max_epi32(greatest, bytes);
        }
        value = _mm256_srli_epi32(value, 7);
        if (level.is_last) {
            store(blend.found[i], _mm256_add_epi32(found, _mm256_mullo_epi32(left, value)));
            store(blend.left[i], _mm256_setzero_si256());
            continue;
        }
        __m256i spread_most = _mm256_setzero_si256();
        for (std::size_t k = 0; k < level.taps; ++k) {
            const __m256i byte = _mm256_slli_epi32(spread(words[level.records[k]]), 8);
            const __m256i difference =
                _mm256_mullo_epi32(_mm256_abs_epi32(_mm256_sub_epi32(byte, value)),
                                   _mm256_set1_epi32(static_cast<int>(level.spread_weights[k])));
            spread_most = _mm256_max_epi32(spread_most, _mm256_srli_epi32(difference, 15));
        }
        __m256i beta =
            share_of_next(_mm256_srli_epi32(_mm256_mullo_epi32(spread_most, dark_factor(value)), 8));
        if (level.window != 0) {
            const __m256i missed = is_missed(spread(words[CellValues::centre]), least, greatest);
            const __m256i window = _mm256_set1_epi32(static_cast<int>(level.window));
            beta = _mm256_max_epi32(beta, _mm256_and_si256(missed, window));
        }
        for (std::size_t k = 0; k < level.taps && (level.misses >> 8 * o & 255u) != 0; ++k)
            if (level.records[k] < CellValues::first_in_air) {
                const __m256i missed = select(level.values->misses[level.records[k]], o);
                const __m256i weight = _mm256_set1_epi32(static_cast<int>(level.miss_weights[k]));
                beta = _mm256_max_epi32(beta, _mm256_and_si256(missed, weight));
            }
        const __m256i is_dark = _mm256_cmpeq_epi32(greatest, _mm256_setzero_si256());
        const __m256i missing = _mm256_set1_epi32(static_cast<int>(level.missing));
        beta = _mm256_max_epi32(beta, _mm256_andnot_si256(is_dark, missing));
        beta = _mm256_max_epi32(beta, _mm256_set1_epi32(static_cast<int>(level.force)));
        const __m256i fade = _mm256_set1_epi32(static_cast<int>(level.fade >> 1));
        beta = _mm256_srli_epi32(_mm256_mullo_epi32(beta, fade), 14);
        __m256i rest = _mm256_srli_epi32(_mm256_mullo_epi32(left, beta), 15);
        const __m256i is_left = _mm256_cmpgt_epi32(rest, _mm256_set1_epi32(63));
        rest = _mm256_and_si256(rest, is_left);
        const __m256i given = _mm256_sub_epi32(left, rest);
        store(blend.found[i], _mm256_add_epi32(found, _mm256_mullo_epi32(given, value)));
        store(blend.left[i], rest);
        const auto more = static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(is_left)));
        next |= static_cast<std::uint64_t>(more) << 8 * o;
    }
    return next & lights;
}

}  // namespace lightmesh::detail::avx2_cache

#endif
