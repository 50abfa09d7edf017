// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <new>

namespace lightmesh::detail {

/// Memory in units of 8 bytes, zero at first, addressed by 32-bit indices and never moved. Any number of
/// threads may allocate and read at once. Index 0 is given to nobody.
class UnitPool {
public:
    static constexpr std::uint32_t chunk_units = 1u << 15;
    static constexpr std::uint32_t chunk_limit = 1u << 15;  // 8 GiB in all

    UnitPool() : chunks_(std::make_unique<std::atomic<Unit*>[]>(chunk_limit)) {}
    UnitPool(const UnitPool&) = delete;
    UnitPool& operator=(const UnitPool&) = delete;
    ~UnitPool() {
        for (std::uint32_t c = 0; c < chunk_limit; ++c)
            delete[] chunks_[c].load(std::memory_order_relaxed);
    }

    /// Throws std::bad_alloc; nothing but the indices is lost then. At most `chunk_units` units.
    std::uint32_t allocate(std::uint32_t units) {
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

    std::atomic<std::uint64_t>* at(std::uint32_t index) const {
        return chunks_[index / chunk_units].load(std::memory_order_acquire) + index % chunk_units;
    }

    std::size_t bytes() const {
        return chunk_count_.load(std::memory_order_relaxed) * chunk_units * sizeof(Unit) +
               chunk_limit * sizeof(std::atomic<Unit*>);
    }

private:
    using Unit = std::atomic<std::uint64_t>;

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
    std::mutex growing_;
};

}  // namespace lightmesh::detail
