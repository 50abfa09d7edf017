// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/support/atomics.hpp>
#include <lightmesh/support/popcount.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace lightmesh::detail {

/// Light points of one brick that belong to an interpolation set.
struct BrickPoints {
    const Brick* brick;    ///< null where a snapshot has no such brick
    std::uint64_t points;  ///< bits as in `bit_of`
    /// The slot of the brick in the `BrickWindow` of its set: greater for bricks that come later in the
    /// order of z, y, x.
    std::uint32_t slot;
    /// Those that the linked short test has found so far.
    std::uint64_t linked;
};

/// The bricks around the points of a block, each looked up once. A window stays where it is as long as the
/// hemispheres of all points lie in it.
class BrickWindow {
    static constexpr int largest_side = Hemisphere::max_bricks_per_axis + 3;

public:
    static constexpr std::size_t most_slots = largest_side * largest_side * largest_side;

    explicit BrickWindow(const Grid& grid) : side_(Hemisphere::largest_side(grid.quality()) + 3) {}

    /// Makes the window hold a box of bricks; returns whether it stayed where it was.
    bool cover(const glm::ivec3& first, const glm::ivec3& bricks) {
        const glm::ivec3 low = first - first_;
        const glm::ivec3 high = low + bricks;
        if (is_placed_ && low.x >= 0 && low.y >= 0 && low.z >= 0 && high.x <= side_ && high.y <= side_ &&
            high.z <= side_)
            return true;
        is_placed_ = true;
        first_ = first - (side_ - bricks) / 2;
        std::fill_n(slots_.begin(), size(), nullptr);
        return false;
    }

    /// The number of its slots.
    std::size_t size() const { return static_cast<std::size_t>(side_ * side_ * side_); }

    bool contains(const glm::ivec3& coord) const {
        const glm::ivec3 p = coord - first_;
        return p.x >= 0 && p.x < side_ && p.y >= 0 && p.y < side_ && p.z >= 0 && p.z < side_;
    }
    std::uint32_t slot_of(const glm::ivec3& coord) const {
        const glm::ivec3 p = coord - first_;
        return static_cast<std::uint32_t>(p.x + side_ * (p.y + side_ * p.z));
    }
    /// The number of slots by which a brick of a box lies after the first of the box.
    std::uint32_t slots_to(const BrickMask& brick) const {
        const auto side = static_cast<std::uint32_t>(side_);
        return brick.x + side * (brick.y + side * brick.z);
    }

    /// The brick in a slot; null until somebody has looked it up, and put it there.
    const Brick*& brick_in(std::uint32_t slot) { return slots_[slot]; }

private:
    int side_;
    bool is_placed_ = false;
    glm::ivec3 first_{0};
    std::array<const Brick*, most_slots> slots_;
};

/// An interpolation set D of equation (2), brick by brick, in memory of the caller's.
class Neighbours {
public:
    Neighbours() = default;
    /// `entries` has room for more than `size`: `size` says how much is taken.
    Neighbours(BrickPoints* entries, std::size_t size) : entries_(entries), size_(size) { count_points(); }
    /// The same where the number of light points is known.
    Neighbours(BrickPoints* entries, std::size_t size, int point_count)
        : entries_(entries), size_(size), point_count_(point_count) {}

    std::span<const BrickPoints> entries() const { return {entries_, size_}; }

    /// m of equation (3).
    int point_count() const { return point_count_; }

    /// The entry that holds a light point, or null.
    const BrickPoints* entry_with(const glm::ivec3& grid_pos) const {
        const glm::ivec3 coord = brick_of(grid_pos);
        const int bit = bit_in_brick(grid_pos);
        for (const BrickPoints& entry : entries())
            if (entry.brick->position() == coord)
                return (entry.points >> bit & 1) != 0 ? &entry : nullptr;
        return nullptr;
    }

    /// The light point of this number, in the order of entries and bits: its entry, and its bit in it.
    std::pair<const BrickPoints*, int> point_at(int number) const {
        const BrickPoints* entry = entries_;
        for (; number >= popcount(entry->points); ++entry)
            number -= popcount(entry->points);
        std::uint64_t rest = entry->points;
        for (; number > 0; --number)
            rest &= rest - 1;
        return {entry, std::countr_zero(rest)};
    }

    /// Adds to what is linked: reach(entry) returns light points of an entry. Returns how many are linked
    /// now.
    template <class Reach>
    int link(Reach&& reach) {
        int count = 0;
        for (std::size_t i = 0; i < size_; ++i) {
            entries_[i].linked |= entries_[i].points & reach(std::as_const(entries_[i]));
            count += popcount(entries_[i].linked);
        }
        return count;
    }

    /// Removes what is not linked.
    void keep_linked() {
        narrow([](const BrickPoints& entry) { return entry.linked; });
    }

    /// Removes light points: keep(entry) returns those of an entry that stay.
    template <class Keep>
    void narrow(Keep&& keep) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < size_; ++i) {
            const std::uint64_t points = entries_[i].points & keep(std::as_const(entries_[i]));
            entries_[kept] = {entries_[i].brick, points, entries_[i].slot, 0};
            kept += points != 0 ? 1u : 0u;
        }
        size_ = kept;
        count_points();
    }

    void clear() {
        size_ = 0;
        point_count_ = 0;
    }

private:
    void count_points() {
        point_count_ = 0;
        for (const BrickPoints& entry : entries())
            point_count_ += popcount(entry.points);
    }

    BrickPoints* entries_ = nullptr;
    std::size_t size_ = 0;
    int point_count_ = 0;
};

/// True if the bricks of a set are known to be uniform for each of these lights of a tile, and alike. Without
/// entries nothing is known.
inline bool bricks_agree(const MeshView& mesh, std::span<const BrickPoints> entries, std::size_t tile,
                         std::uint64_t lights) {
    std::uint64_t all_lit = lights;
    std::uint64_t any_lit = 0;
    for (const BrickPoints& entry : entries) {
        const BrickTile* known = mesh.find_tile(*entry.brick, tile);
        if (known == nullptr || (lights & ~load_acquire(known->uniform)) != 0)
            return lights == 0;
        all_lit &= load_relaxed(known->lit);
        any_lit |= load_relaxed(known->lit) & lights;
    }
    return all_lit == any_lit;
}

}  // namespace lightmesh::detail
