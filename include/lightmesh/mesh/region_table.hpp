// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/pool.hpp>
#include <lightmesh/support/atomics.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// A hash table from places to regions with linear probing: slots hold indices of regions plus one. A power
/// of two of them, at most half of them taken.
struct RegionTable {
    std::uint32_t* slots = nullptr;
    std::uint64_t size = 0;

    static std::uint64_t first_slot(std::uint64_t key, std::uint64_t size) {
        // Fibonacci hashing: the high bits of the product are well mixed.
        return ((key ^ key >> 29) * 0x9e3779b97f4a7c15u >> 32) & (size - 1);
    }

    /// Index plus one of the region that holds a brick; 0 if it is not there.
    std::uint32_t find(const PoolView<Region>& regions, std::uint64_t key) const {
        for (std::uint64_t i = first_slot(key, size);; i = (i + 1) & (size - 1)) {
            const std::uint32_t region = load_acquire(slots[i]);
            if (region == 0 || regions[region - 1].key == key)
                return region;
        }
    }

    /// By one thread at a time.
    void insert(std::uint64_t key, std::uint32_t region) const {
        std::uint64_t i = first_slot(key, size);
        while (load_relaxed(slots[i]) != 0)
            i = (i + 1) & (size - 1);
        store_release(slots[i], region);
    }
};

}  // namespace lightmesh::detail
