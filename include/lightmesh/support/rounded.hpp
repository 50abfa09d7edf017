// SPDX-License-Identifier: MIT
#pragma once

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

}  // namespace lightmesh::detail
