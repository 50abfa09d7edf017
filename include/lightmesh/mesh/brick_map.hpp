// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/arena.hpp>
#include <lightmesh/mesh/brick.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

/// Where bricks are found: a hash table of regions of 8x8x8 bricks. Nothing has bounds; nothing is removed.

namespace lightmesh::detail {

inline constexpr int region_side = 8;  // bricks

/// 8x8x8 places for bricks.
class Region {
public:
    Region(const glm::ivec3& place, std::uint64_t key) : place_(place), key_(key) {}

    const glm::ivec3& place() const { return place_; }
    std::uint64_t key() const { return key_; }

    /// The brick of a place within the region, or null. `place` counts bricks, from anywhere.
    Brick* find(const glm::ivec3& place) const { return find_in_slot(slot(place)); }
    Brick* find_in_slot(std::size_t slot) const { return bricks_[slot].load(std::memory_order_acquire); }
    void set(const glm::ivec3& place, Brick* brick) {
        bricks_[slot(place)].store(brick, std::memory_order_release);
    }

    static std::size_t slot(const glm::ivec3& p) {
        return static_cast<std::size_t>((p.x & 7) | (p.y & 7) << 3 | (p.z & 7) << 6);
    }

    template <class Visitor>
    void for_each(Visitor&& visit) const {
        for (const auto& brick : bricks_)
            if (const Brick* b = brick.load(std::memory_order_acquire))
                visit(*b);
    }

private:
    glm::ivec3 place_;
    std::uint64_t key_;
    std::array<std::atomic<Brick*>, region_side * region_side * region_side> bricks_{};
};

/// Look-ups take no lock. What is missing is made under one, by whoever needs it first.
class BrickMap {
public:
    explicit BrickMap(std::size_t tiles_per_brick) : tiles_per_brick_(tiles_per_brick) { grow(); }

    /// The region of a place in units of regions, or null.
    Region* find_region(const glm::ivec3& place) const {
        return probe(*table_.load(std::memory_order_acquire), key_of(place));
    }

    /// The brick of a place in units of bricks, made if it is not there. Throws std::bad_alloc.
    Brick& make_brick(const glm::ivec3& place) {
        const std::scoped_lock lock(growing_);
        const glm::ivec3 region_place(place.x >> 3, place.y >> 3, place.z >> 3);
        Region* region = find_region(region_place);
        if (region == nullptr)
            region = make_region(region_place);
        if (Brick* brick = region->find(place))
            return *brick;
        auto* tiles = arena_.allocate_zeroed<BrickTile>(tiles_per_brick_);
        auto* brick = arena_.create<Brick>(place, tiles);
        region->set(place, brick);
        ++brick_count_;
        return *brick;
    }

    /// The same, without a lock if it is there.
    Brick& find_or_make_brick(const glm::ivec3& place) {
        const Region* region = find_region({place.x >> 3, place.y >> 3, place.z >> 3});
        Brick* brick = region != nullptr ? region->find(place) : nullptr;
        return brick != nullptr ? *brick : make_brick(place);
    }

    /// Keeps what a light point reaches (see `Reach::build`); if somebody else was first, what they found: it
    /// is the same. Throws std::bad_alloc.
    const Reach& keep_reach(const glm::ivec3& seed, std::span<const std::uint64_t> reached,
                            std::span<const std::uint64_t> asked) {
        Brick& brick = find_or_make_brick({seed.x >> 2, seed.y >> 2, seed.z >> 2});
        const int bit = bit_of(seed.x & 3, seed.y & 3, seed.z & 3);
        const std::scoped_lock lock(growing_);
        if (const Reach* kept = brick.reach_of(bit))
            return *kept;
        const std::size_t words = Reach::words_needed(reached.size(), Reach::count_masks(reached, asked));
        const Reach* made =
            Reach::build(arena_.allocate<std::uint64_t>(words), bit, reached, asked, brick.last_reach());
        brick.add_reach(*made);
        return *made;
    }

    /// Gives a tile its units if it has none yet. Throws std::bad_alloc.
    void ensure_storage(BrickTile& tile, int groups) {
        if (tile.has_storage())
            return;
        const std::scoped_lock lock(growing_);
        if (tile.has_storage())
            return;
        tile.set_storage(
            units_.allocate_on_line<std::uint64_t>(static_cast<std::size_t>(cells_per_brick * groups)));
    }

    /// Calls visit(const Brick&) for all bricks.
    template <class Visitor>
    void for_each(Visitor&& visit) const {
        const Table& table = *table_.load(std::memory_order_acquire);
        for (const auto& slot : table.slots)
            if (const Region* region = slot.load(std::memory_order_acquire))
                region->for_each(visit);
    }

    std::size_t bytes() const {
        const std::scoped_lock lock(growing_);
        std::size_t sum = sizeof *this + arena_.bytes() + units_.bytes();
        for (const auto& table : tables_)
            sum += sizeof(Table) + table->slots.size() * sizeof(table->slots[0]);
        return sum;
    }

private:
    struct Table {
        explicit Table(std::size_t size) : slots(size) {}
        std::vector<std::atomic<Region*>> slots;  // a power of two of them
    };

    static std::uint64_t key_of(const glm::ivec3& place) {
        const auto bits = [](std::int32_t v) {
            return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v) & 0x1fffff);
        };
        return bits(place.x) | bits(place.y) << 21 | bits(place.z) << 42;
    }

    static std::size_t first_slot(std::uint64_t key, std::size_t size) {
        // Fibonacci hashing: the high bits of the product are well mixed.
        return static_cast<std::size_t>((key ^ key >> 29) * 0x9e3779b97f4a7c15u >> 32) & (size - 1);
    }

    static Region* probe(const Table& table, std::uint64_t key) {
        const std::size_t size = table.slots.size();
        for (std::size_t i = first_slot(key, size);; i = (i + 1) & (size - 1)) {
            Region* region = table.slots[i].load(std::memory_order_acquire);
            if (region == nullptr || region->key() == key)
                return region;
        }
    }

    static void insert(Table& table, Region* region) {
        const std::size_t size = table.slots.size();
        std::size_t i = first_slot(region->key(), size);
        while (table.slots[i].load(std::memory_order_relaxed) != nullptr)
            i = (i + 1) & (size - 1);
        table.slots[i].store(region, std::memory_order_release);
    }

    Region* make_region(const glm::ivec3& place) {
        if (2 * (region_count_ + 1) > tables_.back()->slots.size())
            grow();
        auto* region = arena_.create<Region>(place, key_of(place));
        insert(*tables_.back(), region);
        ++region_count_;
        return region;
    }

    /// A table of twice the size. The old one is kept: a look-up may still be in it; it then misses what came
    /// later, and makes sure under the lock.
    void grow() {
        const std::size_t size = tables_.empty() ? 64 : 2 * tables_.back()->slots.size();
        auto table = std::make_unique<Table>(size);
        if (!tables_.empty())
            for (const auto& slot : tables_.back()->slots)
                if (Region* region = slot.load(std::memory_order_relaxed))
                    insert(*table, region);
        tables_.push_back(std::move(table));
        table_.store(tables_.back().get(), std::memory_order_release);
    }

    std::size_t tiles_per_brick_;
    std::atomic<const Table*> table_{nullptr};
    mutable std::mutex growing_;
    std::vector<std::unique_ptr<Table>> tables_;
    Arena arena_;
    Arena units_;  // apart from the rest, so that nothing is lost to their alignment
    std::size_t region_count_ = 0;
    std::size_t brick_count_ = 0;
};

}  // namespace lightmesh::detail
