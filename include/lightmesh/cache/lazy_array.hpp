// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/support/room_for.hpp>

#include <cstddef>
#include <cstdint>
#include <new>

namespace lightmesh::detail {

/// Up to 64 values on the stack, of which those that nobody asks for cost nothing.
template <class T, std::size_t count>
class LazyArray {
    static_assert(count <= 64);

public:
    T& operator[](std::size_t i) {
        if ((made_ >> i & 1u) == 0) {
            // Without a value: most of what there is room for is overwritten before it is read.
            ::new (static_cast<void*>(room_.data() + i)) T;
            made_ |= std::uint64_t{1} << i;
        }
        return room_[i];
    }

private:
    std::uint64_t made_ = 0;
    RoomFor<T, count> room_;
};

}  // namespace lightmesh::detail
