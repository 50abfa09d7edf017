// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/support/atomics.hpp>
#include <lightmesh/support/popcount.hpp>

#include <glm/vec3.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

/// The linked short test. P tests one light point by a ray: the seed. What the seed's flood reaches over open
/// links counts as visible from P: every step leads away from the seed, along x, y or z. That depends on the
/// seed alone, so it is found once for each light point that becomes a seed, and kept with its brick.

namespace lightmesh::detail {

/// The bricks around a seed that hold light points within reach: a cube of them.
struct FloodBox {
    static constexpr int max_side = 10;
    static constexpr std::size_t max_slots = max_side * max_side * max_side;

    glm::ivec3 first;  ///< coordinates of the first brick
    int side;

    FloodBox(const glm::ivec3& seed, float quality) {
        const int steps = static_cast<int>(radius(quality));
        first = brick_of(seed - steps);
        side = side_of(quality);
    }

    /// The distance over which links are followed, in steps. A hemisphere lies within q of its surface point,
    /// and an even seed (see `SeedCandidates`) within one step of that.
    static constexpr float radius(float quality) { return quality + 1.0f; }

    /// 2 n + 1 light points in a row touch up to so many bricks.
    static int side_of(float quality) { return (2 * static_cast<int>(radius(quality)) + 3) / 4 + 1; }
    static std::size_t slots(float quality) {
        const auto side = static_cast<std::size_t>(side_of(quality));
        return side * side * side;
    }

    bool contains(const glm::ivec3& brick_coord) const {
        const glm::ivec3 p = brick_coord - first;
        return p.x >= 0 && p.x < side && p.y >= 0 && p.y < side && p.z >= 0 && p.z < side;
    }
    std::size_t slot(const glm::ivec3& brick_coord) const {
        const glm::ivec3 p = brick_coord - first;
        return static_cast<std::size_t>(p.x + side * (p.y + side * p.z));
    }
};

/// The light points that a seed reaches: for each brick of its box all light points, none, or those of a
/// mask. Words:
///
///     seed's number in its brick << 32 | index plus one of the next flood of the brick
///     a bit for each slot whose light points are all reached       } `bit_words` each
///     a bit for each slot of which some are reached                }
///     a mask for each of the latter
class FloodView {
public:
    explicit FloodView(const std::uint64_t* record) : record_(record) {}

    static std::size_t bit_words(std::size_t slots) { return (slots + 63) / 64; }

    int seed_bit() const { return static_cast<int>(record_[0] >> 32); }
    std::uint32_t next() const { return static_cast<std::uint32_t>(record_[0]); }

    /// Words of a flood in a box with so many slots.
    std::size_t size(std::size_t slots) const {
        const std::size_t words = bit_words(slots);
        std::size_t sum = 1 + 2 * words;
        for (std::size_t w = 0; w < words; ++w)
            sum += static_cast<std::size_t>(std::popcount(record_[1 + words + w]));
        return sum;
    }

    /// True if it names slots of a box with so many only, and none as both full and partial.
    bool has_slots(std::size_t slots) const {
        const std::size_t words = bit_words(slots);
        const std::uint64_t beyond = slots % 64 == 0 ? 0 : ~std::uint64_t{0} << (slots % 64);
        for (std::size_t w = 0; w < words; ++w)
            if ((record_[1 + w] & record_[1 + words + w]) != 0)
                return false;
        return ((record_[words] | record_[2 * words]) & beyond) == 0;
    }

    const std::uint64_t* words() const { return record_; }

    /// The light points that are reached in a slot of a box with so many. Those farther than
    /// `FloodBox::radius` from the seed go with the others of their brick, or are left out.
    std::uint64_t in_slot(std::size_t slot, std::size_t slots) const {
        const std::size_t words = bit_words(slots);
        const std::uint64_t* full = record_ + 1;
        const std::uint64_t* partial = full + words;
        const std::uint64_t bit = std::uint64_t{1} << (slot % 64);
        if ((full[slot / 64] & bit) != 0)
            return ~std::uint64_t{0};
        if ((partial[slot / 64] & bit) == 0)
            return 0;
        int rank = popcount(partial[slot / 64] & (bit - 1));
        for (std::size_t word = 0; word < slot / 64; ++word)
            rank += popcount(partial[word]);
        return partial[words + static_cast<std::size_t>(rank)];
    }

private:
    const std::uint64_t* record_;
};

/// Index plus one of the flood of a brick's light point; 0 if nobody has looked yet.
inline std::uint32_t find_flood(const MeshView& mesh, const Brick& brick, int seed_bit) {
    std::uint32_t flood = load_acquire(brick.floods);
    while (flood != 0) {
        const FloodView view(&mesh.words[flood - 1]);
        if (view.seed_bit() == seed_bit)
            break;
        flood = view.next();
    }
    return flood;
}

/// The words that a flood needs, and writing them: reached[slot] of the light points of interest in
/// asked[slot], for each slot of the box.
class FloodRecord {
public:
    FloodRecord(std::span<const std::uint64_t> reached, std::span<const std::uint64_t> asked)
        : reached_(reached), asked_(asked) {}

    std::size_t size() const {
        std::size_t sum = 1 + 2 * FloodView::bit_words(reached_.size());
        for (std::size_t slot = 0; slot < reached_.size(); ++slot)
            sum += is_partial(slot) ? 1u : 0u;
        return sum;
    }

    /// Into zeroed words.
    void write(std::uint64_t* record, int seed_bit, std::uint32_t next) const {
        const std::size_t words = FloodView::bit_words(reached_.size());
        std::uint64_t* full = record + 1;
        std::uint64_t* partial = full + words;
        std::uint64_t* masks = partial + words;
        record[0] = static_cast<std::uint64_t>(seed_bit) << 32 | next;
        for (std::size_t slot = 0; slot < reached_.size(); ++slot) {
            const std::uint64_t bit = std::uint64_t{1} << (slot % 64);
            if (is_partial(slot)) {
                partial[slot / 64] |= bit;
                *masks++ = reached_[slot];
            } else if (reached_[slot] != 0) {
                full[slot / 64] |= bit;
            }
        }
    }

private:
    bool is_partial(std::size_t slot) const { return reached_[slot] != 0 && reached_[slot] != asked_[slot]; }

    std::span<const std::uint64_t> reached_;
    std::span<const std::uint64_t> asked_;
};

}  // namespace lightmesh::detail
