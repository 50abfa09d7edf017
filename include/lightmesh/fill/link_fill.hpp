// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/fill/link_list.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/fill/unit_table.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/support/atomics.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightmesh::detail {

/// Of each of a cell's eight light points one step up along x, y and z.
inline constexpr std::size_t links_of_cell = 24;

/// From light point p of a brick one step up along an axis.
inline Segment link_segment(const Grid& grid, const glm::ivec3& brick, int p, int axis) {
    const glm::ivec3 pos = grid_pos_of(brick, p);
    glm::ivec3 next = pos;
    ++next[axis];
    return {grid.position(pos), grid.position(next)};
}

/// Finds the links of the cells in `missing` (one bit a cell) by rays and stores them. Returns the number of
/// rays.
template <Intersector Tracer>
std::uint64_t fill_links(MeshData& data, const Tracer& tracer, const Brick& brick, std::uint32_t missing) {
    std::uint64_t rays = 0;
    for (std::uint32_t rest = missing; rest != 0; rest &= rest - 1) {
        const int cell = std::countr_zero(rest);
        std::array<Segment, links_of_cell> segments;
        for (std::size_t i = 0; i < links_of_cell; ++i)
            segments[i] = link_segment(data.grid(), brick.position(), 8 * cell + static_cast<int>(i % 8),
                                       static_cast<int>(i / 8));
        std::array<std::uint8_t, links_of_cell> hit;
        trace(tracer, std::span<const Segment>(segments), std::span(hit));
        OpenLinks open{};
        for (std::size_t i = 0; i < links_of_cell; ++i)
            if (hit[i] == 0)
                open[i / 8] |= std::uint64_t{1} << (static_cast<std::size_t>(8 * cell) + i % 8);
        data.publish_links(brick, cell, open);
        rays += links_of_cell;
    }
    return rays;
}

/// The same for cells of many bricks of one level at once by a caller's own tracer.
template <LinkTracer Trace>
class LinkListFill {
public:
    LinkListFill(MeshData& data, std::uint32_t level, Trace& trace)
        : data_(data), level_(static_cast<std::uint16_t>(level)), trace_(trace) {}

    /// Throws what the tracer throws, and std::bad_alloc.
    void run(std::span<const UnitTable::Entry> bricks) {
        for (const UnitTable::Entry& entry : bricks) {
            const Brick& brick = data_.find_or_make_brick(entry.key.brick);
            const auto missing =
                static_cast<std::uint32_t>(entry.mask) & ~std::uint32_t{load_acquire(brick.links_known)};
            if (missing == 0)
                continue;
            bricks_.push_back(&brick);
            words_.push_back({brick.coord, level_, static_cast<std::uint16_t>(missing)});
            if (words_.size() == most_link_words)
                find();
        }
        find();
    }

    std::uint64_t rays() const { return rays_; }

private:
    void find() {
        if (words_.empty())
            return;
        open_.assign(words_.size(), OpenLinks{});
        trace_(std::span<const LinkWord>(words_), std::span<OpenLinks>(open_));
        for (std::size_t i = 0; i < words_.size(); ++i)
            publish(*bricks_[i], words_[i].cells, open_[i]);
        bricks_.clear();
        words_.clear();
    }

    void publish(const Brick& brick, std::uint32_t cells, const OpenLinks& open) {
        rays_ += links_of_cell * static_cast<std::size_t>(std::popcount(cells));
        for (; cells != 0; cells &= cells - 1) {
            const int cell = std::countr_zero(cells);
            OpenLinks of_cell;
            std::ranges::transform(open, of_cell.begin(), [cell](std::uint64_t links) {
                return links & std::uint64_t{0xff} << 8 * cell;
            });
            data_.publish_links(brick, cell, of_cell);
        }
    }

    MeshData& data_;
    std::uint16_t level_;
    Trace& trace_;
    std::vector<const Brick*> bricks_;
    std::vector<LinkWord> words_;
    std::vector<OpenLinks> open_;
    std::uint64_t rays_ = 0;
};

}  // namespace lightmesh::detail
