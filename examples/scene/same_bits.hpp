// SPDX-License-Identifier: MIT
#pragma once

#include <cstring>
#include <type_traits>
#include <vector>

namespace demo {

/// Whether two values are the same, bit by bit: NaN equals itself. Of values without padding.
template <class Value>
bool same_bits(const Value& a, const Value& b) {
    static_assert(std::is_trivially_copyable_v<Value>);
    return std::memcmp(&a, &b, sizeof(Value)) == 0;
}

template <class Value>
bool same_bits(const std::vector<Value>& a, const std::vector<Value>& b) {
    static_assert(std::is_trivially_copyable_v<Value>);
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0);
}

}  // namespace demo
