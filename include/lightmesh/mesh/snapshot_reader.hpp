// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/level.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
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

/// The knowledge that a snapshot has of a level, read where it stands. Everything is checked first: whatever
/// the bytes are, what follows neither reads beyond them nor goes on without end. Must not move.
class SnapshotLevel {
public:
    /// Throws std::invalid_argument that says in one sentence what is wrong with the parts.
    SnapshotLevel(const LevelParts& parts, const Settings& settings, const Grid& grid,
                  const LightTable& lights)
        : parts_(parts), settings_(settings), grid_(grid), lights_(lights, grid_) {
        map_parts();
        check_table();
        check_regions();
    }
    SnapshotLevel(const SnapshotLevel&) = delete;
    SnapshotLevel& operator=(const SnapshotLevel&) = delete;

    const Settings& settings() const { return settings_; }
    const Grid& grid() const { return grid_; }
    const MeshView& view() const { return view_; }
    const LevelParts& parts() const { return parts_; }
    /// Snapshots know lights by whole groups.
    KeptLights find_kept(const Brick&, std::size_t) const { return {}; }
    template <class Visitor>
    void for_each_brick(Visitor&& visit) const {
        for (const Brick& brick : parts_.bricks)
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

    void check_table() const {
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
        for (std::size_t i = 0; i < regions.size(); ++i)
            require_right(view_.region_table.find(view_.regions, regions[i].key) == i + 1,
                          "a region is not where its table says");
    }

    /// The number of parts that have been named so far. The next one of a kind is the next to be named, so
    /// that each is named once: no few bytes stand for much, and what has been changed has one owner.
    struct Named {
        std::uint64_t bricks = 0;
        std::uint64_t tile_indices = 0;
        std::uint64_t tiles = 0;
        std::uint64_t rows = 0;
        std::uint64_t words = 0;
    };

    void check_regions() const {
        Named named;
        for (std::size_t i = 0; i < parts_.regions.size(); ++i) {
            const Region& region = parts_.regions[i];
            require_right(i == 0 || parts_.regions[i - 1].key < region.key,
                          "regions do not stand in the order of their keys");
            for (std::size_t slot = 0; slot < region.bricks.size(); ++slot) {
                if (region.bricks[slot] == 0)
                    continue;
                require_right(region.bricks[slot] == ++named.bricks && named.bricks <= parts_.bricks.size(),
                              "a brick is not named in its turn");
                const Brick& brick = parts_.bricks[named.bricks - 1];
                require_right(Region::key_of(brick.position()) == region.key &&
                                  Region::slot(brick.position()) == slot,
                              "a brick is not where its region says");
                check_brick(brick, named);
            }
        }
        require_right(named.bricks == parts_.bricks.size() &&
                          named.tile_indices == parts_.tile_indices.size() &&
                          named.tiles == parts_.tiles.size() && named.rows == parts_.rows.size() &&
                          named.words == parts_.words.size(),
                      "it has parts that nothing names");
    }

    void check_brick(const Brick& brick, Named& named) const {
        constexpr std::int32_t farthest = Grid::max_index / brick_side + 16;
        for (const std::int32_t c : brick.coord)
            require_right(c >= -farthest && c <= farthest, "a brick lies outside of the grid");
        require_right(brick.lock == 0 && brick.used == 0, "a brick is in use");
        const std::uint64_t linked = points_of_cells(brick.links_known);
        require_right(((brick.links[0] | brick.links[1] | brick.links[2]) & ~linked) == 0,
                      "a brick's links make no sense");
        const std::size_t tile_count = lights_.tile_count();
        if (tile_count == 1) {
            check_tile(brick.tiles, named);
        } else {
            require_right(brick.tiles == named.tile_indices &&
                              tile_count <= parts_.tile_indices.size() - named.tile_indices,
                          "a brick's tiles are not named in their turn");
            for (const std::uint32_t tile : parts_.tile_indices.subspan(brick.tiles, tile_count))
                check_tile(tile, named);
            named.tile_indices += tile_count;
        }
        check_floods(brick, named);
    }

    void check_tile(std::uint32_t index, Named& named) const {
        if (index == 0)
            return;
        require_right(index == ++named.tiles && named.tiles <= parts_.tiles.size(),
                      "a tile is not named in its turn");
        const BrickTile& tile = parts_.tiles[index - 1];
        require_right(tile.sampled <= 0xff && (tile.uniform & ~lights_of_groups(tile.sampled)) == 0 &&
                          (tile.lit & ~tile.uniform) == 0 &&
                          (settings_.adaptive_long_tests || tile.sampled == 0),
                      "a brick's samples make no sense");
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell) {
            const CellIndex at{tile.cells[cell]};
            if (at.is_nothing())
                continue;
            require_right((tile.known >> (8 * cell) & 0xff) != 0 && at.value != 1,
                          "a cell is named that is not there");
            if (at.is_words())
                check_words(at.index(), named);
            else
                require_right(at.index() == named.rows && ++named.rows <= parts_.rows.size(),
                              "a cell's row is not named in its turn");
        }
    }

    void check_words(std::uint64_t index, Named& named) const {
        const std::span<const std::uint64_t> words = parts_.words;
        require_right(index == named.words && index + 2 <= words.size(),
                      "a cell's words are not named in their turn");
        const std::uint64_t lit = words[index];
        const std::uint64_t mixed = words[index + 1];
        named.words += words_of_cell(&words[index]);
        require_right((lit & mixed) == 0 && std::popcount(mixed) <= most_mixed_in_words &&
                          named.words <= words.size(),
                      "a cell's words make no sense");
    }

    /// A brick's floods lie side by side, and each names the one before it.
    void check_floods(const Brick& brick, Named& named) const {
        if (brick.floods == 0)
            return;
        const std::uint64_t count = parts_.words.size();
        const std::size_t slots = FloodBox::slots(grid_.quality());
        const std::size_t fixed = 1 + 2 * FloodView::bit_words(slots);
        std::uint64_t first = count;  // of the floods checked so far
        std::uint64_t end = count;
        for (std::uint64_t flood = brick.floods; flood != 0;) {
            require_right(flood - 1 >= named.words && flood - 1 < first && flood - 1 + fixed <= count,
                          "a flood is not named in its turn");
            const FloodView view(&parts_.words[flood - 1]);
            const std::uint64_t behind = flood - 1 + view.size(slots);
            require_right(view.seed_bit() >= 0 && view.seed_bit() < 64 && view.has_slots(slots) &&
                              behind <= count && (flood == brick.floods || behind == first),
                          "a flood makes no sense");
            if (flood == brick.floods)
                end = behind;
            first = flood - 1;
            flood = view.next();
        }
        require_right(first == named.words, "a flood is not named in its turn");
        named.words = end;
    }

    LevelParts parts_;
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
        LevelParts parts;
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
