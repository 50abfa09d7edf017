// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/brick.hpp>
#include <lightmesh/grid.hpp>
#include <lightmesh/neighbours.hpp>
#include <lightmesh/trace.hpp>
#include <lightmesh/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <span>

/// The linked short test. A link is the bit "the segment between two neighbouring light points is open"; it
/// depends on neither P nor lights nor camera. P tests one light point by a ray, the nearest that it sees:
/// the seed. From there visibility spreads outwards over open links: every step leads away from the seed,
/// along x, y or z, and stays in the hemisphere. What is reached counts as visible from P. If no link inside
/// the hemisphere is blocked, all of it does.

namespace lightmesh::detail {

/// Steps of one light point along an axis, for all light points of a brick at once (numbering as in
/// `bit_of`).
template <std::size_t Axis>
struct AxisSteps {
    static constexpr int one = 1 << Axis;  // from the even to the odd light point of a cell
    static constexpr int across_cells = 7 * one;
    static constexpr int across_two = 8 * one;
    static constexpr int across_bricks = 9 * one;

    /// Light points whose coordinate along the axis is c.
    static constexpr std::uint64_t at(int c) {
        std::uint64_t mask = 0;
        for (int bit = 0; bit < 64; ++bit) {
            const int coordinate = (bit >> Axis & 1) + 2 * (bit >> (Axis + 3) & 1);
            if (coordinate == c)
                mask |= std::uint64_t{1} << bit;
        }
        return mask;
    }

    /// Light points whose coordinate along the axis is at least c.
    static constexpr std::uint64_t from(int c) {
        std::uint64_t mask = 0;
        for (int i = (std::max)(c, 0); i < brick_side; ++i)
            mask |= at(i);
        return mask;
    }

    /// The light points one step up from those of `points`, within the brick.
    static constexpr std::uint64_t up(std::uint64_t points) {
        return (points & (at(0) | at(2))) << one | (points & at(1)) << across_cells;
    }
    /// The light points one step down from those of `points`, within the brick.
    static constexpr std::uint64_t down(std::uint64_t points) {
        return (points & (at(1) | at(3))) >> one | (points & at(2)) >> across_cells;
    }
    /// The same, two steps.
    static constexpr std::uint64_t up_two(std::uint64_t points) {
        return (points & (at(0) | at(1))) << across_two;
    }
    static constexpr std::uint64_t down_two(std::uint64_t points) {
        return (points & (at(2) | at(3))) >> across_two;
    }
    /// The light points one step up from those of the brick below.
    static constexpr std::uint64_t up_from(std::uint64_t below) { return (below & at(3)) >> across_bricks; }
    /// The light points one step down from those of the brick above.
    static constexpr std::uint64_t down_from(std::uint64_t above) { return (above & at(0)) << across_bricks; }
};

/// A hemisphere and its links as a box of bricks, to walk in. Lives on the stack of a query.
class LinkedNeighbours {
public:
    /// The links of all cells with neighbours in them must be known.
    explicit LinkedNeighbours(const Neighbours& neighbours)
        : entries_(neighbours.entries()), first_(neighbours.first_brick()),
          bricks_(neighbours.bricks()), stride_{1, static_cast<std::size_t>(bricks_.x) + 1, 0}, size_(0) {
        stride_[2] = stride_[1] * (static_cast<std::size_t>(bricks_.y) + 1);
        size_ = stride_[2] * (static_cast<std::size_t>(bricks_.z) + 2);
        std::fill_n(points_, size_, std::uint64_t{0});
        for (const BrickPoints& entry : entries_)
            points_[slot_of(*entry.brick)] = entry.points;
    }

    /// Whether all neighbouring light points of the hemisphere are linked.
    bool all_linked() const {
        std::uint64_t blocked = 0;
        for (const BrickPoints& entry : entries_) {
            const std::size_t slot = slot_of(*entry.brick);
            blocked |= usable_links<0>(slot) & ~entry.brick->links().open(0);
            blocked |= usable_links<1>(slot) & ~entry.brick->links().open(1);
            blocked |= usable_links<2>(slot) & ~entry.brick->links().open(2);
        }
        return blocked == 0;
    }

    /// Finds what is reached from a light point of the hemisphere.
    void spread_from(const glm::ivec3& seed) {
        std::fill_n(reached_, size_, std::uint64_t{0});
        for (auto& leaving : leaving_)
            std::fill_n(leaving, size_, std::uint64_t{0});
        const glm::ivec3 home = brick_of(seed);
        reached_[slot_of(home - first_)] = std::uint64_t{1} << bit_of(seed.x & 3, seed.y & 3, seed.z & 3);

        // A brick depends only on bricks nearer to the seed: in order of their distance, each needs one
        // visit.
        std::array<std::uint16_t, Hemisphere::max_entries> order;
        sort_by_distance(home, order);
        for (std::size_t i = 0; i < entries_.size(); ++i)
            spread_in(*entries_[order[i]].brick, seed);
    }

