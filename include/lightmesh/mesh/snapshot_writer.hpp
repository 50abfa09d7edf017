// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/mesh/region_table.hpp>
#include <lightmesh/mesh/snapshot_block.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/support/atomics.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// Copies what a mesh knows. Other threads may add to it meanwhile: what is published by then is copied, and
/// never half of something.
class SnapshotWriter {
public:
    explicit SnapshotWriter(const MeshData& data) : data_(data), mesh_(data.view()) {}

    /// Throws std::bad_alloc.
    std::vector<std::byte> write(LongTest long_tests) {
        copy_regions();
        SnapshotHeader header{};
        header.radius = data_.settings().radius;
        header.quality = data_.settings().quality;
        header.origin = {data_.grid().origin().x, data_.grid().origin().y, data_.grid().origin().z};
        header.short_test = static_cast<std::uint32_t>(data_.settings().short_test);
        header.long_tests = static_cast<std::uint32_t>(long_tests);
        header.adaptive = data_.is_adaptive() ? 1 : 0;
        return write_block(header, records_of(data_.user_lights()), slots_, regions_, bricks_, tile_indices_,
                           tiles_, rows_, words_);
    }

private:
    void copy_regions() {
        std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
        for (std::uint64_t i = 0; i < mesh_.region_table.size; ++i)
            if (const std::uint32_t region = load_acquire(mesh_.region_table.slots[i]); region != 0)
                order.emplace_back(mesh_.regions[region - 1].key, region - 1);
        std::ranges::sort(order);
        slots_.resize(std::bit_ceil(2 * order.size() + 2));
        const RegionTable table{slots_.data(), slots_.size()};
        for (const auto& [key, index] : order) {
            Region copied{key, {}};
            const Region& region = mesh_.regions[index];
            for (std::size_t slot = 0; slot < region.bricks.size(); ++slot)
                if (const std::uint32_t brick = load_acquire(region.bricks[slot]); brick != 0)
                    copied.bricks[slot] = copy_brick(mesh_.bricks[brick - 1]);
            regions_.push_back(copied);
            table.insert(key, static_cast<std::uint32_t>(regions_.size()));
        }
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
        if (tile_count > 1) {
            copied.tiles = static_cast<std::uint32_t>(tile_indices_.size());
            tile_indices_.resize(tile_indices_.size() + tile_count);
        }
        for (std::size_t t = 0; t < tile_count; ++t) {
            const BrickTile* tile = mesh_.find_tile(brick, t);
            const std::uint32_t index = tile == nullptr ? 0 : copy_tile(*tile);
            (tile_count > 1 ? tile_indices_[copied.tiles + t] : copied.tiles) = index;
        }
        copied.floods = copy_floods(brick);
        bricks_.push_back(copied);
        return static_cast<std::uint32_t>(bricks_.size());
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
                copied.cells[cell] = CellIndex::words(static_cast<std::uint32_t>(words_.size())).value;
                words_.insert(words_.end(), record, record + (record[1] != 0 ? 3 : 2));
            } else {
                copied.cells[cell] = CellIndex::row(static_cast<std::uint32_t>(rows_.size())).value;
                rows_.push_back(mesh_.rows[at.index()]);
            }
        }
        tiles_.push_back(copied);
        return static_cast<std::uint32_t>(tiles_.size());
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
            const auto index = static_cast<std::uint32_t>(words_.size());
            words_.insert(words_.end(), record, record + FloodView(record).size(slots));
            words_[index] = static_cast<std::uint64_t>(seed_bit) << 32 | last;
            last = index + 1;
        }
        return last;
    }

    const MeshData& data_;
    MeshView mesh_;
    std::vector<std::uint32_t> slots_;
    std::vector<Region> regions_;
    std::vector<Brick> bricks_;
    std::vector<std::uint32_t> tile_indices_;
    std::vector<BrickTile> tiles_;
    std::vector<CellRow> rows_;
    std::vector<std::uint64_t> words_;
};

}  // namespace lightmesh::detail
