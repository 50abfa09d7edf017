// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/lanes.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/taps.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// Blended values are integers of 16 bits: 256 for each of a byte's steps.
inline constexpr std::uint32_t one_value = 255u * 256u;

/// The visibilities of a tile of lights on their way from level to level: for each light what is found, and
/// how much of one_weight is left for finer levels.
struct Blend {
    std::array<Lanes, 8> found;
    std::array<Lanes, 8> left;

    /// Gives what is left of some lights' weights to the values of a row.
    void add(const TileRow& row, std::uint64_t lights) {
        const Lanes bit{1, 2, 4, 8, 16, 32, 64, 128};
        for (std::uint32_t octets = octets_of(lights); octets != 0; octets &= octets - 1) {
            const int o = std::countr_zero(octets);
            const Lanes octet = Lanes{} + static_cast<std::uint32_t>(lights >> 8 * o & 255u);
            Lanes& rest = left[static_cast<std::size_t>(o)];
            const Lanes given = (octet & bit) != 0 ? rest : Lanes{};
            Lanes bytes;
            spread_bytes(row.octet(o), bytes);
            found[static_cast<std::size_t>(o)] += given * (bytes << 8);
            rest -= given;
        }
    }

    /// With all of the weight left for some lights, and none for others.
    void start(std::uint64_t lights) {
        const Lanes bit{1, 2, 4, 8, 16, 32, 64, 128};
        for (std::size_t o = 0; o < 8; ++o) {
            const Lanes zero{};
            const Lanes octet = zero + static_cast<std::uint32_t>(lights >> 8 * o & 255u);
            found[o] = zero;
            left[o] = (octet & bit) != 0 ? zero + static_cast<std::uint32_t>(one_weight) : zero;
        }
    }
};

/// The rows that one level offers, with weights that sum to one_weight, and what makes it give way to the
/// next level.
struct BlendLevel {
    std::size_t taps = 0;
    std::array<const TileRow*, 8> rows;
    std::array<std::uint32_t, 8> weights;
    std::uint32_t force = 0;  ///< least share of the next level, of one_weight
    std::uint32_t fade = static_cast<std::uint32_t>(one_weight);  ///< greatest share of the next level
    bool is_last = false;
    const TileRow* probe = nullptr;
    std::uint32_t window = 0;  ///< weight of the probe
};

/// Marks the lights of which the centre of a cell says the contrary of what its four records say.
inline void mark_missed(Lanes& marks, const Lanes& centre, const Lanes& least, const Lanes& greatest) {
    marks |=
        ((centre == 0) & (least > 153u)) | ((centre == 255u) & (greatest < 102u)) ? Lanes{} + 1u : Lanes{};
}

/// Adds a level: S = lerp(S of this level, S of the next, beta) with beta = smoothstep(.1, .35) of the
/// greatest weighted difference between one row and their blend. Returns the lights that the next level has
/// to say something about.
inline std::uint64_t blend_level(Blend& blend, std::uint64_t lights, const BlendLevel& level) {
    constexpr std::uint32_t low = 6528;     // .1 of one_value
    constexpr std::uint32_t range = 16384;  // .25
    std::uint64_t next = 0;
    for (std::uint32_t octets = octets_of(lights); octets != 0; octets &= octets - 1) {
        const int o = std::countr_zero(octets);
        Lanes& found = blend.found[static_cast<std::size_t>(o)];
        Lanes& left = blend.left[static_cast<std::size_t>(o)];
        std::array<std::uint64_t, 8> words{};
        std::uint64_t differences = 0;
        for (std::size_t k = 0; k < level.taps; ++k) {
            words[k] = level.rows[k]->octet(o);
            differences |= words[k] ^ words[0];
        }
        const std::uint64_t probed = level.probe != nullptr ? level.probe->octet(o) : words[0];
        if (differences == 0 && (level.is_last || (level.force == 0 && probed == words[0]))) {
            Lanes bytes;
            spread_bytes(words[0], bytes);
            found += left * (bytes << 8);
            left = Lanes{};
            continue;
        }
        Lanes value{};
        Lanes least = Lanes{} + 255u;
        Lanes greatest{};
        std::array<Lanes, 8> bytes;
        for (std::size_t k = 0; k < level.taps; ++k) {
            spread_bytes(words[k], bytes[k]);
            value += level.weights[k] * bytes[k];
            least = least < bytes[k] ? least : bytes[k];
            keep_greater(greatest, bytes[k]);
        }
        value = (value + 64u) >> 7;
        if (level.is_last) {
            found += left * value;
            left = Lanes{};
            continue;
        }
        Lanes spread{};
        for (std::size_t k = 0; k < level.taps; ++k) {
            const std::uint32_t weight =
                (std::min)(4 * level.weights[k], static_cast<std::uint32_t>(one_weight));
            const Lanes byte = bytes[k] << 8;
            keep_greater(spread, (byte > value ? byte - value : value - byte) * weight >> 15);
        }
        Lanes t = spread > low ? spread - low : Lanes{};
        t = 2 * (t < range ? t : Lanes{} + range);
        Lanes beta = (t * t >> 15) * (3u * one_weight - 2 * t) >> 15;
        if (level.probe != nullptr) {
            Lanes probe;
            spread_bytes(probed, probe);
            Lanes missed{};
            mark_missed(missed, probe, least, greatest);
            keep_greater(beta, missed * level.window);
        }
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

}  // namespace lightmesh::detail
