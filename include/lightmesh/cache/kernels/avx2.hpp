// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/blend.hpp>
#include <lightmesh/cache/cell_values.hpp>
#include <lightmesh/cache/lamp_columns.hpp>
#include <lightmesh/cache/lanes.hpp>
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

/// True if four values, after rounding to float, lie nearer than the square root of `range_squared`.
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
        const __m256i value = _mm256_slli_epi32(spread(values.rows[0].octets[i]), 8);
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
            octet = _mm256_and_si256(select(lights, o), spread(values.rows[0].octets[first / 8]));
        store_octet(_mm256_mul_ps(_mm256_cvtepi32_ps(octet), scale), first, lit);
    }
}

/// The bytes of two octets of a row.
LIGHTMESH_AVX2 inline __m128i load_pair(const RowBytes& row, std::size_t octet) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(&row.octets[octet]));
}

/// Sixteen numbers of 16 bits from twice eight of 32, none of them greater than 65535.
LIGHTMESH_AVX2 inline __m256i join(__m256i lower, __m256i upper) {
    return _mm256_permute4x64_epi64(_mm256_packus_epi32(lower, upper), 0xd8);
}
/// Eight of sixteen numbers, at 32 bits.
LIGHTMESH_AVX2 inline __m256i lower_half(__m256i numbers) {
    return _mm256_cvtepu16_epi32(_mm256_castsi256_si128(numbers));
}
LIGHTMESH_AVX2 inline __m256i upper_half(__m256i numbers) {
    return _mm256_cvtepu16_epi32(_mm256_extracti128_si256(numbers, 1));
}

LIGHTMESH_AVX2 inline __m256i repeat(std::uint32_t number) {
    return _mm256_set1_epi16(static_cast<short>(number));
}

/// For numbers * share / one_weight, rounded down, of shares up to one_weight.
struct Shares {
    __m256i doubled;   ///< 0 for one_weight, for which there is no room
    __m256i is_whole;  ///< all ones for one_weight
};

LIGHTMESH_AVX2 inline Shares shares_of(__m256i shares) {
    return {_mm256_add_epi16(shares, shares), _mm256_cmpeq_epi16(shares, repeat(one_weight))};
}
LIGHTMESH_AVX2 inline __m256i share_of(__m256i numbers, const Shares& shares) {
    return _mm256_or_si256(_mm256_mulhi_epu16(numbers, shares.doubled),
                           _mm256_and_si256(numbers, shares.is_whole));
}

/// beta = smoothstep(low, low + .25) of a spread, in parts of one_weight.
LIGHTMESH_AVX2 inline __m256i share_of_next(__m256i spread, std::uint32_t low) {
    __m256i t = _mm256_min_epu16(_mm256_subs_epu16(spread, repeat(low)), repeat(spread_range));
    t = _mm256_add_epi16(t, t);
    const __m256i square = share_of(t, shares_of(t));
    // Half of 3 - 2 t; of the product 18 bits are more than there are.
    const __m256i rest = _mm256_sub_epi16(repeat(3 * one_weight / 2), t);
    return _mm256_or_si256(_mm256_slli_epi16(_mm256_mulhi_epu16(square, rest), 2),
                           _mm256_srli_epi16(_mm256_mullo_epi16(square, rest), 14));
}

/// A spread and as much more as it counts where values are dark; what is far beyond spread_range may be less.
LIGHTMESH_AVX2 inline __m256i spread_seen(__m256i spread, __m256i value) {
    const __m256i twice = _mm256_min_epu16(_mm256_adds_epu16(value, value), repeat(one_value));
    const __m256i more = _mm256_sub_epi16(repeat(256), _mm256_srli_epi16(twice, 8));
    return _mm256_adds_epu16(spread, share_of(spread, shares_of(_mm256_slli_epi16(more, 7))));
}

/// All ones in the bytes that `mark_missed` marks.
LIGHTMESH_AVX2 inline __m128i is_missed(__m128i probe, __m128i least, __m128i greatest) {
    const __m128i zero = _mm_setzero_si128();
    const __m128i whole = _mm_set1_epi8(-1);
    const __m128i is_open =
        _mm_cmpeq_epi8(_mm_max_epu8(least, _mm_set1_epi8(static_cast<char>(open_from + 1))), least);
    const __m128i is_closed = _mm_cmpeq_epi8(_mm_min_epu8(greatest, _mm_set1_epi8(closed_to - 1)), greatest);
    const __m128i dark = _mm_and_si128(_mm_cmpeq_epi8(probe, zero), is_open);
    const __m128i bright = _mm_and_si128(_mm_cmpeq_epi8(probe, whole), is_closed);
    const __m128i both =
        _mm_and_si128(_mm_cmpeq_epi8(probe, _mm_set1_epi8(probe_sees_both)),
                      _mm_or_si128(_mm_cmpeq_epi8(least, whole), _mm_cmpeq_epi8(greatest, zero)));
    return _mm_or_si128(_mm_or_si128(dark, bright), both);
}

