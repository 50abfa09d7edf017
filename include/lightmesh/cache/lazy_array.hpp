// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>

namespace lightmesh::detail {

/// Up to 64 values on the stack, of which those that nobody asks for cost nothing.
template <class T, std::size_t count>
class LazyArray {
    static_assert(count <= 64 && std::is_trivially_destructible_v<T>);

public:
    LazyArray() = default;
    LazyArray(const LazyArray&) = delete;
    LazyArray& operator=(const LazyArray&) = delete;

    T& operator[](std::size_t i) {
        T* const value = reinterpret_cast<T*>(memory_) + i;
        if ((made_ >> i & 1u) == 0) {
            ::new (static_cast<void*>(value)) T;
            made_ |= std::uint64_t{1} << i;
        }
        return *value;
    }

private:
    std::uint64_t made_ = 0;
    alignas(T) std::byte memory_[count * sizeof(T)];
};

}  // namespace lightmesh::detail
