// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

namespace lightmesh::detail {

/// Room for some values, none of which is there before it is made: to have much of it on the stack costs
/// nothing.
template <class T, std::size_t count>
class RoomFor {
    static_assert(std::is_trivially_destructible_v<T>);

public:
    RoomFor() = default;
    RoomFor(const RoomFor&) = delete;
    RoomFor& operator=(const RoomFor&) = delete;

    /// Makes the i-th value, anew if it is there already.
    template <class... Arguments>
    T& make(std::size_t i, Arguments&&... arguments) {
        return *std::construct_at(data() + i, std::forward<Arguments>(arguments)...);
    }

    T* data() { return reinterpret_cast<T*>(memory_); }
    const T* data() const { return reinterpret_cast<const T*>(memory_); }
    /// One that is there.
    T& operator[](std::size_t i) { return data()[i]; }

private:
    alignas(T) std::byte memory_[count * sizeof(T)];
};

}  // namespace lightmesh::detail
