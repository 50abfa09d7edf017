// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>

/// Eight numbers at once, one for each light of an octet, by the vector types of GCC and Clang. Never passed
/// by value: that depends on the processor.

namespace lightmesh::detail {

using Lanes [[gnu::vector_size(32)]] = std::uint32_t;
using SignedLanes [[gnu::vector_size(32)]] = std::int32_t;
using FloatLanes [[gnu::vector_size(32)]] = float;
using ByteLanes [[gnu::vector_size(8)]] = std::uint8_t;
/// Half an octet.
using DoubleLanes [[gnu::vector_size(32)]] = double;

/// The bytes of a word, the lowest first.
inline void spread_bytes(std::uint64_t word, Lanes& lanes) {
    ByteLanes bytes;
    std::memcpy(&bytes, &word, sizeof bytes);
    lanes = __builtin_convertvector(bytes, Lanes);
}

/// The lowest bits of eight bytes, side by side.
inline std::uint64_t gather_low_bits(std::uint64_t bytes) {
    return (bytes & 0x0101010101010101u) * 0x0102040810204080u >> 56;
}

/// One bit for each lane that is not 0.
inline std::uint64_t mask_of(const Lanes& lanes) {
    const ByteLanes bytes = __builtin_convertvector(lanes != 0, ByteLanes);
    std::uint64_t word = 0;
    std::memcpy(&word, &bytes, sizeof word);
    return gather_low_bits(word);
}

inline void keep_greater(Lanes& lanes, const Lanes& other) {
    lanes = lanes > other ? lanes : other;
}

}  // namespace lightmesh::detail
