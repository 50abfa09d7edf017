// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/bounds.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/light_shape.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/mesh/scene_change.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/mesh/snapshot_reader.hpp>
#include <lightmesh/support/atomics.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// The parts that may be taken from a snapshot: lights that are the same, and what has nothing to do with
/// boxes that have changed.
struct MergeRules {
    std::span<const Bounds> changed;
    std::vector<bool> same_lights;      ///< for each light of the mesh whether the snapshot has it too
    std::vector<LightChange> lights{};  ///< where something has changed, for each light of the mesh
    bool is_plain_copy = false;  ///< all lights are the same, in the same slots, and nothing has changed
};

/// For each of some lights whether others have the same at its number.
inline std::vector<bool> same_lights(std::span<const Light> mine, std::span<const Light> theirs) {
    std::vector<bool> same(mine.size());
    for (std::size_t i = 0; i < (std::min)(mine.size(), theirs.size()); ++i)
        same[i] = record_of(mine[i]) == record_of(theirs[i]);
    return same;
}

/// Bits that a mesh and a snapshot both know.
struct KnownByBoth {
    std::uint64_t compared = 0;
    std::uint64_t differing = 0;
};

/// Adds what a snapshot, or another mesh, knows of a level and a mesh lacks. `From` is a `SnapshotLevel`, or
/// `KeptBricks`, to which other threads may add meanwhile: what is published by then is copied.
template <class From>
class LevelMerge {
public:
    /// `keeps_lights`: also takes what is known of some lights of a group only.
    LevelMerge(MeshData& data, const From& from, const MergeRules& rules, bool keeps_lights = true)
        : data_(data), from_(from), view_(from.view()), rules_(rules), keeps_lights_(keeps_lights) {}

    void compare(KnownByBoth& known) const {
        const MeshView mine = data_.view();
        from_.for_each_brick([&](const Brick& brick) {
            if (const Brick* own = mine.find_brick(brick.position()))
                compare(mine, *own, brick, known);
        });
    }

    /// Throws std::bad_alloc.
    void add() {
        from_.for_each_brick([&](const Brick& brick) {
            add_tiles(brick);
            if (!near_change(brick, FloodBox::radius(data_.grid().quality()) + 1.0f)) {
                add_floods(brick);
                add_links(brick);
            }
        });
    }

private:
    Bounds box_of(const Brick& brick, float margin) const {
        return widened(bounds_of(data_.grid(), brick.position(), brick.position()),
                       margin * static_cast<float>(data_.grid().step()));
    }

    /// True if a changed box lies within so many steps of a brick.
    bool near_change(const Brick& brick, float margin) const {
        return meets_any(box_of(brick, margin), rules_.changed);
    }

    bool light_counts(const Brick& brick, std::size_t light) const {
        if (!rules_.same_lights[light])
            return false;
        return rules_.changed.empty() || !rules_.lights[light].concerns(box_of(brick, 0.0f));
    }

