// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/level.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/mesh/pool.hpp>
#include <lightmesh/mesh/region_table.hpp>
#include <lightmesh/mesh/snapshot_block.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/settings.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// What a snapshot knows of a level, read where it stands. Everything is checked first: whatever the bytes
/// are, what follows neither reads beyond them nor goes on without end. Must not move.
class SnapshotLevel {
public:
    struct Parts {
        std::span<const std::uint32_t> slots;
        std::span<const Region> regions;
        std::span<const Brick> bricks;
        std::span<const std::uint32_t> tile_indices;
        std::span<const BrickTile> tiles;
        std::span<const CellRow> rows;
        std::span<const std::uint64_t> words;
    };

    /// Throws std::invalid_argument that says in one sentence what is wrong with the parts.
    SnapshotLevel(const Parts& parts, const Settings& settings, const Grid& grid, const LightTable& lights)
        : parts_(parts), settings_(settings), grid_(grid), lights_(lights, grid_) {
        map_parts();
        check_regions();
        check_bricks();
    }
    SnapshotLevel(const SnapshotLevel&) = delete;
    SnapshotLevel& operator=(const SnapshotLevel&) = delete;

    const Settings& settings() const { return settings_; }
    const Grid& grid() const { return grid_; }
    const MeshView& view() const { return view_; }
    std::span<const Brick> bricks() const { return parts_.bricks; }
    template <class Visitor>
    void for_each_brick(Visitor&& visit) const {
        for (const Brick& brick : bricks())
            visit(brick);
    }

private:
    template <class T>
    static PoolView<T> spread(std::span<const T> all, typename PoolView<T>::Table& table) {
        spread_over(table, const_cast<T*>(all.data()), all.size());
        return PoolView<T>(table);
    }

    void map_parts() {
        view_.settings = &settings_;
        view_.grid = &grid_;
        view_.lights = &lights_;
        view_.region_table = {const_cast<std::uint32_t*>(parts_.slots.data()), parts_.slots.size()};
        view_.regions = spread(parts_.regions, region_chunks_);
        view_.bricks = spread(parts_.bricks, brick_chunks_);
        view_.tile_indices = spread(parts_.tile_indices, tile_index_chunks_);
        view_.tiles = spread(parts_.tiles, tile_chunks_);
        view_.rows = spread(parts_.rows, row_chunks_);
        view_.words = spread(parts_.words, word_chunks_);
    }

    void check_regions() const {
        const std::span<const std::uint32_t> slots = parts_.slots;
        const std::span<const Region> regions = parts_.regions;
        require_right(std::has_single_bit(slots.size()),
                      "the size of its table of regions is no power of two");
        std::uint64_t taken = 0;
        for (const std::uint32_t slot : slots) {
            require_right(slot <= regions.size(), "a region is named that is not there");
            taken += slot != 0 ? 1u : 0u;
        }
        require_right(2 * taken <= slots.size() && taken == regions.size(),
                      "its table of regions is too full, or leaves regions out");
        std::uint64_t bricks = 0;
        for (std::size_t i = 0; i < regions.size(); ++i) {
            require_right(view_.region_table.find(view_.regions, regions[i].key) == i + 1,
                          "a region is not where its table says");
            for (std::size_t slot = 0; slot < regions[i].bricks.size(); ++slot) {
                const std::uint32_t brick = regions[i].bricks[slot];
                if (brick == 0)
                    continue;
                ++bricks;
                require_right(brick <= parts_.bricks.size(), "a brick is named that is not there");
                const glm::ivec3 coord = view_.bricks[brick - 1].position();
                require_right(Region::key_of(coord) == regions[i].key && Region::slot(coord) == slot,
                              "a brick is not where its region says");
            }
        }
        require_right(bricks == parts_.bricks.size(), "it has bricks that no region names");
    }

    /// How many of a snapshot's parts have been named so far: each by one other part only, so that no few
    /// bytes stand for much.
    struct Named {
        std::uint64_t tiles = 0;
        std::uint64_t rows = 0;
        std::uint64_t words = 0;
    };

