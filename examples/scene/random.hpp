// SPDX-License-Identifier: MIT
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace demo {

/// PCG32 (O'Neill 2014). The scenes use nothing of <random>'s distributions: those differ between standard
/// libraries.
/// Never two calls in one expression, but in braces: compilers differ in which they do first.
class Random {
public:
    explicit Random(std::uint64_t seed) {
        next();
        state_ += seed;
        next();
    }

    std::uint32_t next() {
        const std::uint64_t old = state_;
        state_ = old * 6364136223846793005ULL + 1442695040888963407ULL;
        const auto shifted = static_cast<std::uint32_t>(((old >> 18U) ^ old) >> 27U);
        const auto turn = static_cast<std::uint32_t>(old >> 59U);
        return (shifted >> turn) | (shifted << ((32U - turn) & 31U));
    }

    /// In [0, 1): a multiple of 2^-24, so it is exact.
    float uniform() { return static_cast<float>(next() >> 8U) * 0x1p-24f; }
    float uniform(float low, float high) { return low + (high - low) * uniform(); }

    /// An index below `count`.
    std::uint32_t index(std::uint32_t count) {
        return static_cast<std::uint32_t>((static_cast<std::uint64_t>(next()) * count) >> 32U);
    }

private:
    std::uint64_t state_ = 0;
};

/// (cos, sin) of an angle given in turns. By polynomials: the C library's results differ in the last bit
/// between machines, and the scenes must not.
inline glm::vec2 circle_point(float turns) {
    const double angle_in_quarters =
        4.0 * (static_cast<double>(turns) - std::floor(static_cast<double>(turns)));
    const double quarter = std::floor(angle_in_quarters + 0.5);
    const double a = (angle_in_quarters - quarter) * 1.5707963267948966;  // in [-pi/4, pi/4]
    const double b = a * a;
    const double s = a * (1 - b / 6 * (1 - b / 20 * (1 - b / 42 * (1 - b / 72 * (1 - b / 110)))));
    const double c = 1 - b / 2 * (1 - b / 12 * (1 - b / 30 * (1 - b / 56 * (1 - b / 90 * (1 - b / 132)))));
    const auto x = static_cast<float>(c);
    const auto y = static_cast<float>(s);
    switch (static_cast<int>(quarter) & 3) {
    case 0:
        return {x, y};
    case 1:
        return {-y, x};
    case 2:
        return {-x, -y};
    default:
        return {y, -x};
    }
}

/// A direction, evenly over the sphere.
inline glm::vec3 random_direction(Random& random) {
    const float z = random.uniform(-1.0f, 1.0f);
    const float ring = std::sqrt((std::max)(0.0f, 1.0f - z * z));
    const glm::vec2 around = circle_point(random.uniform());
    return {ring * around.x, ring * around.y, z};
}

}  // namespace demo
