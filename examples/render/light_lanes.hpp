// SPDX-License-Identifier: MIT
#pragma once

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include <cmath>
#include <cstddef>

/// Arithmetic for eight lights at once, by the vector types of GCC and Clang, lane by lane as for one alone.
/// Never passed by value: that depends on the processor.

namespace demo {

inline constexpr std::size_t lights_at_once = 8;

using OfLights [[gnu::vector_size(32)]] = float;

/// Puts the square roots in the place of numbers.
inline void take_roots(OfLights& numbers) {
#if defined(__AVX__)
    numbers = reinterpret_cast<OfLights>(_mm256_sqrt_ps(reinterpret_cast<__m256>(numbers)));
#elif defined(__SSE2__)
    auto* halves = reinterpret_cast<__m128*>(&numbers);
    halves[0] = _mm_sqrt_ps(halves[0]);
    halves[1] = _mm_sqrt_ps(halves[1]);
#else
    for (std::size_t i = 0; i < lights_at_once; ++i)
        numbers[i] = std::sqrt(numbers[i]);
#endif
}

/// As std::max and std::min with a number for all.
inline void raise_to(OfLights& numbers, float least) {
    const OfLights all = OfLights{} + least;
    numbers = numbers < all ? all : numbers;
}
inline void limit_to(OfLights& numbers, float most) {
    const OfLights all = OfLights{} + most;
    numbers = numbers > all ? all : numbers;
}

}  // namespace demo
