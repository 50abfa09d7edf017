// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/brick_fill.hpp>
#include <lightmesh/fill/long_test_list.hpp>
#include <lightmesh/fill/unit_table.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/mesh_data.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightmesh::detail {

/// Finds units of many bricks at once by a caller's own tracer, and stores them: the same as `LongFill`.
template <LongTestTracer Trace>
class ListFill {
public:
    ListFill(MeshData& data, std::uint32_t level, Trace& trace) : data_(data), level_(level), trace_(trace) {}

    /// Throws what the tracer throws, and std::bad_alloc.
    void run(std::span<const UnitTable::Entry> units) {
        for (std::size_t t = 0; t < data_.lights().tile_count(); ++t) {
            const std::size_t most = (std::min)(
                most_long_test_words / static_cast<std::size_t>(data_.lights().tile_size(t)), most_bricks);
            bricks_.clear();
            for (const UnitTable::Entry& at : units) {
                if (at.key.tile != t)
                    continue;
                add(at);
                if (bricks_.size() == most)
                    fill(t);
            }
            fill(t);
        }
    }

    /// Rays that the tracer was asked for.
    std::uint64_t rays() const { return rays_; }

private:
    /// What is known of them meanwhile takes 1.4 KiB each.
    static constexpr std::size_t most_bricks = std::size_t{1} << 14;

    void add(const UnitTable::Entry& units) {
        const std::size_t tile = units.key.tile;
        const Brick& brick = data_.find_or_make_brick(units.key.brick);
        if (const std::uint64_t missing = data_.view().missing(brick, tile, units.mask); missing != 0)
            bricks_.emplace_back().start(data_, {&brick, tile, missing});
    }

    void fill(std::size_t tile) {
        if (bricks_.empty())
            return;
        if (data_.is_adaptive()) {
            test(tile, [](const BrickFill& brick, std::size_t l) { return brick.samples_of(l); });
            for (BrickFill& brick : bricks_) {
                for (std::size_t l = 0; l < lights_per_tile; ++l)
                    brick.take_samples(l);
                brick.end_samples();
            }
        }
        test(tile, [](const BrickFill& brick, std::size_t l) { return brick.others_of(l); });
        for (const BrickFill& brick : bricks_)
            brick.publish(data_);
        bricks_.clear();
    }

    template <class PointsOf>
    void test(std::size_t tile, PointsOf&& points_of) {
        words_.clear();
        brick_of_word_.clear();
        for (std::size_t l = 0; l < static_cast<std::size_t>(data_.lights().tile_size(tile)); ++l) {
            const std::size_t slot = tile * lights_per_tile + l;
            const auto light = static_cast<std::uint32_t>(data_.lights().order().light_at(slot));
            for (std::size_t b = 0; b < bricks_.size(); ++b) {
                const std::uint64_t points = points_of(bricks_[b], l);
                if (points == 0)
                    continue;
                words_.push_back(
                    {bricks_[b].brick().coord, light, static_cast<std::uint32_t>(slot), level_, points});
                brick_of_word_.push_back(static_cast<std::uint32_t>(b));
                rays_ += static_cast<std::uint64_t>(std::popcount(points));
            }
        }
        if (words_.empty())
            return;
        seen_.assign(words_.size(), 0);
        trace_(std::span<const LongTestWord>(words_), std::span<std::uint64_t>(seen_));
        for (std::size_t w = 0; w < words_.size(); ++w)
            bricks_[brick_of_word_[w]].add_lit(words_[w].light_slot % lights_per_tile,
                                               seen_[w] & words_[w].points);
    }

    MeshData& data_;
    std::uint32_t level_;
    Trace& trace_;
    std::vector<BrickFill> bricks_;
    std::vector<LongTestWord> words_;
    std::vector<std::uint32_t> brick_of_word_;
    std::vector<std::uint64_t> seen_;
    std::uint64_t rays_ = 0;
};

}  // namespace lightmesh::detail
