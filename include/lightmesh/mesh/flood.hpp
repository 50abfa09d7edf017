// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

/// The linked short test. P tests one light point by a ray, the nearest that it sees: the seed. What the seed
/// reaches over open links counts as visible from P: every step leads away from the seed, along x, y or z.
/// That depends on the seed alone, so it is found once for each light point that becomes a seed, and kept.

namespace lightmesh::detail {

/// The bricks around a seed that hold light points within reach: a cube of them.
struct ReachBox {
    static constexpr int max_side = 10;
    static constexpr std::size_t max_slots = max_side * max_side * max_side;

    glm::ivec3 first;  // index of the first brick
    int side;

    /// `seed` is the index of a light point, `quality` that of the grid.
    ReachBox(const glm::ivec3& seed, float quality) {
        const int steps = static_cast<int>(radius(quality));
        first = {(seed.x - steps) >> 2, (seed.y - steps) >> 2, (seed.z - steps) >> 2};
        side = side_of(quality);
    }

    /// How far links are followed, in steps. A hemisphere lies within q of its surface point, and an even
    /// seed (see `SeedCandidates`) within one step of that.
    static float radius(float quality) { return quality + 1.0f; }

    /// 2 n + 1 light points in a row touch up to so many bricks.
    static int side_of(float quality) { return (2 * static_cast<int>(radius(quality)) + 3) / 4 + 1; }
    static std::size_t slots(float quality) {
        const auto side = static_cast<std::size_t>(side_of(quality));
        return side * side * side;
    }

    bool contains(const glm::ivec3& brick) const {
        const glm::ivec3 p = brick - first;
        return p.x >= 0 && p.x < side && p.y >= 0 && p.y < side && p.z >= 0 && p.z < side;
    }
    std::size_t slot(const glm::ivec3& brick) const {
        const glm::ivec3 p = brick - first;
        return static_cast<std::size_t>(p.x + side * (p.y + side * p.z));
    }
};

/// What a seed reaches: for each brick of its box all light points, none, or those of a mask. Never changes.
class Reach {
public:
    /// Where it is to be built: 8-byte words, uninitialised.
    static std::size_t words_needed(std::size_t slots, std::size_t masks) {
        return sizeof(Reach) / 8 + 2 * mask_words(slots) + masks;
    }

    /// reached[slot] of the light points of interest in asked[slot], for each slot of the box; `memory` has
    /// room as `words_needed` says for `count_masks` masks. `next` is the brick's reach made before this one.
    static const Reach* build(std::uint64_t* memory, int seed_bit, std::span<const std::uint64_t> reached,
                              std::span<const std::uint64_t> asked, const Reach* next) {
        const std::size_t slots = reached.size();
        Reach* made = std::construct_at(reinterpret_cast<Reach*>(memory), seed_bit, next);
        const std::size_t words = mask_words(slots);
        std::uint64_t* full = memory + sizeof(Reach) / 8;
        std::uint64_t* partial = full + words;
        std::uint64_t* masks = partial + words;
        std::fill_n(full, 2 * words, std::uint64_t{0});
        for (std::size_t slot = 0; slot < slots; ++slot) {
            const std::uint64_t bit = std::uint64_t{1} << (slot % 64);
            if (is_partial(reached[slot], asked[slot])) {
                partial[slot / 64] |= bit;
                *masks++ = reached[slot];
            } else if (reached[slot] != 0) {
                full[slot / 64] |= bit;
            }
        }
        return made;
    }

    static std::size_t count_masks(std::span<const std::uint64_t> reached,
                                   std::span<const std::uint64_t> asked) {
        std::size_t count = 0;
        for (std::size_t slot = 0; slot < reached.size(); ++slot)
            count += is_partial(reached[slot], asked[slot]) ? 1u : 0u;
        return count;
    }

    Reach(int seed_bit, const Reach* next) : next_(next), seed_bit_(seed_bit) {}

    const Reach* next() const { return next_; }
    /// The number of the seed within its brick.
    int seed_bit() const { return seed_bit_; }

    /// The light points that are reached in a slot of a box with so many. Those farther than
    /// `ReachBox::radius` from the seed go with the others of their brick, or are left out.
    std::uint64_t in_slot(std::size_t slot, std::size_t slots) const {
        const std::size_t words = mask_words(slots);
        const auto* full = reinterpret_cast<const std::uint64_t*>(this + 1);
        const std::uint64_t* partial = full + words;
        const std::uint64_t bit = std::uint64_t{1} << (slot % 64);
        if ((full[slot / 64] & bit) != 0)
            return ~std::uint64_t{0};
        if ((partial[slot / 64] & bit) == 0)
            return 0;
        int rank = std::popcount(partial[slot / 64] & (bit - 1));
        for (std::size_t word = 0; word < slot / 64; ++word)
            rank += std::popcount(partial[word]);
        return partial[words + static_cast<std::size_t>(rank)];
    }

private:
    static std::size_t mask_words(std::size_t slots) { return (slots + 63) / 64; }
    static bool is_partial(std::uint64_t reached, std::uint64_t asked) {
        return reached != 0 && reached != asked;
    }

    const Reach* next_;
    alignas(8) int seed_bit_;
};

}  // namespace lightmesh::detail
