// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/support/huge_pages.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <stdexcept>
#include <type_traits>
#include <utility>

/// Arrays that grow without moving, addressed by 32-bit indices.

namespace lightmesh::detail {

/// The cut of a pool of T into chunks: eight of one size, eight of twice that size, and so on. So no more
/// than an eighth of a pool lies idle, and a chunk is found from an index by shifts alone.
template <class T>
struct PoolChunks {
    /// log2 of eight times the elements of the smallest chunks.
    static constexpr int first_bits =
        std::bit_width((std::max)(std::size_t{16384} / sizeof(T), std::size_t{16})) - 1;
    static constexpr std::uint64_t base = std::uint64_t{1} << first_bits;
    static constexpr std::size_t count = 8 * static_cast<std::size_t>(33 - first_bits);

    static std::size_t chunk_of(std::uint32_t index) {
        const std::uint64_t from_zero = index + base;
        const int eighth = static_cast<int>(std::bit_width(from_zero)) - 4;
        return static_cast<std::size_t>(8 * (eighth - first_bits + 3)) +
               static_cast<std::size_t>(from_zero >> eighth & 7);
    }
    static std::size_t offset_in_chunk(std::uint32_t index) {
        const std::uint64_t from_zero = index + base;
        const int eighth = static_cast<int>(std::bit_width(from_zero)) - 4;
        return static_cast<std::size_t>(from_zero & ((std::uint64_t{1} << eighth) - 1));
    }
    static std::uint64_t first_index(std::size_t chunk) {
        return ((8 + chunk % 8) << (static_cast<std::size_t>(first_bits) - 3 + chunk / 8)) - base;
    }
    static std::size_t size(std::size_t chunk) {
        return std::size_t{1} << (static_cast<std::size_t>(first_bits) - 3 + chunk / 8);
    }
};

/// The elements of a pool, or of an array in place of one, for whoever has their indices.
template <class T>
class PoolView {
public:
    using Chunks = PoolChunks<T>;
    using Table = std::array<std::atomic<T*>, Chunks::count>;

    PoolView() = default;
    explicit PoolView(const Table& table) : table_(&table) {}

    /// The element must have been handed out, and its index passed on by an acquiring load.
    T& operator[](std::uint32_t index) const {
        T* chunk = (*table_)[Chunks::chunk_of(index)].load(std::memory_order_relaxed);
        return chunk[Chunks::offset_in_chunk(index)];
    }

private:
    const Table* table_ = nullptr;
};

/// A table of chunks over an array that somebody else owns.
template <class T>
void spread_over(typename PoolView<T>::Table& table, T* first, std::size_t size) {
    for (std::size_t chunk = 0; chunk < table.size(); ++chunk) {
        const std::uint64_t begin = PoolChunks<T>::first_index(chunk);
        table[chunk].store(begin < size ? first + begin : nullptr, std::memory_order_relaxed);
    }
}

/// A growing array of zero-initialised T. Elements are handed out one after the other and never move. Any
/// number of threads may allocate, and read what was handed out. What is given back is handed out again for
/// as many elements.
template <class T>
class Pool {
    static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T> &&
                  sizeof(T) >= sizeof(std::uint32_t));

public:
    using Chunks = PoolChunks<T>;

    /// Index of the first of `count` elements that lie side by side. Throws std::bad_alloc, and
    /// std::length_error beyond 2^32 elements; nothing has changed then.
    std::uint32_t allocate(std::size_t count = 1) {
        const std::scoped_lock lock(growing_);
        if (count < free_.size() && free_[count] != 0)
            return take_free(count);
        std::uint64_t first = size_;
        for (;;) {
            require_indices(first + count);
            const std::size_t chunk = Chunks::chunk_of(static_cast<std::uint32_t>(first));
            const std::uint64_t end = Chunks::first_index(chunk) + Chunks::size(chunk);
            if (first + count <= end) {
                make(chunk);
                size_ = first + count;
                const auto index = static_cast<std::uint32_t>(first);
                std::memset(static_cast<void*>(&(*this)[index]), 0, count * sizeof(T));
                return index;
            }
            first = end;  // What is left of the chunk is too short: it stays idle.
        }
    }

