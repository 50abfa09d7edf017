// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace lightmesh::detail {

/// Masks of 64 bits by keys, in the order in which the keys came. A `Key` has operator== and
/// `std::size_t hash() const`.
template <class Key>
class MaskTable {
public:
    struct Entry {
        Key key;
        std::uint64_t mask = 0;
    };

    /// Adds bits to the mask of a key. Throws std::bad_alloc; nothing has changed then.
    void add(const Key& key, std::uint64_t mask) {
        if (const auto found = places_.find(key); found != places_.end()) {
            entries_[found->second].mask |= mask;
            return;
        }
        entries_.push_back({key, mask});
        try {
            places_.emplace(key, entries_.size() - 1);
        } catch (...) {
            entries_.pop_back();
            throw;
        }
    }

    /// Adds all bits of another table. Throws std::bad_alloc.
    void add(const MaskTable& other) {
        for (const Entry& entry : other.entries_)
            add(entry.key, entry.mask);
    }

    std::span<const Entry> entries() const { return entries_; }

private:
    struct Hash {
        std::size_t operator()(const Key& key) const { return key.hash(); }
    };

    std::vector<Entry> entries_;
    std::unordered_map<Key, std::size_t, Hash> places_;
};

}  // namespace lightmesh::detail