    /// The knowledge that a snapshot has of a tile of this mesh: units, the lights' bits, what samples told,
    /// and what is known of some lights of groups only.
    std::uint64_t read_tile(const Brick& brick, std::size_t t, BrickWords& lit, UniformLights& samples,
                            KeptLights& kept) const {
        lit.fill(0);
        samples = {};
        kept = {};
        KeptLights theirs;
        std::size_t tile_of_theirs = ~std::size_t{0};
        const LightTable& lights = data_.lights();
        std::uint64_t known = ~std::uint64_t{0};
        std::uint64_t sampled = 0;  // lights
        const auto size = static_cast<std::size_t>(lights.tile_size(t));
        for (std::size_t l = 0; l < size; ++l) {
            const std::size_t light = lights.order().light_at(t * lights_per_tile + l);
            std::uint64_t cells = 0;  // one bit a cell, at its first light point
            if (light_counts(brick, light)) {
                const std::size_t slot = view_.lights->order().slot_of(light);
                const std::size_t their_l = slot % lights_per_tile;
                if (const BrickTile* tile = view_.find_tile(brick, slot / lights_per_tile)) {
                    // Before what is known of groups, into which other threads may put it.
                    if (tile_of_theirs != slot / lights_per_tile)
                        theirs = from_.find_kept(brick, tile_of_theirs = slot / lights_per_tile);
                    cells = (load_acquire(tile->known) >> (their_l / lights_per_group) & every_byte) |
                            theirs.cells_with(their_l);
                    sampled |= ((std::uint64_t{load_acquire(tile->sampled)} >> (their_l / lights_per_group) |
                                 theirs.sampled >> their_l) &
                                1)
                               << l;
                    samples.uniform |= (load_acquire(tile->uniform) >> their_l & 1) << l;
                    samples.lit |= (load_relaxed(tile->lit) >> their_l & 1) << l;
                    for (std::uint64_t rest = cells; rest != 0; rest &= rest - 1) {
                        const int first = std::countr_zero(rest);
                        lit[l] |= static_cast<std::uint64_t>(view_.lit_in_cell(*tile, first / 8, their_l))
                                  << first;
                    }
                }
            }
            const std::size_t group = l / lights_per_group;
            known &= cells << group | ~(every_byte << group);
            for (; cells != 0; cells &= cells - 1)
                kept.cells[static_cast<std::size_t>(std::countr_zero(cells) / 8)] |= std::uint64_t{1} << l;
        }
        for (std::size_t group = (size + 7) / 8; group < 8; ++group)
            known &= ~(every_byte << group);
        kept.sampled = sampled;
        // In the groups that have lights slots without one are dark.
        if (size < lights_per_tile) {
            samples.uniform |= ~std::uint64_t{0} << size;
            sampled |= ~std::uint64_t{0} << size;
        }
        for (std::uint32_t group = 0; 8 * group < size; ++group)
            samples.sampled |= (~sampled >> (8 * group) & 0xff) == 0 ? 1u << group : 0u;
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell)
            kept.cells[cell] &= ~lights_in_cell(known, cell);
        kept.sampled &= ~lights_of_groups(samples.sampled);
        return known;
    }

    template <class Visitor>
    void for_each_tile(const Brick& brick, Visitor&& visit) const {
        BrickWords lit;
        UniformLights samples;
        KeptLights kept;
        for (std::size_t t = 0; t < data_.lights().tile_count(); ++t)
            if (const std::uint64_t known = read_tile(brick, t, lit, samples, kept);
                (known | samples.sampled) != 0 || !kept.is_nothing())
                visit(t, known, lit, samples, kept);
    }

    void compare(const MeshView& mine, const Brick& own, const Brick& theirs, KnownByBoth& sum) const {
        if (rules_.is_plain_copy) {
            for (std::size_t t = 0; t < data_.lights().tile_count(); ++t) {
                const BrickTile* my_tile = mine.find_tile(own, t);
                const BrickTile* their_tile = view_.find_tile(theirs, t);
                if (my_tile != nullptr && their_tile != nullptr)
                    compare_tiles(mine, *my_tile, *their_tile,
                                  static_cast<std::size_t>(data_.lights().tile_size(t)), sum);
            }
            return;
        }
        for_each_tile(theirs, [&](std::size_t t, std::uint64_t known, const BrickWords& lit,
                                  const UniformLights&, const KeptLights&) {
            const BrickTile* tile = mine.find_tile(own, t);
            if (tile == nullptr)
                return;
            for (std::size_t l = 0; l < static_cast<std::size_t>(data_.lights().tile_size(t)); ++l) {
                std::uint64_t both = (known & tile->known) >> (l / lights_per_group) & every_byte;
                for (; both != 0; both &= both - 1) {
                    const int first = std::countr_zero(both);
                    const auto bits = static_cast<std::uint8_t>(lit[l] >> first);
                    sum.compared += 8;
                    sum.differing += static_cast<std::uint64_t>(std::popcount(
                        static_cast<std::uint32_t>(bits ^ mine.lit_in_cell(*tile, first / 8, l))));
                }
            }
        });
    }

    /// Of two tiles with the same lights in the same slots.
    void compare_tiles(const MeshView& mine, const BrickTile& my_tile, const BrickTile& their_tile,
                       std::size_t light_count, KnownByBoth& sum) const {
        const std::uint64_t both = my_tile.known & their_tile.known;
        for (int cell = 0; cell < cells_per_brick; ++cell) {
            const auto c = static_cast<std::size_t>(cell);
            std::uint64_t lights =
                lights_in_cell(both, c) & ~std::uint64_t{0} >> (lights_per_tile - light_count);
            sum.compared += 8 * static_cast<std::uint64_t>(std::popcount(lights));
            if (lights == 0 || holds_same(mine, my_tile, their_tile, c))
                continue;
            for (; lights != 0; lights &= lights - 1) {
                const auto l = static_cast<std::size_t>(std::countr_zero(lights));
                sum.differing += static_cast<std::uint64_t>(std::popcount(static_cast<std::uint32_t>(
                    mine.lit_in_cell(my_tile, cell, l) ^ view_.lit_in_cell(their_tile, cell, l))));
            }
        }
    }

    /// True if a cell is stored alike in both: then it has the same values.
    bool holds_same(const MeshView& mine, const BrickTile& my_tile, const BrickTile& their_tile,
                    std::size_t cell) const {
        const CellIndex my_cell{my_tile.cells[cell]};
        const CellIndex their_cell{their_tile.cells[cell]};
        if (my_tile.uniform != their_tile.uniform || my_tile.lit != their_tile.lit)
            return false;
        if (my_cell.is_nothing() || their_cell.is_nothing() || my_cell.is_words() != their_cell.is_words())
            return my_cell.is_nothing() && their_cell.is_nothing();
        if (!my_cell.is_words())
            return mine.rows[my_cell.index()].bytes == view_.rows[their_cell.index()].bytes;
        const std::uint64_t* my_words = &mine.words[my_cell.index()];
        const std::uint64_t* their_words = &view_.words[their_cell.index()];
        const std::size_t size = words_of_cell(my_words);
        return size == words_of_cell(their_words) && std::equal(my_words, my_words + size, their_words);
    }

    void add_tiles(const Brick& brick) {
        if (rules_.is_plain_copy) {
            const Brick& own = data_.find_or_make_brick(brick.position());
            bool all_copied = true;
            for (std::size_t t = 0; t < data_.lights().tile_count(); ++t)
                if (const BrickTile* tile = view_.find_tile(brick, t))
                    all_copied &= data_.publish_copy(own, t, view_, *tile);
            if (all_copied)
                return;
        }
        for_each_tile(brick, [&](std::size_t t, std::uint64_t known, const BrickWords& lit,
                                 const UniformLights& samples, const KeptLights& kept) {
            const Brick& own = data_.find_or_make_brick(brick.position());
            if ((known | samples.sampled) != 0)
                data_.publish(own, t, known, lit, samples);
            if (keeps_lights_ && !kept.is_nothing())
                data_.keep_lights(own, t, kept, lit, samples);
        });
    }

    void add_links(const Brick& brick) {
        const std::uint8_t known = load_acquire(brick.links_known);
        if (known == 0)
            return;
        const Brick& own = data_.find_or_make_brick(brick.position());
        for (int cell = 0; cell < cells_per_brick; ++cell) {
            if ((known >> cell & 1) == 0 || (own.links_known >> cell & 1) != 0)
                continue;
            const std::uint64_t in_cell = std::uint64_t{0xff} << (8 * cell);
            data_.publish_links(own, cell,
                                {load_relaxed(brick.links[0]) & in_cell,
                                 load_relaxed(brick.links[1]) & in_cell,
                                 load_relaxed(brick.links[2]) & in_cell});
        }
    }

    void add_floods(const Brick& brick) {
        const std::size_t slots = FloodBox::slots(data_.grid().quality());
        for (std::uint32_t flood = load_acquire(brick.floods); flood != 0;) {
            const FloodView view(&view_.words[flood - 1]);
            data_.publish_flood(data_.find_or_make_brick(brick.position()), view, slots);
            flood = view.next();
        }
    }

    MeshData& data_;
    const From& from_;
    MeshView view_;
    const MergeRules& rules_;
    bool keeps_lights_;
};

