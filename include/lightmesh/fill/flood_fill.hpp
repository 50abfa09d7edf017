// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/fill/link_fill.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/links.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/support/atomics.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace lightmesh::detail {

/// Finds what a seed reaches, and on the way the links that this takes; makes the bricks that hold them.
/// Lives on the stack.
template <Intersector Tracer>
class FloodSearch {
public:
    FloodSearch(const Tracer& tracer, MeshData& data, const Brick& home, const glm::ivec3& seed)
        : tracer_(tracer), data_(data), seed_(seed), box_(seed, data.grid().quality()),
          slots_(FloodBox::slots(data.grid().quality())), home_(home) {
        std::fill_n(asked_, slots_, std::uint64_t{0});
        std::fill_n(reached_, slots_, std::uint64_t{0});
        std::fill_n(found_, slots_, static_cast<const Brick*>(nullptr));
    }

    /// Index of what is kept of it, by whoever was the first to find it.
    std::uint32_t find() {
        mark_asked();
        const glm::ivec3 home = brick_of(seed_);
        reached_[box_.slot(home)] = std::uint64_t{1} << bit_in_brick(seed_);
        // A brick depends only on bricks nearer to the seed: in order of their distance, each needs one
        // visit.
        const int farthest = 3 * (box_.side - 1);
        for (int distance = 0; distance <= farthest; ++distance)
            for_bricks_at(home, distance, [&](const glm::ivec3& coord) { spread_in(coord); });
        return data_.publish_flood(home_, bit_in_brick(seed_),
                                   FloodRecord({reached_, slots_}, {asked_, slots_}));
    }

    std::uint64_t rays() const { return rays_; }

private:
    /// The light points that a hemisphere next to the seed can have.
    void mark_asked() {
        const float radius = FloodBox::radius(data_.grid().quality());
        const auto square = static_cast<int>(radius * radius);
        const int steps = static_cast<int>(radius);
        for (int z = -steps; z <= steps; ++z) {
            for (int y = -steps; y <= steps; ++y) {
                for (int x = -steps; x <= steps; ++x) {
                    if (x * x + y * y + z * z > square)
                        continue;
                    const glm::ivec3 at = seed_ + glm::ivec3(x, y, z);
                    asked_[box_.slot(brick_of(at))] |= std::uint64_t{1} << bit_in_brick(at);
                }
            }
        }
    }

    template <class Visitor>
    void for_bricks_at(const glm::ivec3& home, int distance, Visitor&& visit) const {
        for (int z = -distance; z <= distance; ++z) {
            const int left = distance - std::abs(z);
            for (int y = -left; y <= left; ++y) {
                const int x = left - std::abs(y);
                for (const int side : {-x, x}) {
                    const glm::ivec3 coord = home + glm::ivec3(side, y, z);
                    if (box_.contains(coord))
                        visit(coord);
                    if (x == 0)
                        break;
                }
            }
        }
    }

    /// Takes over what a brick's neighbours have reached and lets it spread within the brick.
    void spread_in(const glm::ivec3& coord) {
        const std::size_t slot = box_.slot(coord);
        const glm::ivec3 seed = seed_ - brick_side * coord;  // counted from the brick's first light point
        std::uint64_t reached = reached_[slot];
        arrive_from_below<0>(coord, seed.x, reached);
        arrive_from_below<1>(coord, seed.y, reached);
        arrive_from_below<2>(coord, seed.z, reached);
        const std::array<std::uint64_t, 3> from_above{before_from_above<0>(coord, seed.x),
                                                      before_from_above<1>(coord, seed.y),
                                                      before_from_above<2>(coord, seed.z)};
        // Behind links that this brick holds.
        const std::uint64_t waiting = (from_above[0] | from_above[1] | from_above[2]) & asked_[slot];
        if (((reached & asked_[slot]) | waiting) == 0)
            return;
        const Brick& brick = brick_in(slot, coord);
        ensure_links(brick, waiting);
        for (std::size_t axis = 0; axis < 3; ++axis)
            reached |= from_above[axis] & load_relaxed(brick.links[axis]);
        reached_[slot] = spread(brick, seed, reached & asked_[slot], asked_[slot]);
    }

