// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

namespace lightmesh::detail {

/// A product as it is after its own rounding: keeps the compiler from fusing it with a sum that follows, so
/// that the sum is the same whatever processor a program is compiled for.
inline double rounded(double product) {
#if defined(__GNUC__) && defined(__FMA__)
    asm("" : "+x"(product));
#elif defined(__GNUC__) && defined(__aarch64__)
    asm("" : "+w"(product));
#endif
    return product;
}
/// The same for three.
inline glm::dvec3 rounded(const glm::dvec3& products) {
    return {rounded(products.x), rounded(products.y), rounded(products.z)};
}

/// A scalar product of which every step is rounded by itself.
inline double rounded_dot(const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 products = rounded(a * b);
    return products.x + products.y + products.z;
}

}  // namespace lightmesh::detail