/// Those bricks of a mesh for which keep(brick) holds.
template <class Keep>
class KeptBricks {
public:
    KeptBricks(const MeshData& data, Keep keep) : data_(data), keep_(std::move(keep)) {}

    MeshView view() const { return data_.view(); }
    KeptLights find_kept(const Brick& brick, std::size_t t) const { return data_.find_kept(brick, t); }
    template <class Visitor>
    void for_each_brick(Visitor&& visit) const {
        data_.for_each_brick([&](const Brick& brick) {
            if (keep_(brick))
                visit(brick);
        });
    }

private:
    const MeshData& data_;
    Keep keep_;
};

/// Adds what a mesh knows to another one that knows nothing yet, of the lights that both have and the bricks
/// for which keep(brick) holds: with nothing left of what was forgotten or superseded. `keeps_lights`: as
/// `LevelMerge`. Throws std::bad_alloc.
template <class Keep>
void copy_level(const MeshData& from, MeshData& to, const Keep& keep, bool keeps_lights = true) {
    const MergeRules rules{.changed = {}, .same_lights = same_lights(to.user_lights(), from.user_lights())};
    const KeptBricks kept(from, keep);
    // Also those of which nothing is known: queries have asked for them, and found that they need no more.
    kept.for_each_brick([&](const Brick& brick) {
        store_relaxed(to.find_or_make_brick(brick.position()).used, load_relaxed(brick.used));
    });
    to.set_frame(from.frame());
    LevelMerge(to, kept, rules, keeps_lights).add();
}

