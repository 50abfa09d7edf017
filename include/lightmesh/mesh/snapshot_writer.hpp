// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/merge.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/mesh/region_table.hpp>
#include <lightmesh/mesh/snapshot_block.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/support/atomics.hpp>
#include <lightmesh/support/prefetch.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace lightmesh::detail {

using SnapshotWriter = BlockWriter<SnapshotHeader, LightRecord, SnapshotLevelRecord, std::uint32_t, Region,
                                   Brick, std::uint32_t, BrickTile, CellRow, std::uint64_t>;

/// The number of structs that the levels have so far, of each section of which they have a part.
inline std::array<std::uint64_t, level_section_count> level_counts(const SnapshotWriter& block) {
    std::array<std::uint64_t, level_section_count> counts;
    std::copy_n(block.counts().begin() + first_level_section, level_section_count, counts.begin());
    return counts;
}

/// Copies what a level knows to the ends of a block's sections. Other threads may add to it meanwhile: what
/// is published by then is copied, and never half of something.
class LevelCopy {
public:
    LevelCopy(const MeshData& data, SnapshotWriter& block)
        : mesh_(data.view()), tile_count_(mesh_.lights->tile_count()),
          flood_slots_(FloodBox::slots(mesh_.grid->quality())), block_(block), first_(level_counts(block)) {}

    /// Throws std::bad_alloc.
    void run() {
        std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
        for (std::uint64_t i = 0; i < mesh_.region_table.size; ++i)
            if (const std::uint32_t region = load_acquire(mesh_.region_table.slots[i]); region != 0)
                order.emplace_back(mesh_.regions[region - 1].key, region - 1);
        std::ranges::sort(order);
        const std::size_t slot_count = slots_for(order.size());
        const RegionTable table{block_.extend<region_slots_section>(slot_count), slot_count};
        for (std::uint32_t i = 0; i < order.size(); ++i)
            table.insert(order[i].first, i + 1);
        for (const auto& [key, index] : order)
            copy_region(mesh_.regions[index]);
    }

    static std::size_t slots_for(std::size_t regions) { return std::bit_ceil(2 * regions + 2); }

private:
    /// The number of a section's structs that are the level's own by now.
    template <SnapshotSectionName section>
    std::uint32_t size_of() const {
        return static_cast<std::uint32_t>(block_.counts()[section] - first_[section - first_level_section]);
    }

    /// In rounds, each of which has fetched from memory what the next one reads: bricks lie there in the
    /// order in which somebody asked for them.
    void copy_region(const Region& region) {
        bricks_.clear();
        for (std::size_t slot = 0; slot < region.bricks.size(); ++slot)
            if (const std::uint32_t brick = load_acquire(region.bricks[slot]); brick != 0) {
                bricks_.emplace_back(slot, &mesh_.bricks[brick - 1]);
                prefetch(bricks_.back().second);
            }
        for (const auto& [slot, brick] : bricks_)
            for (std::size_t t = 0; t < tile_count_; ++t)
                prefetch(mesh_.find_tile(*brick, t));
        for (const auto& [slot, brick] : bricks_)
            for (std::size_t t = 0; t < tile_count_; ++t)
                if (const BrickTile* tile = mesh_.find_tile(*brick, t))
                    prefetch_cells(*tile);
        Region copied{region.key, {}};
        for (const auto& [slot, brick] : bricks_)
            copied.bricks[slot] = copy_brick(*brick);
        block_.add<regions_section>(copied);
    }

    /// Cells that were found together lie side by side.
    void prefetch_cells(const BrickTile& tile) const {
        for (const std::uint32_t& cell : tile.cells) {
            const CellIndex at{load_acquire(cell)};
            if (at.is_words()) {
                prefetch(&mesh_.words[at.index()]);
                return;
            }
        }
    }

    /// Index plus one of the copy.
    std::uint32_t copy_brick(const Brick& brick) {
        const std::uint32_t tiles = copy_tiles(brick);
        const std::uint32_t floods = copy_floods(brick);
        Brick& copied = *block_.extend<bricks_section>(1);
        copied.coord = brick.coord;
        copied.links_known = load_acquire(brick.links_known);
        const std::uint64_t linked = points_of_cells(copied.links_known);
        for (std::size_t axis = 0; axis < 3; ++axis)
            copied.links[axis] = load_relaxed(brick.links[axis]) & linked;
        copied.tiles = tiles;
        copied.floods = floods;
        return size_of<bricks_section>();
    }

    /// `Brick::tiles` of the copy.
    std::uint32_t copy_tiles(const Brick& brick) {
        if (tile_count_ == 1)
            return copy_tile(mesh_.find_tile(brick, 0));
        const std::uint32_t first = size_of<tile_indices_section>();
        for (std::size_t t = 0; t < tile_count_; ++t)
            block_.add<tile_indices_section>(copy_tile(mesh_.find_tile(brick, t)));
        return first;
    }

