// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <cmath>
#include <concepts>

namespace lightmesh::detail {

/// A product as it is after its own rounding: keeps the compiler from fusing it with a sum that follows, so
/// that the sum is the same whatever processor a program is compiled for.
template <std::floating_point T>
T rounded(T product) {
#if defined(__GNUC__) && defined(__FMA__)
    asm("" : "+x"(product));
#elif defined(__GNUC__) && defined(__aarch64__)
    asm("" : "+w"(product));
#endif
    return product;
}
/// The same for three.
template <class T>
glm::vec<3, T> rounded(const glm::vec<3, T>& products) {
    return {rounded(products.x), rounded(products.y), rounded(products.z)};
}

/// A scalar product of which every step is rounded by itself.
template <class T>
T rounded_dot(const glm::vec<3, T>& a, const glm::vec<3, T>& b) {
    const glm::vec<3, T> products = rounded(a * b);
    return products.x + products.y + products.z;
}

/// A vector product of which every step is rounded by itself.
template <class T>
glm::vec<3, T> rounded_cross(const glm::vec<3, T>& a, const glm::vec<3, T>& b) {
    return {rounded(a.y * b.z) - rounded(b.y * a.z), rounded(a.z * b.x) - rounded(b.z * a.x),
            rounded(a.x * b.y) - rounded(b.x * a.y)};
}

/// The vector, which is not zero, at length 1, so too.
template <class T>
glm::vec<3, T> rounded_unit(const glm::vec<3, T>& v) {
    return v * (T(1) / std::sqrt(rounded_dot(v, v)));
}

}  // namespace lightmesh::detail