/// Adds what a snapshot knows and a mesh lacks, level by level. Throws std::invalid_argument, before anything
/// has changed, if it is of another mesh, or if more than one in 1,000 of the bits that both know differ;
/// std::bad_alloc.
template <class Levels>
class Merge {
public:
    Merge(const Levels& levels, const SnapshotReader& from, LongTest long_tests,
          std::span<const Bounds> changed)
        : levels_(levels), from_(from), rules_{.changed = changed, .same_lights = {}} {
        check_changed(changed);
        check_same_grid(long_tests);
        find_same_lights();
    }

    void run() {
        check_same_scene();
        from_.for_each([&](int k, const SnapshotLevel& level) {
            if (level.parts().bricks.empty())
                return;
            MeshData& mine = levels_.level(k).data();
            if (rules_.is_plain_copy && mine.is_untouched())
                mine.restore(level.parts());
            else
                LevelMerge<SnapshotLevel>(mine, level, rules_).add();
        });
    }

private:
    const MeshData& data() const { return levels_.finest().data(); }

    /// Then the grids of all other levels are the same, too.
    void check_same_grid(LongTest long_tests) const {
        const Grid& mine = data().grid();
        const Grid& theirs = from_.finest().grid();
        const auto refuse = [](const std::string& what) {
            throw std::invalid_argument("lightmesh: the snapshot is of another mesh: " + what);
        };
        if (mine.radius() != theirs.radius() || mine.quality() != theirs.quality() ||
            mine.origin() != theirs.origin())
            refuse("its radius is " + to_text(theirs.radius()) + ", its quality " +
                   to_text(theirs.quality()) + " and its origin " + to_text(glm::vec3(theirs.origin())) +
                   ", where this mesh has " + to_text(mine.radius()) + ", " + to_text(mine.quality()) +
                   " and " + to_text(glm::vec3(mine.origin())));
        if (long_tests != from_.long_tests())
            refuse("its long tests are of another kind");
        if (data().is_adaptive() != from_.settings().adaptive_long_tests)
            refuse(data().is_adaptive() ? "its long tests were all traced, where this mesh has adaptive ones"
                                        : "its long tests are adaptive, where this mesh traces all");
    }

    /// Lights keep their numbers.
    void find_same_lights() {
        const auto mine = data().user_lights();
        const auto theirs = from_.user_lights();
        rules_.same_lights = same_lights(mine, theirs);
        if (!rules_.changed.empty()) {
            const std::vector<LightSight> sights = levels_.sights();
            for (std::size_t i = 0; i < mine.size(); ++i) {
                rules_.lights.emplace_back(shape_of(mine[i]), sights[i], rules_.changed);
                if (sights[i].fits_scene)
                    rules_.same_lights[i] = false;
            }
        }
        // A mesh whose lights have moved has them in other slots than one that is made of them.
        rules_.is_plain_copy = mine.size() == theirs.size() && rules_.changed.empty() &&
                               data().lights().order() == from_.lights().order() &&
                               std::ranges::all_of(rules_.same_lights, [](bool is_same) { return is_same; });
    }

    void check_same_scene() const {
        KnownByBoth known;
        from_.for_each([&](int k, const SnapshotLevel& level) {
            if (const auto* own = levels_.find(k); own != nullptr && own->data().knows_anything())
                LevelMerge<SnapshotLevel>(own->data(), level, rules_).compare(known);
        });
        if (1000 * known.differing > known.compared)
            throw std::invalid_argument("lightmesh: the snapshot is not of the same scene: of " +
                                        std::to_string(known.compared) + " visibilities that both know " +
                                        std::to_string(known.differing) + " differ");
    }

    const Levels& levels_;
    const SnapshotReader& from_;
    MergeRules rules_;
};

}  // namespace lightmesh::detail
