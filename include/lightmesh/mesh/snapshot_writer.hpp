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

/// What levels know, level by level: see `snapshot_format.hpp`.
struct SnapshotParts {
    std::vector<std::uint32_t> slots;
    std::vector<Region> regions;
    std::vector<Brick> bricks;
    std::vector<std::uint32_t> tile_indices;
    std::vector<BrickTile> tiles;
    std::vector<CellRow> rows;
    std::vector<std::uint64_t> words;

    std::array<std::uint64_t, level_section_count> sizes() const {
        return {slots.size(), regions.size(), bricks.size(), tile_indices.size(),
                tiles.size(), rows.size(),    words.size()};
    }
};

/// Copies what a level knows to the end of `parts`. Other threads may add to it meanwhile: what is published
/// by then is copied, and never half of something.
class LevelCopy {
public:
    LevelCopy(const MeshData& data, SnapshotParts& parts)
        : mesh_(data.view()), parts_(parts), first_(parts.sizes()) {}

    /// Throws std::bad_alloc.
    void run() {
        std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
        for (std::uint64_t i = 0; i < mesh_.region_table.size; ++i)
            if (const std::uint32_t region = load_acquire(mesh_.region_table.slots[i]);
                region != 0 && std::ranges::any_of(mesh_.regions[region - 1].bricks, [&](const auto& brick) {
                    return knows_anything(load_acquire(brick));
                }))
                order.emplace_back(mesh_.regions[region - 1].key, region - 1);
        std::ranges::sort(order);
        const std::size_t slot_count = std::bit_ceil(2 * order.size() + 2);
        parts_.slots.resize(parts_.slots.size() + slot_count);
        const RegionTable table{parts_.slots.data() + parts_.slots.size() - slot_count, slot_count};
        for (const auto& [key, index] : order) {
            Region copied{key, {}};
            const Region& region = mesh_.regions[index];
            for (std::size_t slot = 0; slot < region.bricks.size(); ++slot)
                if (const std::uint32_t brick = load_acquire(region.bricks[slot]); knows_anything(brick))
                    copied.bricks[slot] = copy_brick(mesh_.bricks[brick - 1]);
            parts_.regions.push_back(copied);
            table.insert(key, size_of<regions_section>(parts_.regions));
        }
    }

private:
    /// How much of a section is the level's own by now.
    template <SnapshotSectionName section, class T>
    std::uint32_t size_of(const std::vector<T>& all) const {
        return static_cast<std::uint32_t>(all.size() - first_[section - first_level_section]);
    }

    /// A query makes bricks before it asks for what they hold, and may find that it needs nothing of them.
    bool knows_anything(std::uint32_t index) const {
        if (index == 0)
            return false;
        const Brick& brick = mesh_.bricks[index - 1];
        if (load_acquire(brick.links_known) != 0 || load_acquire(brick.floods) != 0)
            return true;
        for (std::size_t t = 0; t < mesh_.lights->tile_count(); ++t)
            if (const BrickTile* tile = mesh_.find_tile(brick, t))
                if ((load_acquire(tile->known) | load_acquire(tile->sampled)) != 0)
                    return true;
        return false;
    }