/// Of sixteen lights, those of which the bytes are all ones.
LIGHTMESH_AVX2 inline __m128i bytes_of_pair(std::uint64_t lights) {
    const __m128i bits = _mm_set1_epi64x(static_cast<long long>(0x8040201008040201u));
    const __m128i octets = _mm_shuffle_epi8(_mm_cvtsi64_si128(static_cast<long long>(lights)),
                                            _mm_setr_epi8(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1));
    return _mm_cmpeq_epi8(_mm_and_si128(octets, bits), bits);
}

/// A share for those of sixteen lights of which the bytes are all ones.
LIGHTMESH_AVX2 inline __m256i share_where(__m128i bytes, std::uint32_t share) {
    return _mm256_and_si256(_mm256_cvtepi8_epi16(bytes), repeat(share));
}

/// Adds a share of one_weight of values to what two octets have found.
LIGHTMESH_AVX2 inline void give(Lanes* found, __m256i lower_share, __m256i lower_value, __m256i upper_share,
                                __m256i upper_value) {
    store(found[0], _mm256_add_epi32(load(found[0]), _mm256_mullo_epi32(lower_share, lower_value)));
    store(found[1], _mm256_add_epi32(load(found[1]), _mm256_mullo_epi32(upper_share, upper_value)));
}

/// A level's records with what does not depend on the lights.
template <std::size_t count>
struct Taps {
    const RowBytes* rows[count];
    __m256i weights[count / 2];  ///< of two records each, negative: one_weight fits 16 bits with that sign
    Shares spread_shares[count];
};

template <std::size_t count>
LIGHTMESH_AVX2 inline void set_taps(Taps<count>& taps, const BlendLevel& level) {
    for (std::size_t k = 0; k < count; ++k)
        taps.rows[k] = &level.values->rows[level.records[k]];
    for (std::size_t k = 0; k < count; k += 4) {
        const __m128i weights = _mm_loadu_si128(reinterpret_cast<const __m128i*>(&level.weights[k]));
        // Two of 16 bits each, side by side.
        const __m128i negative =
            _mm_shuffle_epi8(_mm_sub_epi32(_mm_setzero_si128(), weights),
                             _mm_setr_epi8(0, 1, 4, 5, 8, 9, 12, 13, 0, 1, 4, 5, 8, 9, 12, 13));
        taps.weights[k / 2] = _mm256_broadcastd_epi32(negative);
        taps.weights[k / 2 + 1] = _mm256_broadcastd_epi32(_mm_srli_epi64(negative, 32));
        const __m128i spread = _mm_min_epu32(_mm_slli_epi32(weights, 2), _mm_set1_epi32(one_weight));
        taps.spread_shares[k] = shares_of(_mm256_broadcastw_epi16(spread));
        taps.spread_shares[k + 1] = shares_of(_mm256_broadcastw_epi16(_mm_srli_si128(spread, 4)));
        taps.spread_shares[k + 2] = shares_of(_mm256_broadcastw_epi16(_mm_srli_si128(spread, 8)));
        taps.spread_shares[k + 3] = shares_of(_mm256_broadcastw_epi16(_mm_srli_si128(spread, 12)));
    }
}

