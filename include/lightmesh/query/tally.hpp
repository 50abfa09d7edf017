// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/query/kernels/kernel_types.hpp>
#include <lightmesh/query/neighbours.hpp>
#include <lightmesh/support/atomics.hpp>
#include <lightmesh/support/popcount.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

/// The sum of equation (3).

namespace lightmesh::detail {

/// The difference of two interpolation sets of one `BrickWindow` in a brick.
struct BrickChange {
    const Brick* brick;
    std::uint64_t added;
    std::uint64_t removed;
};

/// Writes how `after` differs from `before` to `changes`, which has room for the entries of both; both are in
/// the order of slots. Returns how many there are.
inline std::size_t find_changes(std::span<const BrickPoints> before, std::span<const BrickPoints> after,
                                BrickChange* changes) {
    const BrickPoints* b = before.data();
    const BrickPoints* const end_b = b + before.size();
    const BrickPoints* a = after.data();
    const BrickPoints* const end_a = a + after.size();
    BrickChange* change = changes;
    // Without branches: which of the sets has the next brick is as good as random.
    while (b != end_b && a != end_a) {
        const bool is_in_before = b->slot <= a->slot;
        const bool is_in_after = a->slot <= b->slot;
        const std::uint64_t old_points = b->points & (0 - std::uint64_t{is_in_before});
        const std::uint64_t new_points = a->points & (0 - std::uint64_t{is_in_after});
        *change = {(is_in_after ? a : b)->brick, new_points & ~old_points, old_points & ~new_points};
        change += old_points != new_points ? 1 : 0;
        b += is_in_before ? 1 : 0;
        a += is_in_after ? 1 : 0;
    }
    for (; b != end_b; ++b)
        *change++ = {b->brick, 0, b->points};
    for (; a != end_a; ++a)
        *change++ = {a->brick, a->points, 0};
    return static_cast<std::size_t>(change - changes);
}

/// For each light of a tile the number of light points of a set that see it. A set that differs little from
/// the one before is counted by what differs: the sums are of integers, and so the same.
class Tally {
public:
    Tally(const MeshView& mesh, const Kernels& kernels, std::size_t tile)
        : mesh_(mesh), kernels_(kernels), tile_(tile) {}

    /// Lights of unknown groups get numbers that mean nothing.
    const std::uint16_t* counts() const { return counts_.data(); }

    /// Must come first. Until then nothing is written: of thousands of lights with ranges few tiles reach a
    /// point.
    void start_anew() {
        if (!has_begun_) {
            has_begun_ = true;
            forget();
        }
        counts_.fill(0);
        added_.clear();
        removed_.clear();
        missing_ = 0;
    }

    /// `groups` has a bit for each group of lights whose counts are wanted: see `knows_all`.
    void add(const Brick& brick, std::uint64_t points, std::uint32_t groups) {
        gather(brick, points, groups, added_);
    }
    void remove(const Brick& brick, std::uint64_t points) { gather(brick, points, 0, removed_); }

    /// True if all that was wanted of what was added was known when it was looked up; else `forget` and
    /// `start_anew` must come next.
    bool knows_all() const { return missing_ == 0; }
    /// Looks all up again.
    void forget() { bricks_.fill(nullptr); }

    /// Must be called before the counts are read.
    void finish() {
        flush(added_, false);
        flush(removed_, true);
    }

private:
    static constexpr std::size_t capacity = 128;

    /// Cells that are yet to be counted.
    struct Cells {
        std::array<RowPoints, capacity + cells_per_brick> rows;
        std::array<WordPoints, capacity + cells_per_brick + 1> words;
        std::size_t row_count = 0;
        std::size_t word_count = 0;

        void clear() {
            row_count = 0;
            word_count = 0;
        }
    };

    /// A brick whose tile was looked up. Masks have one bit a cell, at its first light point.
    struct KnownBrick {
        const BrickTile* tile;
        std::uint64_t units;      ///< `BrickTile::known` before any of its cells was looked up
        std::uint64_t looked_up;  ///< cells
        std::uint64_t in_rows;    ///< of these those kept in a `CellRow`
        std::uint64_t in_words;   ///< and those kept in words; the others hold nothing of their own
        std::array<const void*, cells_per_brick> cells;
    };

