// SPDX-License-Identifier: MIT
#pragma once

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/integer.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <bit>
#include <cmath>
#include <cstdint>

namespace test {

/// What a shader's text needs to be compiled as C++: to be used where it is included, with `precise` defined
/// as nothing.
namespace glsl {

using glm::abs;
using glm::clamp;
using glm::findMSB;
using glm::max;
using glm::min;
using glm::uvec2;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using uint = std::uint32_t;

inline uint floatBitsToUint(float value) {
    return std::bit_cast<uint>(value);
}
inline float uintBitsToFloat(uint bits) {
    return std::bit_cast<float>(bits);
}
inline void umulExtended(uint a, uint b, uint& high, uint& low) {
    const std::uint64_t product = std::uint64_t{a} * b;
    high = static_cast<uint>(product >> 32);
    low = static_cast<uint>(product);
}
/// As far off as a device's may be.
inline float sqrt(float value) {
    static std::uint32_t turn = 0;
    return uintBitsToFloat(floatBitsToUint(std::sqrt(value)) + turn++ % 7 - 3);
}

/// A double as doubles.glsl has it: without a negative zero.
inline uvec2 words_of(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value + 0.0);
    return {static_cast<std::uint32_t>(bits), static_cast<std::uint32_t>(bits >> 32)};
}
inline double double_of(const uvec2& words) {
    return std::bit_cast<double>(words.x | static_cast<std::uint64_t>(words.y) << 32);
}

}  // namespace glsl

}  // namespace test
