// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstdint>

namespace lightmesh::detail {

/// The number of bits set. Without the instruction for it std::popcount is a call and a table.
inline int popcount(std::uint64_t v) {
#if defined(__POPCNT__) || !defined(__x86_64__)
    return std::popcount(v);
#else
    v -= (v >> 1) & 0x5555555555555555u;
    v = (v & 0x3333333333333333u) + ((v >> 2) & 0x3333333333333333u);
    v = (v + (v >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return static_cast<int>(v * 0x0101010101010101u >> 56);
#endif
}

}  // namespace lightmesh::detail
