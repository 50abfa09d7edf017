// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/blend.hpp>
#include <lightmesh/cache/cell_values.hpp>
#include <lightmesh/cache/lamp_columns.hpp>
#include <lightmesh/cache/lanes.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/taps.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

/// The functions of `CacheKernels`, eight lights at a time, by vector types that the compiler makes any
/// processor's code of.

namespace lightmesh::detail::portable_cache {

inline void load_half(const std::array<double, lamps_per_tile>& column, std::size_t i, DoubleLanes& lanes) {
    std::memcpy(&lanes, column.data() + i, sizeof lanes);
}

/// Of values rounded to float: then squares are exact.
inline void add_square(const DoubleLanes& values, DoubleLanes& sum) {
    using Floats [[gnu::vector_size(16)]] = float;
    const DoubleLanes rounded = __builtin_convertvector(__builtin_convertvector(values, Floats), DoubleLanes);
    sum += rounded * rounded;
}

inline std::uint64_t find_reaching(const LampColumns& lamps, std::size_t size, const glm::vec3& point,
                                   const glm::vec3& normal) {
    using Flags [[gnu::vector_size(4)]] = std::uint8_t;
    const glm::dvec3 n(normal);
    const glm::dvec3 p(point);
    const double height = n.x * p.x + n.y * p.y + n.z * p.z;
    std::uint64_t mask = 0;
    for (std::size_t first = 0; first < size; first += 8) {
        std::uint32_t flags[2];
        for (std::size_t half = 0; half < 2; ++half) {
            const std::size_t i = first + 4 * half;
            DoubleLanes x, y, z, w;
            load_half(lamps.at_x, i, x);
            load_half(lamps.at_y, i, y);
            load_half(lamps.at_z, i, z);
            load_half(lamps.w, i, w);
            auto reaches = n.x * x + n.y * y + n.z * z - w * height >= 0.0;
            if (lamps.has_ranges) {
                DoubleLanes range_squared;
                load_half(lamps.range_squared, i, range_squared);
                DoubleLanes distance_squared{};
                add_square(x - p.x, distance_squared);
                add_square(y - p.y, distance_squared);
                add_square(z - p.z, distance_squared);
                reaches &= (distance_squared <= range_squared) | (w == 0.0);
            }
            const Flags bytes = __builtin_convertvector(reaches, Flags);
            std::memcpy(&flags[half], &bytes, sizeof bytes);
        }
        mask |= gather_low_bits(flags[0] | static_cast<std::uint64_t>(flags[1]) << 32) << first;
    }
    return mask;
}

/// All ones in the lanes of an octet's lights.
inline void select_lights(std::uint64_t lights, int o, SignedLanes& selected) {
    const Lanes bit{1, 2, 4, 8, 16, 32, 64, 128};
    const Lanes octet = Lanes{} + static_cast<std::uint32_t>(lights >> 8 * o & 255u);
    selected = (octet & bit) != 0;
}

inline void start(Blend& blend, std::uint64_t lights) {
    const Lanes zero{};
    for (int o = 0; o < 8; ++o) {
        SignedLanes selected;
        select_lights(lights, o, selected);
        blend.found[static_cast<std::size_t>(o)] = zero;
        blend.left[static_cast<std::size_t>(o)] =
            selected ? zero + static_cast<std::uint32_t>(one_weight) : zero;
    }
}

inline void give_to_first(Blend& blend, const CellValues& values, std::uint64_t lights) {
    for (std::uint32_t octets = octets_of(lights); octets != 0; octets &= octets - 1) {
        const int o = std::countr_zero(octets);
        SignedLanes selected;
        select_lights(lights, o, selected);
        Lanes& rest = blend.left[static_cast<std::size_t>(o)];
        const Lanes given = selected ? rest : Lanes{};
        Lanes bytes;
        spread_bytes(values.octet(0, static_cast<std::size_t>(o)), bytes);
        blend.found[static_cast<std::size_t>(o)] += given * (bytes << 8);
        rest -= given;
    }
}

/// Stores an octet's values; of the last one only as many as there are lights.
inline void store_octet(const FloatLanes& values, std::size_t first, std::span<float> lit) {
    if (lit.size() - first >= 8) {
        std::memcpy(lit.data() + first, &values, sizeof values);
        return;
    }
    for (std::size_t l = 0; first + l < lit.size(); ++l)
        lit[first + l] = values[l];
}

inline void write_blend(const Blend& blend, std::span<float> lit) {
    constexpr float scale = 1.0f / (static_cast<float>(one_value) * static_cast<float>(one_weight));
    for (std::size_t first = 0; first < lit.size(); first += 8) {
        // Below 2^31, so that signed numbers, which are faster, do.
        const auto found = __builtin_convertvector(blend.found[first / 8], SignedLanes);
        store_octet(__builtin_convertvector(found, FloatLanes) * scale, first, lit);
    }
}

inline void write_first(const CellValues& cell, std::uint64_t lights, std::span<float> lit) {
    constexpr float scale = 256.0f / static_cast<float>(one_value);
    for (std::size_t first = 0; first < lit.size(); first += 8) {
        FloatLanes values{};
        if (const auto o = static_cast<int>(first / 8); (lights >> 8 * o & 255u) != 0) {
            Lanes bytes;
            spread_bytes(cell.octet(0, static_cast<std::size_t>(o)), bytes);
            SignedLanes selected;
            select_lights(lights, o, selected);
            const SignedLanes chosen = selected & __builtin_convertvector(bytes, SignedLanes);
            values = __builtin_convertvector(chosen, FloatLanes) * scale;
        }
        store_octet(values, first, lit);
    }
}

inline std::uint64_t blend_level(Blend& blend, std::uint64_t lights, const BlendLevel& level) {
    std::uint64_t next = 0;
    for (std::uint32_t octets = octets_of(lights); octets != 0; octets &= octets - 1) {
        const int o = std::countr_zero(octets);
        Lanes& found = blend.found[static_cast<std::size_t>(o)];
        Lanes& left = blend.left[static_cast<std::size_t>(o)];
        const auto word = [&](std::size_t record) {
            return level.values->octet(record, static_cast<std::size_t>(o));
        };
        const std::uint64_t first = word(level.records[0]);
        std::uint64_t differences = 0;
        for (std::size_t k = 1; k < level.taps; ++k)
            differences |= word(level.records[k]) ^ first;
        const std::uint64_t doubts =
            (level.window != 0 ? word(CellValues::centre) ^ first : 0) | (level.misses >> 8 * o & 255u);
        const bool is_served = level.missing == 0 || first == 0;
        if (differences == 0 && (level.is_last || (level.force == 0 && is_served && doubts == 0))) {
            Lanes bytes;
            spread_bytes(first, bytes);
            found += left * (bytes << 8);
            left = Lanes{};
            continue;
        }
        Lanes value{};
        Lanes least = Lanes{} + 255u;
        Lanes greatest{};
        for (std::size_t k = 0; k < level.taps; ++k) {
            Lanes bytes;
            spread_bytes(word(level.records[k]), bytes);
            value += level.weights[k] * bytes;
            least = least < bytes ? least : bytes;
            keep_greater(greatest, bytes);
        }
        value = (value + 64u) >> 7;
        if (level.is_last) {
            found += left * value;
            left = Lanes{};
            continue;
        }
        Lanes spread{};
        for (std::size_t k = 0; k < level.taps; ++k) {
            Lanes bytes;
            spread_bytes(word(level.records[k]), bytes);
            bytes <<= 8;
            keep_greater(spread,
                         (bytes > value ? bytes - value : value - bytes) * level.spread_weight(k) >> 15);
        }
        const Lanes twice = 2 * value < one_value ? 2 * value : Lanes{} + one_value;
        spread = spread * (512u - (twice >> 8)) >> 8;
        Lanes t = spread > level.spread_low ? spread - level.spread_low : Lanes{};
        t = 2 * (t < spread_range ? t : Lanes{} + spread_range);
        Lanes beta = (t * t >> 15) * (3u * one_weight - 2 * t) >> 15;
        if (level.window != 0) {
            Lanes probe;
            spread_bytes(word(CellValues::centre), probe);
            Lanes missed{};
            mark_missed(missed, probe, least, greatest);
            keep_greater(beta, missed * level.window);
        }
        for (std::size_t k = 0; k < level.taps && (level.misses >> 8 * o & 255u) != 0; ++k)
            if (level.records[k] < CellValues::first_in_air) {
                SignedLanes missed;
                select_lights(level.values->misses[level.records[k]], o, missed);
                keep_greater(beta, missed ? Lanes{} + level.miss_weight(k) : Lanes{});
            }
        keep_greater(beta, greatest > 0u ? Lanes{} + level.missing : Lanes{});
        keep_greater(beta, Lanes{} + level.force);
        beta = beta * (level.fade >> 1) >> 14;
        Lanes rest = left * beta >> 15;
        rest = rest < 64u ? Lanes{} : rest;
        found += (left - rest) * value;
        left = rest;
        next |= mask_of(rest) << 8 * o;
    }
    return next & lights;
}

}  // namespace lightmesh::detail::portable_cache