    /// Null if nothing of the tile is known.
    KnownBrick* find(const Brick& brick) {
        const std::size_t at = reinterpret_cast<std::uintptr_t>(&brick) / 16 % known_.size();
        KnownBrick& known = known_[at];
        if (bricks_[at] != &brick) {
            const BrickTile* const tile = mesh_.find_tile(brick, tile_);
            if (tile == nullptr)
                return nullptr;
            bricks_[at] = &brick;
            known.tile = tile;
            known.units = load_acquire(tile->known);
            known.looked_up = known.in_rows = known.in_words = 0;
        }
        return &known;
    }

    void look_up(KnownBrick& known, std::uint64_t cells) const {
        known.looked_up |= cells;
        for (std::uint64_t rest = cells; rest != 0; rest &= rest - 1) {
            const auto cell = static_cast<std::size_t>(std::countr_zero(rest) / 8);
            const CellIndex at{load_acquire(known.tile->cells[cell])};
            if (at.is_nothing())
                continue;
            if (at.is_words()) {
                known.in_words |= rest & (~rest + 1);
                known.cells[cell] = &mesh_.words[at.index()];
            } else {
                known.in_rows |= rest & (~rest + 1);
                known.cells[cell] = mesh_.rows[at.index()].bytes.data();
            }
        }
    }

    void gather(const Brick& brick, std::uint64_t points, std::uint32_t groups, Cells& cells) {
        if (points == 0)
            return;
        const std::uint64_t units = cells_in(points) & every_byte;
        KnownBrick* const known = find(brick);
        if (known == nullptr) {
            missing_ |= groups;
            return;
        }
        missing_ |= units * groups & ~known->units;
        if (const std::uint64_t fresh = units & ~known->looked_up; fresh != 0)
            look_up(*known, fresh);
        RowPoints* row = cells.rows.data() + cells.row_count;
        for (std::uint64_t rest = units & known->in_rows; rest != 0; rest &= rest - 1) {
            const auto first = static_cast<unsigned>(std::countr_zero(rest));
            *row++ = {static_cast<const std::uint8_t*>(known->cells[first / 8]),
                      static_cast<std::uint8_t>(points >> first)};
        }
        cells.row_count = static_cast<std::size_t>(row - cells.rows.data());
        for (std::uint64_t rest = units & known->in_words; rest != 0; rest &= rest - 1) {
            const auto first = static_cast<unsigned>(std::countr_zero(rest));
            const auto* record = static_cast<const std::uint64_t*>(known->cells[first / 8]);
            const auto in_cell = static_cast<std::uint8_t>(points >> first);
            cells.words[cells.word_count++] = {record[0], record[1] != 0 ? record + 1 : nullptr, in_cell,
                                               static_cast<std::uint8_t>(popcount(in_cell))};
        }
        const std::uint64_t uniform = points & ~((known->in_rows | known->in_words) * 0xff);
        if (const std::uint64_t lit = load_relaxed(known->tile->lit); uniform != 0 && lit != 0)
            cells.words[cells.word_count++] = {lit, nullptr, 0, static_cast<std::uint8_t>(popcount(uniform))};
        if (cells.row_count > capacity || cells.word_count > capacity)
            flush(cells, &cells == &removed_);
    }

    void flush(Cells& cells, bool subtract) {
        if (cells.row_count != 0)
            kernels_.add_rows(cells.rows.data(), cells.row_count, subtract, counts_.data());
        if (cells.word_count != 0)
            kernels_.add_words(cells.words.data(), cells.word_count, subtract, counts_.data());
        cells.clear();
    }

    const MeshView& mesh_;
    const Kernels& kernels_;
    std::size_t tile_;
    bool has_begun_ = false;
    std::uint64_t missing_ = 0;            ///< units that are wanted but not known
    std::array<const Brick*, 64> bricks_;  ///< of `known_`, or null
    std::array<KnownBrick, 64> known_;
    alignas(64) std::array<std::uint16_t, lights_per_tile> counts_;
    Cells added_;
    Cells removed_;
};

/// The number of light points of a set that see one light, in slot l of a tile; its group must be known.
inline int count_lit(const MeshView& mesh, std::span<const BrickPoints> entries, std::size_t tile,
                     std::size_t l) {
    int lit = 0;
    for (const BrickPoints& entry : entries) {
        const BrickTile* known = mesh.find_tile(*entry.brick, tile);
        for (std::uint64_t rest = cells_in(entry.points) & every_byte; rest != 0; rest &= rest - 1) {
            const int first = std::countr_zero(rest);
            const auto points = static_cast<std::uint32_t>(entry.points >> first & 0xff);
            lit += std::popcount(mesh.lit_in_cell(*known, first / 8, l) & points);
        }
    }
    return lit;
}

}  // namespace lightmesh::detail