    /// The bits that step up along the axis from the brick below, if that is the way away from the seed.
    template <std::size_t Axis>
    void arrive_from_below(const glm::ivec3& coord, int seed, std::uint64_t& reached) {
        if (seed >= 0)
            return;
        glm::ivec3 below = coord;
        --below[Axis];
        const std::size_t slot = box_.slot(below);
        if (reached_[slot] != 0)
            reached |= AxisSteps<Axis>::up_from(reached_[slot] & load_relaxed(found_[slot]->links[Axis]));
    }

    /// The bits that would step down along the axis from the brick above, if that is the way away from the
    /// seed.
    template <std::size_t Axis>
    std::uint64_t before_from_above(const glm::ivec3& coord, int seed) const {
        if (seed < brick_side)
            return 0;
        glm::ivec3 above = coord;
        ++above[Axis];
        return AxisSteps<Axis>::down_from(reached_[box_.slot(above)]);
    }

    /// The light points that are reached within a brick from some of its light points. Asks for links only
    /// where they matter.
    std::uint64_t spread(const Brick& brick, const glm::ivec3& seed, std::uint64_t reached,
                         std::uint64_t asked) {
        for (;;) {
            const std::uint64_t below =
                (below_of<0>(reached, seed.x) | below_of<1>(reached, seed.y) | below_of<2>(reached, seed.z)) &
                asked;
            ensure_links(brick, reached | below);
            const std::uint64_t more = (reached | step<0>(brick, reached, seed.x) |
                                        step<1>(brick, reached, seed.y) | step<2>(brick, reached, seed.z)) &
                                       asked;
            if (more == reached)
                return reached;
            reached = more;
        }
    }

    /// Light points of the brick on the far side of the seed along an axis, the seed's own plane with those
    /// above.
    template <std::size_t Axis>
    static std::uint64_t from_seed_up(int seed) {
        constexpr std::array<std::uint64_t, 5> above{AxisSteps<Axis>::from(0), AxisSteps<Axis>::from(1),
                                                     AxisSteps<Axis>::from(2), AxisSteps<Axis>::from(3), 0};
        return above[static_cast<std::size_t>(std::clamp(seed, 0, brick_side))];
    }

    /// One step down from light points, where that leads away from the seed.
    template <std::size_t Axis>
    static std::uint64_t below_of(std::uint64_t reached, int seed) {
        return AxisSteps<Axis>::down(reached) & ~from_seed_up<Axis>(seed);
    }

    /// One step over open links away from the seed.
    template <std::size_t Axis>
    static std::uint64_t step(const Brick& brick, std::uint64_t reached, int seed) {
        const std::uint64_t open = load_relaxed(brick.links[Axis]);
        return AxisSteps<Axis>::up(reached & open & from_seed_up<Axis>(seed)) |
               (below_of<Axis>(reached, seed) & open);
    }

    void ensure_links(const Brick& brick, std::uint64_t points) {
        const std::uint32_t missing = cell_bits(points) & ~std::uint32_t{load_acquire(brick.links_known)};
        if (missing != 0)
            rays_ += fill_links(data_, tracer_, brick, missing);
    }

    const Brick& brick_in(std::size_t slot, const glm::ivec3& coord) {
        if (found_[slot] == nullptr)
            found_[slot] = &data_.find_or_make_brick(coord);
        return *found_[slot];
    }

    const Tracer& tracer_;
    MeshData& data_;
    glm::ivec3 seed_;
    FloodBox box_;
    std::size_t slots_;
    const Brick& home_;
    std::uint64_t rays_ = 0;
    std::uint64_t asked_[FloodBox::max_slots];
    std::uint64_t reached_[FloodBox::max_slots];
    const Brick* found_[FloodBox::max_slots];
};

}  // namespace lightmesh::detail
