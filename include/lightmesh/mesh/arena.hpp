// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// Memory that is handed out piece by piece and given back as a whole. Not thread-safe. Only for types whose
/// destructor does nothing.
class Arena {
public:
    /// Throws std::bad_alloc.
    template <class T>
    T* allocate(std::size_t count) {
        static_assert(std::is_trivially_destructible_v<T>);
        constexpr std::size_t alignment = (std::max)(alignof(T), sizeof(void*));
        return static_cast<T*>(take(count * sizeof(T), alignment));
    }

    /// `count` zero-initialised elements that begin on a cache line.
    template <class T>
    T* allocate_on_line(std::size_t count) {
        static_assert(std::is_trivially_destructible_v<T>);
        T* first = static_cast<T*>(take(count * sizeof(T), line));
        std::uninitialized_value_construct_n(first, count);
        return first;
    }

    /// `count` zero-initialised elements.
    template <class T>
    T* allocate_zeroed(std::size_t count) {
        T* first = allocate<T>(count);
        std::uninitialized_value_construct_n(first, count);
        return first;
    }

    template <class T, class... Arguments>
    T* create(Arguments&&... arguments) {
        return std::construct_at(allocate<T>(1), std::forward<Arguments>(arguments)...);
    }

    /// All that was taken from the system.
    std::size_t bytes() const { return bytes_; }

private:
    static constexpr std::size_t line = 64;
    static constexpr std::size_t smallest_chunk = 8 * 1024;
    static constexpr std::size_t largest_chunk = 512 * 1024;

    struct Free {
        void operator()(std::byte* chunk) const { ::operator delete (chunk, std::align_val_t{line}); }
    };
    using Chunk = std::unique_ptr<std::byte, Free>;

    void* take(std::size_t size, std::size_t alignment) {
        std::size_t begin = (used_ + alignment - 1) / alignment * alignment;
        if (chunks_.empty() || begin + size > capacity_) {
            // Chunks grow with the arena, so that little of a small one and of a large one lies idle.
            const std::size_t grown = std::clamp(bytes_ / 64, smallest_chunk, largest_chunk);
            const std::size_t capacity = (std::max)(grown, size);
            chunks_.reserve(chunks_.size() + 1);
            chunks_.emplace_back(static_cast<std::byte*>(::operator new (capacity, std::align_val_t{line})));
            capacity_ = capacity;
            bytes_ += capacity;
            begin = 0;
        }
        used_ = begin + size;
        return chunks_.back().get() + begin;
    }

    std::vector<Chunk> chunks_;
    std::size_t capacity_ = 0;
    std::size_t used_ = 0;
    std::size_t bytes_ = 0;
};

}  // namespace lightmesh::detail
