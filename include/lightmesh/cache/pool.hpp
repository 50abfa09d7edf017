// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/support/prefetch.hpp>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <new>

namespace lightmesh::detail {

/// Memory in units of 8 bytes, zero at first, addressed by 32-bit indices and never moved. Any number of
/// threads may allocate and read at once. Index 0 is given to nobody. Blocks that are given back are handed
/// out again for blocks of the same size.
class UnitPool {
public:
    static constexpr std::uint32_t chunk_units = 1u << 14;
    static constexpr std::uint32_t chunk_limit = 1u << 15;  // 4 GiB in all
    static constexpr std::uint32_t largest_block = 15;

    UnitPool() : chunks_(std::make_unique<std::atomic<Unit*>[]>(chunk_limit)) {}
    UnitPool(const UnitPool&) = delete;
    UnitPool& operator=(const UnitPool&) = delete;
    ~UnitPool() {
        for (std::uint32_t c = 0; c < chunk_limit; ++c)
            delete[] chunks_[c].load(std::memory_order_relaxed);
    }

    /// Throws std::bad_alloc; nothing but the indices is lost then. At most `largest_block` units.
    std::uint32_t allocate(std::uint32_t units) {
        if (free_units_.load(std::memory_order_relaxed) != 0)
            if (const std::uint32_t again = take_free(units); again != 0)
                return again;
        for (;;) {
            const std::uint64_t first = next_.fetch_add(units, std::memory_order_relaxed);
            const std::uint64_t last = first + units - 1;
            if (last / chunk_units >= chunk_limit)
                throw std::bad_alloc();
            if (first / chunk_units != last / chunk_units)
                continue;  // the rest of a chunk is too short
            ensure_chunk(static_cast<std::uint32_t>(first / chunk_units));
            return static_cast<std::uint32_t>(first);
        }
    }

    /// Takes a block back, which nobody may use meanwhile or after.
    void give_back(std::uint32_t index, std::uint32_t units) {
        const std::scoped_lock lock(growing_);
        for (std::uint32_t i = 1; i < units; ++i)
            at(index)[i].store(0, std::memory_order_relaxed);
        at(index)[0].store(free_[units], std::memory_order_relaxed);
        free_[units] = index;
        free_units_.fetch_add(units, std::memory_order_relaxed);
    }

    std::atomic<std::uint64_t>* at(std::uint32_t index) const {
        return chunks_[index / chunk_units].load(std::memory_order_acquire) + index % chunk_units;
    }

    /// Asks for a block's memory before it is needed.
    void fetch_ahead(std::uint32_t index) const { prefetch(at(index)); }

    std::size_t bytes() const {
        return chunk_count_.load(std::memory_order_relaxed) * chunk_units * sizeof(Unit) + least_bytes();
    }
    static constexpr std::size_t least_bytes() { return chunk_limit * sizeof(std::atomic<Unit*>); }
    /// The part of it that was given back and waits for its next use.
    std::size_t free_bytes() const { return free_units_.load(std::memory_order_relaxed) * sizeof(Unit); }

private:
    using Unit = std::atomic<std::uint64_t>;

    /// A free block, zero again; 0 if there is none of this size.
    std::uint32_t take_free(std::uint32_t units) {
        const std::scoped_lock lock(growing_);
        const std::uint32_t index = free_[units];
        if (index == 0)
            return 0;
        free_[units] = static_cast<std::uint32_t>(at(index)->exchange(0, std::memory_order_relaxed));
        free_units_.fetch_sub(units, std::memory_order_relaxed);
        return index;
    }

    void ensure_chunk(std::uint32_t c) {
        if (chunks_[c].load(std::memory_order_acquire) != nullptr)
            return;
        const std::scoped_lock lock(growing_);
        if (chunks_[c].load(std::memory_order_relaxed) != nullptr)
            return;
        chunks_[c].store(new Unit[chunk_units](), std::memory_order_release);
        chunk_count_.fetch_add(1, std::memory_order_relaxed);
    }

    std::unique_ptr<std::atomic<Unit*>[]> chunks_;
    std::atomic<std::uint64_t> next_{1};
    std::atomic<std::size_t> chunk_count_{0};
    std::atomic<std::size_t> free_units_{0};
    std::array<std::uint32_t, largest_block + 1>
        free_{};  ///< the first free block of each size, which names the next
    std::mutex growing_;
};

}  // namespace lightmesh::detail