    /// Index plus one of the copy.
    std::uint32_t copy_brick(const Brick& brick) {
        Brick copied{};
        copied.coord = brick.coord;
        copied.links_known = load_acquire(brick.links_known);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            copied.links[axis] = load_relaxed(brick.links[axis]);
            for (int cell = 0; cell < cells_per_brick; ++cell)
                if ((copied.links_known >> cell & 1) == 0)
                    copied.links[axis] &= ~(std::uint64_t{0xff} << (8 * cell));
        }
        const std::size_t tile_count = mesh_.lights->tile_count();
        const std::size_t first_tile = parts_.tile_indices.size();
        if (tile_count > 1) {
            copied.tiles = size_of<tile_indices_section>(parts_.tile_indices);
            parts_.tile_indices.resize(first_tile + tile_count);
        }
        for (std::size_t t = 0; t < tile_count; ++t) {
            const BrickTile* tile = mesh_.find_tile(brick, t);
            const std::uint32_t index = tile == nullptr ? 0 : copy_tile(*tile);
            (tile_count > 1 ? parts_.tile_indices[first_tile + t] : copied.tiles) = index;
        }
        copied.floods = copy_floods(brick);
        parts_.bricks.push_back(copied);
        return size_of<bricks_section>(parts_.bricks);
    }

    /// Index plus one of the copy; 0 if nothing is known.
    std::uint32_t copy_tile(const BrickTile& tile) {
        BrickTile copied{};
        copied.known = load_acquire(tile.known);
        copied.sampled = load_acquire(tile.sampled);
        if ((copied.known | copied.sampled) == 0)
            return 0;
        copied.uniform = load_relaxed(tile.uniform) & lights_of_groups(copied.sampled);
        copied.lit = load_relaxed(tile.lit) & copied.uniform;
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell) {
            const CellIndex at{load_acquire(tile.cells[cell])};
            if (at.is_nothing() || (copied.known >> (8 * cell) & 0xff) == 0)
                continue;
            if (at.is_words()) {
                const std::uint64_t* record = &mesh_.words[at.index()];
                copied.cells[cell] = CellIndex::words(size_of<words_section>(parts_.words)).value;
                parts_.words.insert(parts_.words.end(), record, record + (record[1] != 0 ? 3 : 2));
            } else {
                copied.cells[cell] = CellIndex::row(size_of<rows_section>(parts_.rows)).value;
                parts_.rows.push_back(mesh_.rows[at.index()]);
            }
        }
        parts_.tiles.push_back(copied);
        return size_of<tiles_section>(parts_.tiles);
    }

    /// Index plus one of the last copy; in the order of the seeds.
    std::uint32_t copy_floods(const Brick& brick) {
        const std::size_t slots = FloodBox::slots(mesh_.grid->quality());
        std::vector<std::pair<int, const std::uint64_t*>> floods;
        for (std::uint32_t flood = load_acquire(brick.floods); flood != 0;) {
            const std::uint64_t* record = &mesh_.words[flood - 1];
            floods.emplace_back(FloodView(record).seed_bit(), record);
            flood = FloodView(record).next();
        }
        std::ranges::sort(floods);
        std::uint32_t last = 0;
        for (const auto& [seed_bit, record] : floods) {
            const std::uint32_t index = size_of<words_section>(parts_.words);
            const std::size_t at = parts_.words.size();
            parts_.words.insert(parts_.words.end(), record, record + FloodView(record).size(slots));
            parts_.words[at] = static_cast<std::uint64_t>(seed_bit) << 32 | last;
            last = index + 1;
        }
        return last;
    }

    MeshView mesh_;
    SnapshotParts& parts_;
    std::array<std::uint64_t, level_section_count> first_;
};

/// One block of all that the levels of a mesh know. Throws std::bad_alloc.
template <class Levels>
std::vector<std::byte> write_snapshot(const Levels& levels, LongTest long_tests) {
    SnapshotParts parts;
    std::vector<SnapshotLevelRecord> records;
    levels.for_each([&](int k, const auto& level) {
        const MeshData& data = level.data();
        if (k != 0) {
            if (!data.knows_anything())
                return;
            records.push_back({static_cast<std::uint64_t>(k), parts.sizes()});
        }
        // As the reader will expect lights in the order of a mesh that is made of them.
        if (data.was_updated()) {
            MeshData copy(data.user_lights(), data.settings(), data.grid());
            copy_level(data, copy);
            LevelCopy(copy, parts).run();
        } else {
            LevelCopy(data, parts).run();
        }
    });
    const MeshData& finest = levels.finest().data();
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
    return write_block(header, records_of(finest.user_lights()), records, parts.slots, parts.regions,
                       parts.bricks, parts.tile_indices, parts.tiles, parts.rows, parts.words);
}

}  // namespace lightmesh::detail
