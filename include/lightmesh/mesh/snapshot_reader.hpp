// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/mesh/pool.hpp>
#include <lightmesh/mesh/region_table.hpp>
#include <lightmesh/mesh/snapshot_block.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/settings.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace lightmesh::detail {

/// A snapshot's parts, read where they stand. Everything is checked first: whatever the bytes are, what
/// follows neither reads beyond them nor goes on without end. Must not move.
class SnapshotReader {
public:
    /// Throws std::invalid_argument that says in one sentence what is wrong with the bytes.
    explicit SnapshotReader(std::span<const std::byte> bytes) : block_(bytes) {
        read_settings();
        read_lights();
        map_sections();
        check_regions();
        check_bricks();
    }
    SnapshotReader(const SnapshotReader&) = delete;
    SnapshotReader& operator=(const SnapshotReader&) = delete;

    const Settings& settings() const { return settings_; }
    const Grid& grid() const { return *grid_; }
    const LightTable& lights() const { return *lights_; }
    std::span<const Light> user_lights() const { return user_lights_; }
    LongTest long_tests() const { return static_cast<LongTest>(header_.long_tests); }
    const MeshView& view() const { return view_; }
    std::span<const Brick> bricks() const { return section<Brick>(bricks_section); }

private:
    void read_settings() {
        settings_.radius = header_.radius;
        settings_.quality = header_.quality;
        require_right(header_.short_test <= static_cast<std::uint32_t>(ShortTest::exact),
                      "there is no such short test");
        settings_.short_test = static_cast<ShortTest>(header_.short_test);
        require_right(header_.long_tests <= static_cast<std::uint32_t>(LongTest::refined_shadow_maps),
                      "there is no such long test");
        require_right(header_.adaptive <= 1 && header_.unused == 0, "it is of no known kind");
        settings_.adaptive_long_tests = header_.adaptive != 0;
        grid_ = std::make_unique<const Grid>(
            settings_, glm::dvec3(header_.origin[0], header_.origin[1], header_.origin[2]));
        settings_.origin = glm::vec3(grid_->origin());
    }

    void read_lights() {
        user_lights_ = lights_of(section<LightRecord>(lights_section));
        lights_ = std::make_unique<const LightTable>(user_lights_, *grid_);
    }

    template <class T>
    std::span<const T> section(std::size_t name) const {
        return block_.section<T>(name);
    }

    template <class T>
    PoolView<T> spread(std::size_t name, typename PoolView<T>::Table& table) const {
        const auto all = section<T>(name);
        spread_over(table, const_cast<T*>(all.data()), all.size());
        return PoolView<T>(table);
    }

    void map_sections() {
        const auto slots = section<std::uint32_t>(region_slots_section);
        view_.settings = &settings_;
        view_.grid = grid_.get();
        view_.lights = lights_.get();
        view_.region_table = {const_cast<std::uint32_t*>(slots.data()), slots.size()};
        view_.regions = spread<Region>(regions_section, region_chunks_);
        view_.bricks = spread<Brick>(bricks_section, brick_chunks_);
        view_.tile_indices = spread<std::uint32_t>(tile_indices_section, tile_index_chunks_);
        view_.tiles = spread<BrickTile>(tiles_section, tile_chunks_);
        view_.rows = spread<CellRow>(rows_section, row_chunks_);
        view_.words = spread<std::uint64_t>(words_section, word_chunks_);
    }

    void check_regions() const {
        const auto slots = section<std::uint32_t>(region_slots_section);
        const auto regions = section<Region>(regions_section);
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
                require_right(brick <= header_.sections[bricks_section].count,
                              "a brick is named that is not there");
                const glm::ivec3 coord = view_.bricks[brick - 1].position();
                require_right(Region::key_of(coord) == regions[i].key && Region::slot(coord) == slot,
                              "a brick is not where its region says");
            }
        }
        require_right(bricks == header_.sections[bricks_section].count, "it has bricks that no region names");
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
        const std::uint64_t tile_index_count = header_.sections[tile_indices_section].count;
        const std::size_t tile_count = lights_->tile_count();
        constexpr std::int32_t farthest = Grid::max_index / brick_side + 16;
        for (const Brick& brick : section<Brick>(bricks_section)) {
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
        const std::uint64_t count = header_.sections[tiles_section].count;
        require_right(index <= count && ++named.tiles <= count,
                      "a tile is named that is not there, or twice");
        const BrickTile& tile = view_.tiles[index - 1];
        require_right(tile.sampled <= 0xff && (tile.uniform & ~lights_of_groups(tile.sampled)) == 0 &&
                          (tile.lit & ~tile.uniform) == 0 && (header_.adaptive != 0 || tile.sampled == 0),
                      "a brick's samples make no sense");
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell) {
            const CellIndex at{tile.cells[cell]};
            if (at.is_nothing())
                continue;
            require_right(at.value != 1, "a cell is named that is not there");
            if (at.is_words()) {
                check_words(at.index(), named);
            } else {
                const std::uint64_t rows = header_.sections[rows_section].count;
                require_right(at.index() < rows && ++named.rows <= rows,
                              "a cell's row is named that is not there, or twice");
            }
        }
    }

    void check_words(std::uint64_t index, Named& named) const {
        const std::uint64_t count = header_.sections[words_section].count;
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
        const std::uint64_t count = header_.sections[words_section].count;
        const std::size_t slots = FloodBox::slots(grid_->quality());
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

    SnapshotBlock<SnapshotHeader> block_;
    const SnapshotHeader& header_ = block_.header();
    Settings settings_;
    std::unique_ptr<const Grid> grid_;
    std::vector<Light> user_lights_;
    std::unique_ptr<const LightTable> lights_;
    PoolView<Region>::Table region_chunks_{};
    PoolView<Brick>::Table brick_chunks_{};
    PoolView<std::uint32_t>::Table tile_index_chunks_{};
    PoolView<BrickTile>::Table tile_chunks_{};
    PoolView<CellRow>::Table row_chunks_{};
    PoolView<std::uint64_t>::Table word_chunks_{};
    MeshView view_;
};

}  // namespace lightmesh::detail
