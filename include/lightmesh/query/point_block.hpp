// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/trace.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/kernels/kernel_types.hpp>
#include <lightmesh/query/neighbours.hpp>
#include <lightmesh/query/query_point.hpp>
#include <lightmesh/query/reaching.hpp>
#include <lightmesh/query/result_rows.hpp>
#include <lightmesh/query/tally.hpp>
#include <lightmesh/support/popcount.hpp>
#include <lightmesh/support/room_for.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace lightmesh::detail {

/// Points that are asked together, each with the lights that reach it and the light points around it: bricks
/// are looked up once, and consecutive sets of light points are compared. Its memory is inside.
class PointBlock {
public:
    PointBlock(const Grid& grid, const LightTable& lights, const Kernels& kernels)
        : grid_(grid), lights_(lights), kernels_(kernels), window_(grid) {}

    /// Holds as many points of a batch as there is room for, from `first` on, in place of those before:
    /// use_brick(coordinates) is the brick there. Rows of points whose result needs no neighbours are written
    /// instead, since they are the same on all levels. Returns how many points of the batch are done with.
    template <class UseBrick>
    std::size_t take(const PointBatch& batch, std::size_t first, const ResultRows& rows,
                     UseBrick&& use_brick) {
        const std::size_t room = Hemisphere::largest_box(grid_.quality());
        std::size_t entry_count = 0;
        std::size_t next = first;
        size_ = 0;
        for (; next < batch.size() && size_ < most_points; ++next) {
            if (entry_count + room > most_entries)
                break;
            QueryPoint& point = points_.make(size_, batch.positions[next], batch.normals[next]);
            point.row = batch.rows.empty() ? next : batch.rows[next];
            point.share = batch.shares.empty() ? 1.0f : batch.shares[next];
            if (!is_finite(batch.positions[next]) || !is_finite(batch.normals[next])) {
                rows.fill(point, std::numeric_limits<float>::quiet_NaN());
                continue;
            }
            point.grid_pos = grid_.locate(point.position);
            if (!find_reaching_lights(point)) {
                rows.fill(point, 0.0f);
                continue;
            }
            entry_count += find_neighbours(point, &entries_[entry_count], use_brick);
            ++size_;
        }
        return next - first;
    }

    std::span<QueryPoint> points() { return {points_.data(), size_}; }

    /// The lights of a tile that reach a point.
    std::uint64_t reaching(const QueryPoint& point, std::size_t tile) const {
        if (tile < most_cached_tiles)
            return reaching_[static_cast<std::size_t>(&point - points_.data())][tile];
        return find_reaching(lights_, kernels_, tile, point.position, point.normal);
    }

    /// For each point how its set differs from that of the point before, if that is little.
    void find_changes() {
        std::size_t count = 0;
        for (std::size_t i = 1; i < size_; ++i) {
            QueryPoint& point = points_[i];
            const QueryPoint& before = points_[i - 1];
            const std::span<const BrickPoints> old_set = before.neighbours.entries();
            const std::span<const BrickPoints> new_set = point.neighbours.entries();
            if (point.is_uniform || before.is_uniform || point.window != before.window || old_set.empty() ||
                new_set.empty() || old_set.size() + new_set.size() > 4 * most_changes_of_point)
                continue;
            const std::size_t found = detail::find_changes(old_set, new_set, &changes_[count]);
            int changed_points = 0;
            for (std::size_t c = 0; c < found; ++c)
                changed_points += popcount(changes_[count + c].added) + popcount(changes_[count + c].removed);
            if (found > most_changes_of_point || 2 * changed_points > point.neighbours.point_count())
                continue;
            point.differs_little = true;
            point.first_change = static_cast<std::uint32_t>(count);
            point.change_count = static_cast<std::uint32_t>(found);
            count += found;
        }
    }

    std::span<const BrickChange> changes_of(const QueryPoint& point) const {
        return std::span(changes_).subspan(point.first_change, point.change_count);
    }

    /// The bricks that are looked up by now.
    BrickWindow& window() { return window_; }
    /// Whether the bricks around a point are still in the window.
    bool is_in_window(const QueryPoint& point) const { return point.window == window_count_; }

private:
    static constexpr std::size_t most_points = most_segments;
    static constexpr std::size_t most_entries = 2048;
    static constexpr std::size_t most_cached_tiles = 16;
    static constexpr std::size_t most_changes_of_point = 24;

    /// True if any light reaches the point.
    bool find_reaching_lights(const QueryPoint& point) {
        std::uint64_t any = 0;
        auto& cached = reaching_[static_cast<std::size_t>(&point - points_.data())];
        for (std::size_t t = 0; t < lights_.tile_count(); ++t) {
            const std::uint64_t lit = find_reaching(lights_, kernels_, t, point.position, point.normal);
            if (t < most_cached_tiles)
                cached[t] = lit;
            any |= lit;
            if (t >= most_cached_tiles && any != 0)
                break;
        }
        return any != 0;
    }

    template <class UseBrick>
    std::size_t find_neighbours(QueryPoint& point, BrickPoints* entries, UseBrick&& use_brick) {
        const Hemisphere hemisphere(grid_, point.grid_pos, point.position, point.normal);
        BrickMask masks[Hemisphere::most_bricks];
        const std::size_t size = kernels_.find_masks(hemisphere, masks);
        if (!window_.cover(hemisphere.first_brick, hemisphere.bricks))
            ++window_count_;
        point.window = window_count_;
        const std::uint32_t first_slot = window_.slot_of(hemisphere.first_brick);
        int point_count = 0;
        for (std::size_t i = 0; i < size; ++i) {
            const std::uint32_t slot = first_slot + window_.slots_to(masks[i]);
            const Brick*& brick = window_.brick_in(slot);
            if (brick == nullptr) [[unlikely]]
                brick = use_brick(hemisphere.first_brick + glm::ivec3(masks[i].x, masks[i].y, masks[i].z));
            entries[i] = {brick, masks[i].points, slot, 0};
            point_count += popcount(masks[i].points);
        }
        point.neighbours = Neighbours(entries, size, point_count);
        return size;
    }

    const Grid& grid_;
    const LightTable& lights_;
    const Kernels& kernels_;
    BrickWindow window_;
    std::uint32_t window_count_ = 0;  ///< of all blocks: sets of one window can be compared
    std::size_t size_ = 0;
    RoomFor<QueryPoint, most_points> points_;
    std::array<std::array<std::uint64_t, most_cached_tiles>, most_points> reaching_;
    std::array<BrickPoints, most_entries> entries_;
    std::array<BrickChange, (most_points + 4) * most_changes_of_point> changes_;
};

}  // namespace lightmesh::detail