    /// What `spread_from` has reached of a brick.
    std::uint64_t reached(const Brick& brick) const { return reached_[slot_of(brick)]; }

private:
    static constexpr std::size_t side = Hemisphere::max_bricks_per_axis + 1;
    static constexpr std::size_t capacity = side * side * (side + 1);
    static constexpr std::size_t distances = 3 * (Hemisphere::max_bricks_per_axis - 1) + 1;

    static glm::ivec3 brick_of(const glm::ivec3& index) { return {index.x >> 2, index.y >> 2, index.z >> 2}; }

    // Each row and each slab ends with one empty brick, and an empty slab stands on either side, so that a
    // brick's neighbours are always one stride away.
    std::size_t slot_of(const glm::ivec3& brick) const {
        return static_cast<std::size_t>(brick.x) + stride_[1] * static_cast<std::size_t>(brick.y) +
               stride_[2] * static_cast<std::size_t>(brick.z + 1);
    }
    std::size_t slot_of(const Brick& brick) const { return slot_of(brick.place() - first_); }

    /// Light points with their upper neighbour along the axis in the hemisphere too.
    template <std::size_t Axis>
    std::uint64_t usable_links(std::size_t slot) const {
        using Steps = AxisSteps<Axis>;
        return points_[slot] & (Steps::down(points_[slot]) | Steps::down_from(points_[slot + stride_[Axis]]));
    }

    /// Counting sort of the entries by the city-block distance of their bricks.
    void sort_by_distance(const glm::ivec3& home,
                          std::array<std::uint16_t, Hemisphere::max_entries>& order) const {
        std::array<std::uint16_t, distances + 1> begin{};
        const auto distance = [&](const BrickPoints& entry) {
            const glm::ivec3 way = entry.brick->place() - home;
            return static_cast<std::size_t>(std::abs(way.x) + std::abs(way.y) + std::abs(way.z));
        };
        for (const BrickPoints& entry : entries_)
            ++begin[distance(entry) + 1];
        for (std::size_t d = 1; d < begin.size(); ++d)
            begin[d] = static_cast<std::uint16_t>(begin[d] + begin[d - 1]);
        for (std::size_t i = 0; i < entries_.size(); ++i)
            order[begin[distance(entries_[i])]++] = static_cast<std::uint16_t>(i);
    }

    /// Takes over what a brick's neighbours have reached and lets it spread within the brick.
    void spread_in(const Brick& brick, const glm::ivec3& seed) {
        const std::size_t slot = slot_of(brick);
        const glm::ivec3 from_brick = seed - brick_side * brick.place();
        std::uint64_t reached = reached_[slot];
        const auto x = arrive<0>(brick, slot, from_brick.x, reached);
        const auto y = arrive<1>(brick, slot, from_brick.y, reached);
        const auto z = arrive<2>(brick, slot, from_brick.z, reached);
        if (reached == 0)
            return;
        std::uint64_t before;
        do {
            before = reached;
            reached = z.spread(y.spread(x.spread(reached)));
        } while (reached != before && reached != points_[slot]);
        reached_[slot] = reached;
        for (std::size_t axis = 0; axis < 3; ++axis)
            leaving_[axis][slot] = reached & brick.links().open(axis);
    }

    /// The open links within a brick along an axis, by the direction that leads away from the seed.
    template <std::size_t Axis>
    struct OutwardLinks {
        using Steps = AxisSteps<Axis>;
        std::uint64_t upwards;      // light points with a link to the one above
        std::uint64_t downwards;    // light points with a link from the one above
        std::uint64_t two_upwards;  // the same over two links
        std::uint64_t two_downwards;

        OutwardLinks(std::uint64_t up, std::uint64_t down)
            : upwards(up), downwards(down), two_upwards(up & Steps::down(up)),
              two_downwards(down & Steps::down(down)) {}

        /// As far as it goes: over three links, by one and by two.
        std::uint64_t spread(std::uint64_t reached) const {
            reached |= Steps::up(reached & upwards) | (Steps::down(reached) & downwards);
            return reached | Steps::up_two(reached & two_upwards) |
                   (Steps::down_two(reached) & two_downwards);
        }
    };

