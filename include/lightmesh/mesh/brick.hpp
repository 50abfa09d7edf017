// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/query/hemisphere.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <thread>

/// What is stored: the visibility scales of light points, brick by brick, tile of lights by tile of lights.
///
/// The unit of storing and of tracing is 8 light points (a cell of 2x2x2) by 8 lights (a group): 64 bits. A
/// unit is written once, as a whole, before its bit in `known` is set (release), and never changes after; who
/// sees the bit (acquire) may read it with plain loads.

namespace lightmesh::detail {

/// Bits of `BrickTile::known`: 8 * cell + group.
inline constexpr std::uint64_t every_byte = 0x0101010101010101u;

/// 0xff in each byte of a brick's mask that is not 0: the cells with light points in it, for all groups of
/// lights.
constexpr std::uint64_t cells_in(std::uint64_t mask) {
    constexpr std::uint64_t low = 0x7f7f7f7f7f7f7f7fu;
    const std::uint64_t highest_bits = (((mask & low) + low) | mask) & ~low;
    return (highest_bits >> 7) * 0xff;
}

/// The same with one bit a cell.
constexpr std::uint32_t cell_bits(std::uint64_t mask) {
    return static_cast<std::uint32_t>((cells_in(mask) & 0x8040201008040201u) * every_byte >> 56);
}

/// Up to 64 lights of one brick: for each cell a row of one byte a light, bit p of it being V(L, x) of the
/// cell's light point p.
class BrickTile {
public:
    /// Which units are there.
    std::uint64_t known() const { return known_.load(std::memory_order_acquire); }

    /// The bytes of the lights, cell by cell, 8 * groups a cell; only those of known units may be read.
    const std::uint8_t* rows() const {
        return reinterpret_cast<const std::uint8_t*>(units_.load(std::memory_order_relaxed));
    }

    bool has_storage() const { return units_.load(std::memory_order_acquire) != nullptr; }

    /// Gives the tile its 8 * groups units; only once, and by one thread at a time.
    void set_storage(std::uint64_t* units) { units_.store(units, std::memory_order_release); }

    /// Stores the units of `fresh` from values[8 * cell + group]; those that are there are left as they are:
    /// they have the same value. By one thread at a time.
    void publish(std::uint64_t fresh, const std::uint64_t* values, int groups) {
        fresh &= ~known_.load(std::memory_order_relaxed);
        std::uint64_t* units = units_.load(std::memory_order_relaxed);
        for (std::uint64_t rest = fresh; rest != 0; rest &= rest - 1) {
            const int bit = std::countr_zero(rest);
            units[(bit / 8) * groups + bit % 8] = values[bit];
        }
        known_.fetch_or(fresh, std::memory_order_release);
    }

private:
    std::atomic<std::uint64_t> known_{0};
    std::atomic<std::uint64_t*> units_{nullptr};
};

/// The links from a brick's light points one step up along each axis.
class BrickLinks {
public:
    /// Cells whose links are there, one bit a cell.
    std::uint32_t known() const { return known_.load(std::memory_order_acquire); }

    /// Light points whose link along the axis is open; only those of known cells say something.
    std::uint64_t open(std::size_t axis) const { return open_[axis].load(std::memory_order_relaxed); }

    /// Stores the links of one cell. May be called by many threads at once: they all bring the same bits.
    void publish(int cell, const std::array<std::uint64_t, 3>& open) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            open_[axis].fetch_or(open[axis], std::memory_order_relaxed);
        known_.fetch_or(static_cast<std::uint8_t>(1u << cell), std::memory_order_release);
    }

private:
    std::array<std::atomic<std::uint64_t>, 3> open_{};
    std::atomic<std::uint8_t> known_{0};
};

/// 4x4x4 light points.
class Brick {
public:
    Brick(const glm::ivec3& place, BrickTile* tiles) : place_(place), tiles_(tiles) {}

    /// Index of the brick's first light point, over 4.
    const glm::ivec3& place() const { return place_; }
    BrickTile& tile(std::size_t t) const { return tiles_[t]; }

    /// Stores units of a tile as `BrickTile::publish` does, after those of other threads.
    void publish(std::size_t t, std::uint64_t fresh, const std::uint64_t* values, int groups) {
        while (is_publishing_.exchange(true, std::memory_order_acquire))
            std::this_thread::yield();
        tiles_[t].publish(fresh, values, groups);
        is_publishing_.store(false, std::memory_order_release);
    }

    BrickLinks& links() { return links_; }
    const BrickLinks& links() const { return links_; }

    /// What one of the brick's light points reaches, or null if nobody has looked yet.
    const Reach* reach_of(int bit) const {
        const Reach* reach = last_reach();
        while (reach != nullptr && reach->seed_bit() != bit)
            reach = reach->next();
        return reach;
    }
    const Reach* last_reach() const { return last_reach_.load(std::memory_order_acquire); }
    /// By one thread at a time; reach.next() must be `last_reach()`.
    void add_reach(const Reach& reach) { last_reach_.store(&reach, std::memory_order_release); }

private:
    // In this order, and with the end of the links' padding used, a brick has 56 bytes.
    [[no_unique_address]] BrickLinks links_;
    std::atomic<bool> is_publishing_{false};
    glm::ivec3 place_;
    BrickTile* tiles_;
    std::atomic<const Reach*> last_reach_{nullptr};
};

/// The index of a light point in the grid.
inline glm::ivec3 index_of(const Brick& brick, int bit) {
    return brick_side * brick.place() + place_of(bit);
}

}  // namespace lightmesh::detail