    void check_bricks() const {
        Named named;
        const std::uint64_t tile_index_count = parts_.tile_indices.size();
        const std::size_t tile_count = lights_.tile_count();
        constexpr std::int32_t farthest = Grid::max_index / brick_side + 16;
        for (const Brick& brick : parts_.bricks) {
            for (const std::int32_t c : brick.coord)
                require_right(c >= -farthest && c <= farthest, "a brick lies outside of the grid");
            require_right(brick.lock == 0, "a brick is locked");
            if (tile_count > 1)
                require_right(brick.tiles <= tile_index_count && tile_count <= tile_index_count - brick.tiles,
                              "a brick's tiles reach beyond its end");
            for (std::size_t t = 0; t < tile_count; ++t)
                check_tile(view_.tile_index(brick, t), named);
            check_floods(brick, named);
        }
    }

    void check_tile(std::uint32_t index, Named& named) const {
        if (index == 0)
            return;
        const std::uint64_t count = parts_.tiles.size();
        require_right(index <= count && ++named.tiles <= count,
                      "a tile is named that is not there, or twice");
        const BrickTile& tile = view_.tiles[index - 1];
        require_right(tile.sampled <= 0xff && (tile.uniform & ~lights_of_groups(tile.sampled)) == 0 &&
                          (tile.lit & ~tile.uniform) == 0 &&
                          (settings_.adaptive_long_tests || tile.sampled == 0),
                      "a brick's samples make no sense");
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell) {
            const CellIndex at{tile.cells[cell]};
            if (at.is_nothing())
                continue;
            require_right(at.value != 1, "a cell is named that is not there");
            if (at.is_words()) {
                check_words(at.index(), named);
            } else {
                const std::uint64_t rows = parts_.rows.size();
                require_right(at.index() < rows && ++named.rows <= rows,
                              "a cell's row is named that is not there, or twice");
            }
        }
    }

    void check_words(std::uint64_t index, Named& named) const {
        const std::uint64_t count = parts_.words.size();
        require_right(index + 2 <= count, "a cell's words reach beyond its end");
        const std::uint64_t* record = &view_.words[static_cast<std::uint32_t>(index)];
        require_right((record[0] & record[1]) == 0 && std::popcount(record[1]) <= most_mixed_in_words &&
                          (record[1] == 0 || index + 3 <= count),
                      "a cell's words make no sense");
        named.words += record[1] == 0 ? 2u : 3u;
        require_right(named.words <= count, "a cell's words are named twice");
    }

    /// Each flood names one before it, so that no chain has a loop.
    void check_floods(const Brick& brick, Named& named) const {
        const std::uint64_t count = parts_.words.size();
        const std::size_t slots = FloodBox::slots(grid_.quality());
        const std::size_t fixed = 1 + 2 * FloodView::bit_words(slots);
        std::uint64_t limit = count + 1;
        for (std::uint64_t flood = brick.floods; flood != 0;) {
            require_right(flood < limit && flood - 1 + fixed <= count, "a flood reaches beyond its end");
            const FloodView view(&view_.words[static_cast<std::uint32_t>(flood - 1)]);
            require_right(view.seed_bit() >= 0 && view.seed_bit() < 64 &&
                              flood - 1 + view.size(slots) <= count && view.has_slots(slots),
                          "a flood makes no sense");
            named.words += view.size(slots);
            require_right(named.words <= count, "a flood is named twice");
            limit = flood;
            flood = view.next();
        }
    }

    Parts parts_;
    Settings settings_;
    Grid grid_;
    LightTable lights_;
    PoolView<Region>::Table region_chunks_{};
    PoolView<Brick>::Table brick_chunks_{};
    PoolView<std::uint32_t>::Table tile_index_chunks_{};
    PoolView<BrickTile>::Table tile_chunks_{};
    PoolView<CellRow>::Table row_chunks_{};
    PoolView<std::uint64_t>::Table word_chunks_{};
    MeshView view_;
};

/// A snapshot, level by level. Everything is checked first. Must not move.
class SnapshotReader {
public:
    /// Throws std::invalid_argument that says in one sentence what is wrong with the bytes.
    explicit SnapshotReader(std::span<const std::byte> bytes)
        : block_(bytes), user_lights_(lights_of(block_.section<LightRecord>(lights_section))) {
        read_settings();
        read_levels();
    }

    SnapshotReader(const SnapshotReader&) = delete;
    SnapshotReader& operator=(const SnapshotReader&) = delete;

    /// Of level 0; the origin is that of its grid.
    const Settings& settings() const { return settings_; }
    LongTest long_tests() const { return static_cast<LongTest>(header_.long_tests); }
    std::span<const Light> user_lights() const { return user_lights_; }
    /// The same for all levels.
    const LightTable& lights() const { return *finest().view().lights; }
    const LevelRule& rule() const { return *rule_; }

