// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/fill/segment_tracer.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/fill/unit_table.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/support/atomics.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightmesh::detail {

/// Of each of a cell's eight light points one step up along x, y and z.
inline constexpr std::size_t links_of_cell = 24;

inline std::array<Segment, links_of_cell> link_segments(const Grid& grid, const glm::ivec3& brick, int cell) {
    std::array<Segment, links_of_cell> segments;
    for (int axis = 0; axis < 3; ++axis) {
        for (int p = 0; p < 8; ++p) {
            const glm::ivec3 pos = grid_pos_of(brick, 8 * cell + p);
            glm::ivec3 next = pos;
            ++next[axis];
            segments[static_cast<std::size_t>(8 * axis + p)] = {grid.position(pos), grid.position(next)};
        }
    }
    return segments;
}

/// Stores the links of a cell, by which of `link_segments` are blocked.
inline void publish_links(MeshData& data, const Brick& brick, int cell, std::span<const std::uint8_t> hit) {
    std::array<std::uint64_t, 3> open{};
    for (std::size_t i = 0; i < links_of_cell; ++i)
        if (hit[i] == 0)
            open[i / 8] |= std::uint64_t{1} << (static_cast<std::size_t>(8 * cell) + i % 8);
    data.publish_links(brick, cell, open);
}

/// Finds the links of the cells in `missing` (one bit a cell) by rays and stores them. Returns the number of
/// rays.
template <Intersector Tracer>
std::uint64_t fill_links(MeshData& data, const Tracer& tracer, const Brick& brick, std::uint32_t missing) {
    std::uint64_t rays = 0;
    for (std::uint32_t rest = missing; rest != 0; rest &= rest - 1) {
        const int cell = std::countr_zero(rest);
        const auto segments = link_segments(data.grid(), brick.position(), cell);
        std::array<std::uint8_t, links_of_cell> hit;
        trace(tracer, std::span<const Segment>(segments), std::span(hit));
        publish_links(data, brick, cell, hit);
        rays += segments.size();
    }
    return rays;
}

/// The same for cells of many bricks at once by a caller's own tracer.
template <SegmentTracer Trace>
class LinkListFill {
public:
    LinkListFill(MeshData& data, Trace& trace) : data_(data), trace_(trace) {}

    /// Throws what the tracer throws, and std::bad_alloc.
    void run(std::span<const UnitTable::Entry> bricks) {
        for (const UnitTable::Entry& entry : bricks) {
            const Brick& brick = data_.find_or_make_brick(entry.key.brick);
            auto missing =
                static_cast<std::uint32_t>(entry.mask) & ~std::uint32_t{load_acquire(brick.links_known)};
            for (; missing != 0; missing &= missing - 1)
                add(brick, std::countr_zero(missing));
        }
        find();
    }

    std::uint64_t rays() const { return rays_; }

private:
    struct Cell {
        const Brick* brick;
        int cell;
    };

    void add(const Brick& brick, int cell) {
        if (segments_.size() + links_of_cell > most_listed_segments)
            find();
        const auto segments = link_segments(data_.grid(), brick.position(), cell);
        segments_.insert(segments_.end(), segments.begin(), segments.end());
        cells_.push_back({&brick, cell});
    }

    void find() {
        if (cells_.empty())
            return;
        hit_.assign(segments_.size(), 0);
        trace_(std::span<const Segment>(segments_), std::span<std::uint8_t>(hit_));
        rays_ += segments_.size();
        for (std::size_t i = 0; i < cells_.size(); ++i)
            publish_links(data_, *cells_[i].brick, cells_[i].cell,
                          std::span<const std::uint8_t>(hit_).subspan(i * links_of_cell, links_of_cell));
        cells_.clear();
        segments_.clear();
    }

    MeshData& data_;
    Trace& trace_;
    std::vector<Cell> cells_;
    std::vector<Segment> segments_;
    std::vector<std::uint8_t> hit_;
    std::uint64_t rays_ = 0;
};

}  // namespace lightmesh::detail
