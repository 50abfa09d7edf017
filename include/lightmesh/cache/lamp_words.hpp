// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/lamp_pattern.hpp>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

/// Lamps as shaders read them: see lamp.glsl and lamp_shares.glsl.

namespace lightmesh::detail {

inline std::uint32_t float_word(float value) {
    return std::bit_cast<std::uint32_t>(value);
}
inline std::array<std::uint32_t, 2> double_words(double value) {
    // doubles.glsl has no negative zero.
    const auto bits = std::bit_cast<std::uint64_t>(value + 0.0);
    return {static_cast<std::uint32_t>(bits), static_cast<std::uint32_t>(bits >> 32)};
}

/// Centre and kind; a half side and the lower word of the radius; the other half side and the upper one; what
/// it reaches above its centre, and how far short of that rays end. `reach`: how far rays go to directional
/// lights.
using LampWords = std::array<std::uint32_t, 16>;

inline LampWords words_of(const Lamp& lamp, double reach) {
    const glm::vec3& at = lamp.shape().at;
    const glm::vec3 u(lamp.half_u());
    const glm::vec3 v(lamp.half_v());
    const std::uint32_t kind = lamp.is_rectangle() ? 2 : lamp.shape().is_directional ? 1 : 0;
    const auto radius = double_words(lamp.radius(reach));
    const auto top = double_words(lamp.top());
    const auto rest = double_words(lamp.rest());
    return {float_word(at.x), float_word(at.y), float_word(at.z), kind,       //
            float_word(u.x),  float_word(u.y),  float_word(u.z),  radius[0],  //
            float_word(v.x),  float_word(v.y),  float_word(v.z),  radius[1],  //
            top[0],           top[1],           rest[0],          rest[1]};
}

/// A point of the disc's pattern, of which the coordinates are the lower and the upper half.
inline std::uint32_t disc_word(std::size_t i) {
    const auto half = [&](std::size_t axis) {
        return static_cast<std::uint32_t>(static_cast<std::uint16_t>(disc_points[i][axis]));
    };
    return half(0) | half(1) << 16;
}

/// The cosine and the sine of turn i, below 1024.
inline std::array<std::uint32_t, 4> turn_words(std::uint32_t i) {
    const glm::dvec2 turn = turn_of(i);
    const auto c = double_words(turn.x);
    const auto s = double_words(turn.y);
    return {c[0], c[1], s[0], s[1]};
}

}  // namespace lightmesh::detail