    const SnapshotLevel& finest() const { return *levels_.front(); }
    /// A level, or null if it is not there.
    const SnapshotLevel* find(int k) const { return levels_[static_cast<std::size_t>(k)].get(); }
    /// Calls visit(k, level) for the levels that are there.
    template <class Visitor>
    void for_each(Visitor&& visit) const {
        for (std::size_t k = 0; k < levels_.size(); ++k)
            if (levels_[k] != nullptr)
                visit(static_cast<int>(k), std::as_const(*levels_[k]));
    }

    /// The grid of a level, whether it is there or not.
    Grid grid_of(int k) const {
        Settings of_level = settings_of_level(settings_, k);
        if (header_.has_given_origin != 0)
            return Grid(of_level, given_origin());
        of_level.origin = Settings{}.origin;
        return Grid(of_level);
    }

private:
    glm::dvec3 given_origin() const { return {header_.origin[0], header_.origin[1], header_.origin[2]}; }

    void read_settings() {
        settings_.radius = header_.radius;
        settings_.quality = header_.quality;
        settings_.footprint_scale = header_.footprint_scale;
        require_right(header_.short_test <= static_cast<std::uint32_t>(ShortTest::exact),
                      "there is no such short test");
        settings_.short_test = static_cast<ShortTest>(header_.short_test);
        require_right(header_.long_tests <= static_cast<std::uint32_t>(LongTest::refined_shadow_maps),
                      "there is no such long test");
        require_right(header_.adaptive <= 1 && header_.has_given_origin <= 1 && header_.unused == 0,
                      "it is of no known kind");
        settings_.adaptive_long_tests = header_.adaptive != 0;
        const Grid grid = grid_of(0);
        require_right(grid.origin() == given_origin(), "its origin is not that of its grid");
        settings_.origin = glm::vec3(grid.origin());
        rule_.emplace(settings_);
    }

    void read_levels() {
        using Firsts = std::array<std::uint64_t, level_section_count>;
        const auto records = block_.section<SnapshotLevelRecord>(levels_section);
        Firsts ends;
        for (std::size_t i = 0; i < ends.size(); ++i)
            ends[i] = header_.sections[first_level_section + i].count;
        levels_.resize(static_cast<std::size_t>(rule_->coarsest()) + 1);
        const LightTable lights(user_lights_, grid_of(0));
        Firsts first{};
        std::uint64_t level = 0;
        for (std::size_t i = 0; i <= records.size(); ++i) {
            const Firsts& last = i < records.size() ? records[i].first : ends;
            for (std::size_t part = 0; part < last.size(); ++part)
                require_right(first[part] <= last[part] && last[part] <= ends[part],
                              "a level reaches beyond its end");
            add_level(static_cast<int>(level), first, last, lights);
            if (i == records.size())
                break;
            require_right(records[i].level > level && records[i].level < levels_.size(),
                          "a level is not in its place");
            level = records[i].level;
            first = last;
        }
    }

    void add_level(int k, const std::array<std::uint64_t, level_section_count>& first,
                   const std::array<std::uint64_t, level_section_count>& last, const LightTable& lights) {
        const auto part = [&]<class T>(SnapshotSectionName name, std::span<const T>& of_level) {
            const std::size_t i = name - first_level_section;
            of_level = block_.section<T>(name).subspan(first[i], last[i] - first[i]);
        };
        SnapshotLevel::Parts parts;
        part(region_slots_section, parts.slots);
        part(regions_section, parts.regions);
        part(bricks_section, parts.bricks);
        part(tile_indices_section, parts.tile_indices);
        part(tiles_section, parts.tiles);
        part(rows_section, parts.rows);
        part(words_section, parts.words);
        levels_[static_cast<std::size_t>(k)] =
            std::make_unique<const SnapshotLevel>(parts, settings_of_level(settings_, k), grid_of(k), lights);
    }

    SnapshotBlock<SnapshotHeader> block_;
    const SnapshotHeader& header_ = block_.header();
    std::vector<Light> user_lights_;
    Settings settings_;
    std::optional<LevelRule> rule_;
    std::vector<std::unique_ptr<const SnapshotLevel>> levels_;
};

}  // namespace lightmesh::detail