    /// Adds to `reached` what comes along an axis from the brick next to it, and returns the links to go on
    /// with. `seed` is the seed's coordinate along the axis, counted from the brick's first light point.
    template <std::size_t Axis>
    OutwardLinks<Axis> arrive(const Brick& brick, std::size_t slot, int seed, std::uint64_t& reached) const {
        using Steps = AxisSteps<Axis>;
        const std::uint64_t open = brick.links().open(Axis) & points_[slot];
        if (seed >= brick_side)
            reached |= Steps::down_from(reached_[slot + stride_[Axis]]) & open;
        else if (seed < 0)
            reached |= Steps::up_from(leaving_[Axis][slot - stride_[Axis]]) & points_[slot];
        constexpr std::uint64_t above_seed[] = {Steps::from(0), Steps::from(1), Steps::from(2),
                                                Steps::from(3), 0};
        const std::uint64_t above = above_seed[std::clamp(seed, 0, brick_side)];
        const std::uint64_t inner = open & Steps::down(points_[slot]);
        return {inner & above, inner & ~above};
    }

    std::span<const BrickPoints> entries_;
    glm::ivec3 first_;
    glm::ivec3 bricks_;
    std::array<std::size_t, 3> stride_;
    std::size_t size_;
    std::uint64_t points_[capacity];
    std::uint64_t reached_[capacity];
    std::uint64_t leaving_[3][capacity];  // reached, and with an open link upwards
};

/// Finds the links of the cells in `missing` (one bit a cell) by rays and stores them: from each light point
/// one step up along x, y and z. Returns the number of rays.
template <Intersector Tracer>
std::uint64_t fill_links(const Tracer& tracer, const Grid& grid, Brick& brick, std::uint32_t missing) {
    std::uint64_t rays = 0;
    for (std::uint32_t rest = missing; rest != 0; rest &= rest - 1) {
        const int cell = std::countr_zero(rest);
        std::array<Segment, 24> segments;
        std::array<std::uint8_t, 24> hit;
        for (int axis = 0; axis < 3; ++axis) {
            for (int p = 0; p < 8; ++p) {
                const glm::ivec3 index = index_of(brick, 8 * cell + p);
                glm::ivec3 next = index;
                ++next[axis];
                segments[static_cast<std::size_t>(8 * axis + p)] = {grid.position(index),
                                                                    grid.position(next)};
            }
        }
        trace(tracer, std::span<const Segment>(segments), std::span(hit));
        std::array<std::uint64_t, 3> open{};
        for (std::size_t i = 0; i < segments.size(); ++i)
            if (hit[i] == 0)
                open[i / 8] |= std::uint64_t{1} << (static_cast<std::size_t>(8 * cell) + i % 8);
        brick.links().publish(cell, open);
        rays += segments.size();
    }
    return rays;
}

/// The light points that a surface point may test by a ray: the corners of the grid cube that holds a place
/// just in front of it, one after the other, nearest first. In front by more than the tie rule of
/// `Hemisphere` asks for, so that the cube of a wall on a grid plane is the one before it, not the one
/// behind.
class NearestCorners {
public:
    NearestCorners() = default;

    NearestCorners(const Grid& grid, const glm::vec3& point, const glm::vec3& unit_normal) {
        const double rounding = static_cast<double>(largest_component(point)) * 0x1p-20 / grid.step();
        const glm::dvec3 place = grid.locate(point) + (0x1p-8 + rounding) * glm::dvec3(unit_normal);
        low_ = {floor_to_int(place.x), floor_to_int(place.y), floor_to_int(place.z)};
        const glm::vec3 fraction(place - glm::dvec3(low_));
        for (std::size_t c = 0; c < 8; ++c) {
            const glm::vec3 way = glm::vec3(step_to(c)) - fraction;
            squares_[c] = way.x * way.x + way.y * way.y + way.z * way.z;
        }
        left_ = 8;
    }

    bool empty() const { return left_ == 0; }

    /// Only if not `empty`.
    glm::ivec3 next() {
        const auto nearest = std::min_element(squares_.begin(), squares_.end());
        *nearest = std::numeric_limits<float>::infinity();
        --left_;
        return low_ + step_to(static_cast<std::size_t>(nearest - squares_.begin()));
    }

private:
    static glm::ivec3 step_to(std::size_t corner) {
        return {static_cast<int>(corner & 1), static_cast<int>(corner >> 1 & 1),
                static_cast<int>(corner >> 2)};
    }

    glm::ivec3 low_{0};
    std::array<float, 8> squares_{};
    int left_ = 0;
};

}  // namespace lightmesh::detail