/// Two octets at a time, at 16 bits but for what is found.
template <std::size_t count>
LIGHTMESH_AVX2 inline std::uint64_t blend_taps(Blend& blend, std::uint64_t lights, const BlendLevel& level) {
    Taps<count> taps;
    set_taps(taps, level);
    const bool has_probe = level.window != 0 && !level.is_last;
    const __m256i zero = _mm256_setzero_si256();
    std::uint64_t next = 0;
    for (std::uint64_t rest_of_lights = lights; rest_of_lights != 0;) {
        const int shift = std::countr_zero(rest_of_lights) & ~15;
        const __m128i selected = bytes_of_pair(rest_of_lights >> shift & 0xffffu);
        rest_of_lights &= ~(std::uint64_t{0xffffu} << shift);
        const auto octet = static_cast<std::size_t>(shift) / 8;
        Lanes* const found = &blend.found[octet];
        Lanes* const left = &blend.left[octet];
        const __m256i lower_left = load(left[0]);
        const __m256i upper_left = load(left[1]);
        __m128i bytes[count];
        bytes[0] = load_pair(*taps.rows[0], octet);
        __m128i differences = _mm_setzero_si128();
        for (std::size_t k = 1; k < count; ++k) {
            bytes[k] = load_pair(*taps.rows[k], octet);
            differences = _mm_or_si128(differences, _mm_xor_si128(bytes[k], bytes[0]));
        }
        __m128i probe = bytes[0];
        if (has_probe) {
            probe = load_pair(level.values->rows[CellValues::centre], octet);
            differences = _mm_or_si128(differences, _mm_xor_si128(probe, bytes[0]));
        }
        if (!level.is_last && level.missing != 0)
            differences = _mm_or_si128(differences, bytes[0]);
        const bool has_misses = (level.misses >> shift & 0xffffu) != 0;
        if ((level.is_last || (level.force == 0 && !has_misses)) &&
            _mm_testz_si128(differences, selected) != 0) {
            const __m128i upper = _mm_unpackhi_epi64(bytes[0], bytes[0]);
            give(found, lower_left, _mm256_slli_epi32(_mm256_cvtepu8_epi32(bytes[0]), 8), upper_left,
                 _mm256_slli_epi32(_mm256_cvtepu8_epi32(upper), 8));
            store(left[0], zero);
            store(left[1], zero);
            continue;
        }
        // Less 64, as weights are negative.
        __m256i lower_sum = _mm256_set1_epi32(-64);
        __m256i upper_sum = lower_sum;
        for (std::size_t k = 0; k < count; k += 2) {
            const __m256i lower = _mm256_cvtepu8_epi16(_mm_unpacklo_epi8(bytes[k], bytes[k + 1]));
            const __m256i upper = _mm256_cvtepu8_epi16(_mm_unpackhi_epi8(bytes[k], bytes[k + 1]));
            lower_sum = _mm256_add_epi32(lower_sum, _mm256_madd_epi16(lower, taps.weights[k / 2]));
            upper_sum = _mm256_add_epi32(upper_sum, _mm256_madd_epi16(upper, taps.weights[k / 2]));
        }
        const __m256i lower_value = _mm256_srli_epi32(_mm256_sub_epi32(zero, lower_sum), 7);
        const __m256i upper_value = _mm256_srli_epi32(_mm256_sub_epi32(zero, upper_sum), 7);
        if (level.is_last) {
            give(found, lower_left, lower_value, upper_left, upper_value);
            store(left[0], zero);
            store(left[1], zero);
            continue;
        }
        const __m256i value = join(lower_value, upper_value);
        __m256i spread = zero;
        __m128i least = bytes[0];
        __m128i greatest = bytes[0];
        for (std::size_t k = 0; k < count; ++k) {
            const __m256i byte = _mm256_slli_epi16(_mm256_cvtepu8_epi16(bytes[k]), 8);
            const __m256i difference =
                _mm256_or_si256(_mm256_subs_epu16(byte, value), _mm256_subs_epu16(value, byte));
            spread = _mm256_max_epu16(spread, share_of(difference, taps.spread_shares[k]));
            least = _mm_min_epu8(least, bytes[k]);
            greatest = _mm_max_epu8(greatest, bytes[k]);
        }
        __m256i beta = share_of_next(spread_seen(spread, value), level.spread_low);
        if (has_probe)
            beta = _mm256_max_epu16(beta, share_where(is_missed(probe, least, greatest), level.window));
        for (std::size_t k = 0; k < level.taps && has_misses; ++k)
            if (level.records[k] < CellValues::first_in_air) {
                const __m128i missed =
                    bytes_of_pair(level.values->misses[level.records[k]] >> shift & 0xffffu);
                beta = _mm256_max_epu16(beta, share_where(missed, level.miss_weight(k)));
            }
        const __m256i is_dark = _mm256_cvtepi8_epi16(_mm_cmpeq_epi8(greatest, _mm_setzero_si128()));
        beta = _mm256_max_epu16(beta, _mm256_andnot_si256(is_dark, repeat(level.missing)));
        beta = _mm256_max_epu16(beta, repeat(level.force));
        beta = share_of(beta, shares_of(repeat(level.fade & ~1u)));
        const __m256i all_left = join(lower_left, upper_left);
        __m256i rest = share_of(all_left, shares_of(beta));
        const __m256i is_done = _mm256_cmpeq_epi16(_mm256_subs_epu16(rest, repeat(63)), zero);
        rest = _mm256_andnot_si256(is_done, rest);
        const __m256i given = _mm256_sub_epi16(all_left, rest);
        give(found, lower_half(given), lower_value, upper_half(given), upper_value);
        store(left[0], lower_half(rest));
        store(left[1], upper_half(rest));
        const __m256i side_by_side = _mm256_permute4x64_epi64(_mm256_packs_epi16(is_done, zero), 0x08);
        const auto done = static_cast<std::uint32_t>(_mm256_movemask_epi8(side_by_side));
        next |= static_cast<std::uint64_t>(~done & 0xffffu) << shift;
    }
    return next & lights;
}

