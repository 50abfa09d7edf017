// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/brick_map.hpp>
#include <lightmesh/mesh/flood_search.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace lightmesh::detail {

/// What a light mesh is made of: the user's adapters, lights and settings, and all that queries have found
/// out about light points so far. Finds out more when it is asked for what it does not know; to its users it
/// is constant, and any number of threads may ask.
template <Intersector Tracer, class LongTest>
class VisibilityStore {
public:
    template <class... LongTestArguments>
    VisibilityStore(Tracer tracer, std::span<const Light> lights, const Settings& settings,
                    LongTestArguments&&... long_test)
        : tracer_(std::move(tracer)), settings_(settings), grid_(settings), lights_(lights, grid_),
          long_test_(std::forward<LongTestArguments>(long_test)...), bricks_(lights_.tile_count()) {}

    const Tracer& tracer() const { return tracer_; }
    const Settings& settings() const { return settings_; }
    const Grid& grid() const { return grid_; }
    const LightTable& lights() const { return lights_; }
    BrickMap& bricks() const { return bricks_; }

    /// A tile of a brick, after making sure that it knows the units in `needed` (see `BrickTile`).
    const BrickTile& known_tile(Brick& brick, std::size_t t, std::uint64_t needed) const {
        BrickTile& tile = brick.tile(t);
        const std::uint64_t missing = needed & ~tile.known();
        if (missing != 0) [[unlikely]]
            fill(brick, t, missing);
        return tile;
    }

    /// What a light point of the brick reaches over links.
    const Reach& reach_of(const Brick& brick, const glm::ivec3& seed) const {
        if (const Reach* known = brick.reach_of(bit_of(seed.x & 3, seed.y & 3, seed.z & 3)))
            return *known;
        return find_reach(seed);
    }

    /// Walks over all that is stored.
    MeshStatistics statistics() const {
        MeshStatistics sum;
        bricks_.for_each([&](const Brick& brick) {
            std::uint64_t cells = 0;
            for (std::size_t t = 0; t < lights_.tile_count(); ++t)
                cells |= cells_in(brick.tile(t).known());
            // 8 bits for each cell of 8 light points.
            sum.light_points += static_cast<std::size_t>(std::popcount(cells));
            ++sum.bricks;
        });
        sum.long_tests = long_tests_.load(std::memory_order_relaxed);
        sum.long_rays = long_rays_.load(std::memory_order_relaxed);
        sum.link_rays = link_rays_.load(std::memory_order_relaxed);
        sum.bytes = bricks_.bytes() + sizeof *this + lights_.bytes() + long_test_.bytes();
        return sum;
    }

private:
    /// Finds units by long tests and stores them.
    void fill(Brick& brick, std::size_t t, std::uint64_t missing) const {
        BrickTile& tile = brick.tile(t);
        const int groups = lights_.tile_groups(t);
        bricks_.ensure_storage(tile, groups);
        std::array<std::uint64_t, 64> units;
        LongTestCost cost;
        for (std::uint64_t rest = missing; rest != 0; rest &= rest - 1) {
            const int unit = std::countr_zero(rest);
            const int group = unit % 8;
            CellPoints points;
            for (int p = 0; p < 8; ++p)
                points[static_cast<std::size_t>(p)] = grid_.position(index_of(brick, unit - group + p));
            const int count = (std::min)(8, lights_.tile_size(t) - 8 * group);
            const std::size_t first = t * lights_per_tile + static_cast<std::size_t>(8 * group);
            units[static_cast<std::size_t>(unit)] =
                long_test_(tracer_, LongTestUnit{lights_, first, count, points, grid_.radius()}, cost);
        }
        brick.publish(t, missing, units.data(), groups);
        long_tests_.fetch_add(cost.tests, std::memory_order_relaxed);
        long_rays_.fetch_add(cost.rays, std::memory_order_relaxed);
    }

    const Reach& find_reach(const glm::ivec3& seed) const {
        ReachSearch search(tracer_, grid_, bricks_, seed);
        const Reach* found = search.find();
        link_rays_.fetch_add(search.rays(), std::memory_order_relaxed);
        return *found;
    }

    Tracer tracer_;
    Settings settings_;
    Grid grid_;
    LightTable lights_;
    LongTest long_test_;
    mutable BrickMap bricks_;
    mutable std::atomic<std::uint64_t> long_tests_{0};
    mutable std::atomic<std::uint64_t> long_rays_{0};
    mutable std::atomic<std::uint64_t> link_rays_{0};
};

}  // namespace lightmesh::detail
