// SPDX-License-Identifier: MIT
// The shaders' doubles, compiled as C++, against those of the processor.

#include "glsl.hpp"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>

namespace {

namespace shader {

using namespace test::glsl;

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#define precise
#include <lightmesh/gpu/doubles.glsl>
#undef precise
#pragma GCC diagnostic pop

}  // namespace shader

using test::glsl::double_of;
using test::glsl::words_of;

/// Numbers with many and with few digits, near to each other and far apart.
class Numbers {
public:
    double next() {
        std::uint64_t bits = random_();
        const std::uint64_t digits = random_() % 54;
        bits &= ~std::uint64_t{0} << digits % 53;
        if (random_() % 3 == 0)
            bits |= (std::uint64_t{1} << digits % 53) - 1;
        const std::uint64_t spread = random_() % 3 == 0 ? 60 : 3;
        const std::uint64_t exponent = 1023 - spread + random_() % (2 * spread + 1);
        bits = (bits & ~(std::uint64_t{0x7ff} << 52)) | exponent << 52;
        if (random_() % 50 == 0)
            return 0.0;
        last_ = random_() % 8 == 0 ? std::nextafter(last_, random_() % 2 == 0 ? 1e9 : -1e9)
                                   : std::bit_cast<double>(bits);
        return last_;
    }
    float next_float() { return static_cast<float>(next()); }

private:
    std::mt19937_64 random_{20261127};
    double last_ = 1.0;
};

}  // namespace

TEST_CASE("doubles by integers: sums, products, quotients, roots and comparisons") {
    Numbers numbers;
    int wrong = 0;
    for (int i = 0; i < 1'000'000; ++i) {
        const double a = numbers.next();
        const double b = numbers.next();
        const auto x = words_of(a);
        const auto y = words_of(b);
        wrong += double_of(shader::lightmesh_double_add(x, y)) != a + b;
        wrong += double_of(shader::lightmesh_double_subtract(x, y)) != a - b;
        wrong += double_of(shader::lightmesh_double_multiply(x, y)) != a * b;
        wrong += shader::lightmesh_double_less(x, y) != (a < b);
        if (b != 0.0 && i % 4 == 0)
            wrong += double_of(shader::lightmesh_double_divide(x, y)) != a / b;
        if (i % 4 == 1) {
            wrong +=
                double_of(shader::lightmesh_double_sqrt(words_of(std::abs(a)))) != std::sqrt(std::abs(a));
            wrong += double_of(shader::lightmesh_double_sqrt(words_of(a * a))) != std::sqrt(a * a);
        }
    }
    CHECK(wrong == 0);
}

TEST_CASE("doubles by integers: to and from floats and integers") {
    Numbers numbers;
    int wrong = 0;
    for (int i = 0; i < 1'000'000; ++i) {
        const double a = numbers.next();
        const auto f = static_cast<float>(a);
        wrong += shader::lightmesh_double_to_float(words_of(a)) != f;
        wrong += double_of(shader::lightmesh_double_of(f)) != static_cast<double>(f);
        const double scaled = a * 1e6;
        if (std::abs(scaled) < 2147483647.0) {
            const auto whole = static_cast<int>(std::floor(scaled));
            wrong += shader::lightmesh_double_floor(words_of(scaled)) != whole;
            wrong += double_of(shader::lightmesh_double_of(whole)) != static_cast<double>(whole);
            wrong += shader::lightmesh_double_floor(shader::lightmesh_double_of(whole)) != whole;
        }
    }
    CHECK(wrong == 0);
    for (const float denormal : {0.0f, -0.0f, 1e-45f, -1e-40f})
        CHECK(shader::lightmesh_double_of(denormal) == shader::uvec2(0u));
}

TEST_CASE("sums and products of floats are sums of two floats") {
    Numbers numbers;
    int wrong = 0;
    for (int i = 0; i < 300'000; ++i) {
        const float a = numbers.next_float();
        const float b = numbers.next_float();
        const double exact = static_cast<double>(a) * b;
        if (std::abs(exact) < 1e-20 || std::abs(exact) > 1e20)
            continue;
        const shader::vec2 sum = shader::lightmesh_sum(a, b);
        wrong += sum.x != a + b;
        if (std::abs(std::ilogb(a) - std::ilogb(b)) < 28)
            wrong += static_cast<double>(sum.x) + sum.y != static_cast<double>(a) + b;
        const shader::vec2 product = shader::lightmesh_product(a, b);
        wrong += product.x != a * b;
        wrong += static_cast<double>(product.x) + product.y != exact;
    }
    CHECK(wrong == 0);
}

TEST_CASE("quotients and square roots of floats are the nearest floats") {
    Numbers numbers;
    int wrong = 0;
    for (int i = 0; i < 300'000; ++i) {
        const float a = numbers.next_float();
        const float b = numbers.next_float();
        if (b != 0.0f)
            wrong += shader::lightmesh_float_divide(a, b) != a / b;
        const float square = 1.0f + std::fmod(std::abs(a), 3.0f);
        wrong += shader::lightmesh_float_sqrt(square) != std::sqrt(square);
    }
    CHECK(wrong == 0);
}