    /// Memory for the first `count` elements, all of it side by side; none may have been handed out yet.
    /// Throws what `allocate` throws.
    void reserve_first(std::size_t count) {
        const std::scoped_lock lock(growing_);
        require_indices(count);
        if (count == 0)
            return;
        const std::size_t chunks = Chunks::chunk_of(static_cast<std::uint32_t>(count - 1)) + 1;
        const auto size = static_cast<std::size_t>(Chunks::first_index(chunks));
        Owner all = memory_for(size);
        spread_over<T>(chunks_, all.get(), size);
        owners_ = {};
        owners_[0] = std::move(all);
        bytes_ = size * sizeof(T);
    }

    /// Hands out the first elements, for which `reserve_first` has made memory, as copies of these.
    void allocate_first(std::span<const T> copied) {
        const std::scoped_lock lock(growing_);
        if (!copied.empty())
            std::memcpy(static_cast<void*>(owners_[0].get()), copied.data(), copied.size_bytes());
        size_ = copied.size();
    }

    /// Takes elements back that were handed out together, which nobody may use meanwhile or after. More than
    /// `most_reused` of them are not used again.
    void give_back(std::uint32_t index, std::size_t count = 1) {
        const std::scoped_lock lock(growing_);
        T* const elements = &(*this)[index];
        std::memset(static_cast<void*>(elements), 0, count * sizeof(T));
        if (count >= free_.size())
            return;
        std::memcpy(static_cast<void*>(elements), &free_[count], sizeof free_[count]);
        free_[count] = index + 1;
    }

    /// Elements handed out so far, the given back included.
    std::size_t size() const {
        const std::scoped_lock lock(growing_);
        return size_;
    }

    T& operator[](std::uint32_t index) const { return view()[index]; }
    PoolView<T> view() const { return PoolView<T>(chunks_); }

    /// Memory taken from the system.
    std::size_t bytes() const {
        const std::scoped_lock lock(growing_);
        return bytes_;
    }

private:
    static constexpr std::size_t most_reused = 255;
    static constexpr std::size_t alignment = (std::max)(alignof(T), std::size_t{64});
    struct Free {
        void operator()(T* chunk) const { ::operator delete (chunk, std::align_val_t{alignment}); }
    };
    using Owner = std::unique_ptr<T, Free>;

    std::uint32_t take_free(std::size_t count) {
        const std::uint32_t index = free_[count] - 1;
        T* const elements = &(*this)[index];
        std::memcpy(&free_[count], static_cast<const void*>(elements), sizeof free_[count]);
        std::memset(static_cast<void*>(elements), 0, sizeof free_[count]);
        return index;
    }

    static void require_indices(std::uint64_t count) {
        if (count > 0xfffffffeu)
            throw std::length_error("lightmesh: a mesh holds up to 2^32 entries of a kind");
    }

    static Owner memory_for(std::size_t count) {
        const std::size_t size = count * sizeof(T);
        Owner memory(static_cast<T*>(::operator new (size, std::align_val_t{alignment})));
        prefer_huge_pages(memory.get(), size);
        return memory;
    }

    void make(std::size_t chunk) {
        if (chunks_[chunk].load(std::memory_order_relaxed) != nullptr)
            return;
        owners_[chunk] = memory_for(Chunks::size(chunk));
        bytes_ += Chunks::size(chunk) * sizeof(T);
        chunks_[chunk].store(owners_[chunk].get(), std::memory_order_release);
    }

    mutable std::mutex growing_;
    std::uint64_t size_ = 0;
    std::size_t bytes_ = 0;
    /// Of so many elements the first that were given back, index plus one; they begin with that of the next.
    std::array<std::uint32_t, most_reused + 1> free_{};
    /// The memory that each chunk begins; none for a chunk that lies in that of one before it.
    std::array<Owner, Chunks::count> owners_{};
    typename PoolView<T>::Table chunks_{};
};

}  // namespace lightmesh::detail
