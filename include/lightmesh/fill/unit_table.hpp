// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace lightmesh::detail {

/// Units (see `BrickTile::known`) of one tile of lights of the brick of these coordinates.
struct UnitsAt {
    glm::ivec3 brick{0};
    std::size_t tile = 0;
    std::uint64_t units = 0;
};

/// Any number of units of one level, each named once, in the order in which their bricks came.
class UnitTable {
public:
    /// Throws std::bad_alloc; nothing has changed then.
    void add(const UnitsAt& more) {
        const Key key{more.brick, more.tile};
        if (const auto found = places_.find(key); found != places_.end()) {
            entries_[found->second].units |= more.units;
            return;
        }
        entries_.push_back(more);
        try {
            places_.emplace(key, entries_.size() - 1);
        } catch (...) {
            entries_.pop_back();
            throw;
        }
    }

    std::span<const UnitsAt> entries() const { return entries_; }

private:
    struct Key {
        glm::ivec3 brick;
        std::size_t tile;
        bool operator==(const Key&) const = default;
    };
    struct Hash {
        std::size_t operator()(const Key& key) const {
            std::uint64_t hash = key.tile;
            for (int axis = 0; axis < 3; ++axis) {
                hash = (hash ^ static_cast<std::uint32_t>(key.brick[axis])) * 0x9e3779b97f4a7c15u;
                hash ^= hash >> 29;
            }
            return static_cast<std::size_t>(hash);
        }
    };

    std::vector<UnitsAt> entries_;
    std::unordered_map<Key, std::size_t, Hash> places_;
};

}  // namespace lightmesh::detail