    /// Index plus one of the copy; 0 if nothing is known.
    std::uint32_t copy_tile(const BrickTile* tile) {
        if (tile == nullptr)
            return 0;
        const std::uint64_t known = load_acquire(tile->known);
        const std::uint32_t sampled = load_acquire(tile->sampled);
        if ((known | sampled) == 0)
            return 0;
        BrickTile& copied = *block_.extend<tiles_section>(1);
        copied.known = known;
        copied.sampled = sampled;
        copied.uniform = load_relaxed(tile->uniform) & lights_of_groups(sampled);
        copied.lit = load_relaxed(tile->lit) & copied.uniform;
        const std::uint32_t index = size_of<tiles_section>();
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell) {
            const CellIndex at{load_acquire(tile->cells[cell])};
            if (!at.is_nothing() && (known >> (8 * cell) & 0xff) != 0) {
                const CellIndex copy = copy_cell(at);  // may move the tile
                level_tiles()[index - 1].cells[cell] = copy.value;
            }
        }
        return index;
    }

    /// The level's own.
    BrickTile* level_tiles() {
        return block_.all<tiles_section>() + first_[tiles_section - first_level_section];
    }

    CellIndex copy_cell(CellIndex at) {
        if (!at.is_words()) {
            block_.add<rows_section>(mesh_.rows[at.index()]);
            return CellIndex::row(size_of<rows_section>() - 1);
        }
        const CellIndex copied = CellIndex::words(size_of<words_section>());
        const std::uint64_t* record = &mesh_.words[at.index()];
        copy_words(record, words_of_cell(record));
        return copied;
    }

    std::uint64_t* copy_words(const std::uint64_t* record, std::size_t size) {
        std::uint64_t* const copied = block_.extend<words_section>(size);
        // Most are two or three: a loop over them takes less than a call.
        for (std::size_t i = 0; i < size; ++i)
            copied[i] = record[i];
        return copied;
    }

    /// Index plus one of the last copy; in the order of the seeds.
    std::uint32_t copy_floods(const Brick& brick) {
        floods_.clear();
        for (std::uint32_t flood = load_acquire(brick.floods); flood != 0;) {
            const std::uint64_t* record = &mesh_.words[flood - 1];
            floods_.emplace_back(FloodView(record).seed_bit(), record);
            flood = FloodView(record).next();
        }
        std::ranges::sort(floods_);
        std::uint32_t last = 0;
        for (const auto& [seed_bit, record] : floods_) {
            const std::uint32_t index = size_of<words_section>();
            copy_words(record, FloodView(record).size(flood_slots_))[0] =
                static_cast<std::uint64_t>(seed_bit) << 32 | last;
            last = index + 1;
        }
        return last;
    }

    MeshView mesh_;
    std::size_t tile_count_;
    std::size_t flood_slots_;
    SnapshotWriter& block_;
    std::array<std::uint64_t, level_section_count> first_;
    std::vector<std::pair<std::size_t, const Brick*>> bricks_;  ///< of a region, by their slots
    std::vector<std::pair<int, const std::uint64_t*>> floods_;
};

/// One block of all that the levels of a mesh know. Throws std::bad_alloc.
template <class Levels>
std::vector<std::byte> write_snapshot(const Levels& levels, LongTest long_tests) {
    const MeshData& finest = levels.finest().data();
    const std::vector<LightRecord> lights = records_of(finest.user_lights());
    SnapshotWriter::Counts room{};
    room[lights_section] = lights.size();
    const auto for_each = [&](auto&& visit) {
        levels.for_each([&](int k, const auto& level) {
            if (k == 0 || level.data().knows_anything())
                visit(k, level.data());
        });
    };
    for_each([&](int k, const MeshData& data) {
        const MeshData::Counts counts = data.counts();
        room[levels_section] += k != 0 ? 1u : 0u;
        room[region_slots_section] += LevelCopy::slots_for(counts.regions);
        room[regions_section] += counts.regions;
        room[bricks_section] += counts.bricks;
        room[tile_indices_section] += counts.tile_indices;
        room[tiles_section] += counts.tiles;
        room[rows_section] += counts.rows;
        room[words_section] += counts.words;
    });
    SnapshotWriter block(room);
    std::ranges::copy(lights, block.extend<lights_section>(lights.size()));
    for_each([&](int k, const MeshData& data) {
        if (k != 0)
            block.add<levels_section>({static_cast<std::uint64_t>(k), level_counts(block)});
        // As the reader will expect lights in the order of a mesh that is made of them.
        if (data.was_updated()) {
            MeshData copy(data.user_lights(), data.settings(), data.grid());
            copy_level(
                data, copy, [](const Brick&) { return true; }, false);
            LevelCopy(copy, block).run();
        } else {
            LevelCopy(data, block).run();
        }
    });
    const Settings& settings = finest.settings();
    const glm::dvec3& origin = finest.grid().origin();
    SnapshotHeader header{};
    header.radius = settings.radius;
    header.quality = settings.quality;
    header.origin = {origin.x, origin.y, origin.z};
    header.short_test = static_cast<std::uint32_t>(settings.short_test);
    header.long_tests = static_cast<std::uint32_t>(long_tests);
    header.adaptive = finest.is_adaptive() ? 1 : 0;
    header.footprint_scale = settings.footprint_scale;
    header.has_given_origin = std::isnan(settings.origin.x) ? 0 : 1;
    return block.finish(header);
}

}  // namespace lightmesh::detail
