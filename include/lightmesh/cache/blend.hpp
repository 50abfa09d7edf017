// SPDX-License-Identifier: MIT
#pragma once

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
    alignas(32) std::array<std::uint32_t, lamps_per_tile> found;
    alignas(32) std::array<std::uint32_t, lamps_per_tile> left;

    void start(std::uint64_t lights) {
        for (std::size_t l = 0; l < lamps_per_tile; ++l) {
            found[l] = 0;
            left[l] = (lights >> l & 1u) != 0 ? static_cast<std::uint32_t>(one_weight) : 0u;
        }
    }
};

/// The rows that one level offers, with weights that sum to one_weight, and what makes it give way to the
/// next level.
struct BlendLevel {
    std::size_t taps = 0;
    std::array<TileRow, 8> rows;
    std::array<std::uint32_t, 8> weights;
    std::uint32_t force = 0;  ///< least share of the next level, of one_weight
    std::uint32_t fade = static_cast<std::uint32_t>(one_weight);  ///< greatest share of the next level
    bool is_last = false;
    const TileRow* probe = nullptr;
    std::uint32_t window = 0;  ///< weight of the probe
};

/// Adds a level: S = lerp(S of this level, S of the next, beta) with beta = smoothstep(.15, .4) of the
/// greatest weighted difference between one row and their blend. Returns the lights that the next level has to
/// say something about.
inline std::uint64_t blend_level(Blend& blend, std::uint64_t lights, const BlendLevel& level) {
    constexpr std::uint32_t low = 9792;     // .15 of one_value
    constexpr std::uint32_t range = 16384;  // .25
    std::uint64_t next = 0;
    for (std::uint32_t octets = octets_of(lights); octets != 0; octets &= octets - 1) {
        const int o = std::countr_zero(octets);
        std::uint32_t* found = blend.found.data() + 8 * o;
        std::uint32_t* left = blend.left.data() + 8 * o;
        std::array<std::uint64_t, 8> words;
        std::uint64_t differences = 0;
        for (std::size_t k = 0; k < level.taps; ++k) {
            words[k] = level.rows[k].octet(o);
            differences |= words[k] ^ words[0];
        }
        if (level.is_last || (differences == 0 && level.force == 0 && level.probe == nullptr)) {
            std::array<std::uint32_t, 8> sum{};
            for (std::size_t k = 0; k < level.taps; ++k)
                for (std::size_t b = 0; b < 8; ++b)
                    sum[b] += level.weights[k] * static_cast<std::uint32_t>(words[k] >> 8 * b & 255u);
            for (std::size_t b = 0; b < 8; ++b) {
                found[b] += left[b] * ((sum[b] + 64) >> 7);
                left[b] = 0;
            }
            continue;
        }
        std::array<std::uint32_t, 8> value{};
        std::array<std::uint32_t, 8> least;
        std::array<std::uint32_t, 8> greatest{};
        least.fill(255);
        for (std::size_t k = 0; k < level.taps; ++k)
            for (std::size_t b = 0; b < 8; ++b) {
                const auto byte = static_cast<std::uint32_t>(words[k] >> 8 * b & 255u);
                value[b] += level.weights[k] * byte;
                least[b] = (std::min)(least[b], byte);
                greatest[b] = (std::max)(greatest[b], byte);
            }
        std::array<std::uint32_t, 8> spread{};
        for (std::size_t b = 0; b < 8; ++b)
            value[b] = (value[b] + 64) >> 7;
        for (std::size_t k = 0; k < level.taps; ++k) {
            const std::uint32_t weight = (std::min)(4 * level.weights[k], static_cast<std::uint32_t>(one_weight));
            for (std::size_t b = 0; b < 8; ++b) {
                const auto byte = static_cast<std::uint32_t>(words[k] >> 8 * b & 255u) << 8;
                const std::uint32_t difference = (std::max)(byte, value[b]) - (std::min)(byte, value[b]);
                spread[b] = (std::max)(spread[b], weight * difference >> 15);
            }
        }
        std::uint64_t probed = 0;
        if (level.probe != nullptr)
            probed = level.probe->octet(o);
        for (std::size_t b = 0; b < 8; ++b) {
            const std::uint32_t t = 2 * (std::min)((std::max)(spread[b], low) - low, range);
            std::uint32_t beta = (t * t >> 15) * (3u * one_weight - 2 * t) >> 15;
            if (level.probe != nullptr) {
                const auto byte = static_cast<std::uint32_t>(probed >> 8 * b & 255u);
                const bool missed = (byte == 0 && least[b] > 153) || (byte == 255 && greatest[b] < 102);
                beta = (std::max)(beta, missed ? level.window : 0u);
            }
            beta = (std::max)(beta, level.force) * (level.fade >> 1) >> 14;
            std::uint32_t rest = left[b] * beta >> 15;
            rest = rest < 64 ? 0 : rest;
            found[b] += (left[b] - rest) * value[b];
            left[b] = rest;
            next |= static_cast<std::uint64_t>(rest != 0) << (8 * o + static_cast<int>(b));
        }
    }
    return next & lights;
}

}  // namespace lightmesh::detail