/// The bits that all four lanes say together, in each of them.
LIGHTMESH_AVX2 inline __m128i sum_of_four(__m128i lanes) {
    lanes = _mm_add_epi32(lanes, _mm_shuffle_epi32(lanes, 0x4e));
    return _mm_add_epi32(lanes, _mm_shuffle_epi32(lanes, 0xb1));
}
LIGHTMESH_AVX2 inline __m128i greatest_of_four(__m128i lanes) {
    lanes = _mm_max_epu32(lanes, _mm_shuffle_epi32(lanes, 0x4e));
    return _mm_max_epu32(lanes, _mm_shuffle_epi32(lanes, 0xb1));
}
LIGHTMESH_AVX2 inline __m128i least_of_four(__m128i lanes) {
    lanes = _mm_min_epu32(lanes, _mm_shuffle_epi32(lanes, 0x4e));
    return _mm_min_epu32(lanes, _mm_shuffle_epi32(lanes, 0xb1));
}

LIGHTMESH_AVX2 inline std::uint32_t first_of(__m128i lanes) {
    return static_cast<std::uint32_t>(_mm_cvtsi128_si32(lanes));
}

LIGHTMESH_AVX2 inline int byte_at(const BlendLevel& level, std::size_t record, std::size_t light) {
    return static_cast<int>(level.values->rows[record].byte(light));
}

/// One light at four records, which lie side by side. Returns whether the next level has to say something.
LIGHTMESH_AVX2 inline bool blend_light(Blend& blend, std::size_t light, const BlendLevel& level) {
    const __m128i weights = _mm_loadu_si128(reinterpret_cast<const __m128i*>(level.weights.data()));
    const __m128i bytes =
        _mm_setr_epi32(byte_at(level, level.records[0], light), byte_at(level, level.records[1], light),
                       byte_at(level, level.records[2], light), byte_at(level, level.records[3], light));
    const __m128i sum = sum_of_four(_mm_mullo_epi32(bytes, weights));
    const __m128i values = _mm_srli_epi32(_mm_add_epi32(sum, _mm_set1_epi32(64)), 7);
    const std::uint32_t value = first_of(values);
    std::uint32_t& found = reinterpret_cast<std::uint32_t*>(&blend.found[light / 8])[light % 8];
    std::uint32_t& left = reinterpret_cast<std::uint32_t*>(&blend.left[light / 8])[light % 8];
    if (level.is_last) {
        found += left * value;
        left = 0;
        return false;
    }
    const __m128i differences = _mm_abs_epi32(_mm_sub_epi32(_mm_slli_epi32(bytes, 8), values));
    const __m128i spread_weights = _mm_min_epu32(_mm_slli_epi32(weights, 2), _mm_set1_epi32(one_weight));
    std::uint32_t spread =
        first_of(greatest_of_four(_mm_srli_epi32(_mm_mullo_epi32(differences, spread_weights), 15)));
    spread = spread * (512u - ((std::min)(2 * value, one_value) >> 8)) >> 8;
    const std::uint32_t t = 2 * (std::min)(spread - (std::min)(spread, level.spread_low), spread_range);
    std::uint32_t beta = (t * t >> 15) * (3u * one_weight - 2 * t) >> 15;
    const std::uint32_t greatest = first_of(greatest_of_four(bytes));
    if (level.window != 0 &&
        is_light_missed(static_cast<std::uint32_t>(byte_at(level, CellValues::centre, light)),
                        first_of(least_of_four(bytes)), greatest))
        beta = (std::max)(beta, level.window);
    for (std::size_t k = 0; k < level.taps && (level.misses >> light & 1u) != 0; ++k)
        if (level.records[k] < CellValues::first_in_air &&
            (level.values->misses[level.records[k]] >> light & 1u) != 0)
            beta = (std::max)(beta, level.miss_weight(k));
    beta = (std::max)(beta, greatest != 0 ? level.missing : 0u);
    beta = (std::max)(beta, level.force) * (level.fade >> 1) >> 14;
    std::uint32_t rest = left * beta >> 15;
    if (rest < 64)
        rest = 0;
    found += (left - rest) * value;
    left = rest;
    return rest != 0;
}

/// So many lights are blended faster one by one.
inline constexpr int few_lights = 2;

LIGHTMESH_AVX2 inline std::uint64_t blend_level(Blend& blend, std::uint64_t lights, const BlendLevel& level) {
    if (level.taps <= 4 && std::popcount(lights) <= few_lights) {
        std::uint64_t next = 0;
        for (std::uint64_t rest = lights; rest != 0; rest &= rest - 1)
            if (blend_light(blend, static_cast<std::size_t>(std::countr_zero(rest)), level))
                next |= rest & (~rest + 1u);
        return next;
    }
    return level.taps <= 4 ? blend_taps<4>(blend, lights, level) : blend_taps<8>(blend, lights, level);
}

}  // namespace lightmesh::detail::avx2_cache

#endif
