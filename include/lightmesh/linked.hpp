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
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

/// The linked short test. A link is the bit "the segment between two neighbouring light points is open"; it
/// depends on neither P nor lights nor camera. P itself tests one light point by a ray, the nearest it can
/// see; what can be reached from there over open links, without leaving the hemisphere, counts as visible. If no
/// link inside the hemisphere is blocked, all of it does.

namespace lightmesh::detail {

/// Steps of one light point along an axis, for all light points of a brick at once (numbering as in
/// `bit_of`).
template <int Axis>
struct AxisSteps {
    static constexpr int one = 1 << Axis;  // from the even to the odd light point of a cell
    static constexpr int across_cells = 7 * one;
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

    /// The light points one step up from those of `points`, and from those of the brick `below`.
    static constexpr std::uint64_t up(std::uint64_t points, std::uint64_t below) {
        return (points & (at(0) | at(2))) << one | (points & at(1)) << across_cells |
               (below & at(3)) >> across_bricks;
    }
    /// The light points one step down from those of `points`, and from those of the brick `above`.
    static constexpr std::uint64_t down(std::uint64_t points, std::uint64_t above) {
        return (points & (at(1) | at(3))) >> one | (points & at(2)) >> across_cells |
               (above & at(0)) << across_bricks;
    }
};

/// A hemisphere and its links as a box of bricks, to walk in. Lives on the stack.
class LinkedNeighbours {
public:
    LinkedNeighbours(const Neighbours& neighbours, const Hemisphere& hemisphere)
        : first_(hemisphere.first_brick()), stride_y_(static_cast<std::size_t>(hemisphere.bricks().x) + 1),
          stride_z_(stride_y_ * (static_cast<std::size_t>(hemisphere.bricks().y) + 1)),
          size_(stride_z_ * static_cast<std::size_t>(hemisphere.bricks().z)) {
        for (std::uint64_t* words : {points_, open_[0], open_[1], open_[2], seen_})
            std::fill_n(words, size_ + 2 * stride_z_, std::uint64_t{0});
        for (const BrickPoints& entry : neighbours.entries()) {
            const std::size_t i = place_of_brick(*entry.brick);
            points_[i] = entry.points;
            for (std::size_t axis = 0; axis < 3; ++axis)
                open_[axis][i] = entry.brick->links().open(axis);
        }
    }

    /// Whether a light point belongs to the hemisphere.
    bool contains(const glm::ivec3& index) const {
        const glm::ivec3 brick = brick_of(index) - first_;
        if (brick.x < 0 || brick.y < 0 || brick.z < 0)
            return false;
        const std::size_t i = place_of_brick(brick);
        return i < size_ + stride_z_ &&
               (points_[i] >> bit_of(index.x & 3, index.y & 3, index.z & 3) & 1) != 0;
    }

    /// Whether all neighbouring light points of the hemisphere are linked.
    bool all_linked() const { return !(any_blocked<0>() || any_blocked<1>() || any_blocked<2>()); }

    /// Finds what can be reached from a light point.
    void flood(const glm::ivec3& seed) {
        const glm::ivec3 brick = brick_of(seed) - first_;
        seen_[place_of_brick(brick)] = std::uint64_t{1} << bit_of(seed.x & 3, seed.y & 3, seed.z & 3);
        bool grown = true;
        while (grown) {
            std::uint64_t fresh = 0;
            fresh |= spread_up<0>(1);
            fresh |= spread_up<1>(stride_y_);
            fresh |= spread_up<2>(stride_z_);
            fresh |= spread_down<0>(1);
            fresh |= spread_down<1>(stride_y_);
            fresh |= spread_down<2>(stride_z_);
            grown = fresh != 0;
        }
    }

    /// What `flood` has reached of a brick.
    std::uint64_t reached(const Brick& brick) const { return seen_[place_of_brick(brick)]; }

private:
    static constexpr std::size_t side = Hemisphere::max_bricks_per_axis + 1;
    static constexpr std::size_t capacity = side * side * (side + 1);

    static glm::ivec3 brick_of(const glm::ivec3& index) { return {index.x >> 2, index.y >> 2, index.z >> 2}; }

    // Each row and each slab ends with one empty brick, and an empty slab stands on either side, so that a
    // brick's neighbours are always one stride away.
    std::size_t place_of_brick(const glm::ivec3& brick) const {
        return static_cast<std::size_t>(brick.x) + stride_y_ * static_cast<std::size_t>(brick.y) +
               stride_z_ * static_cast<std::size_t>(brick.z + 1);
    }
    std::size_t place_of_brick(const Brick& brick) const { return place_of_brick(brick.place() - first_); }

    template <int Axis>
    bool any_blocked() const {
        const std::size_t stride = Axis == 0 ? 1 : Axis == 1 ? stride_y_ : stride_z_;
        std::uint64_t blocked = 0;
        for (std::size_t i = stride_z_; i < stride_z_ + size_; ++i)
            blocked |= points_[i] & AxisSteps<Axis>::down(points_[i], points_[i + stride]) & ~open_[Axis][i];
        return blocked != 0;
    }

    template <int Axis>
    std::uint64_t spread_up(std::size_t stride) {
        std::uint64_t fresh = 0;
        std::uint64_t leaving[capacity];
        for (std::size_t i = stride_z_ - stride; i < stride_z_ + size_; ++i)
            leaving[i] = seen_[i] & open_[Axis][i];
        for (std::size_t i = stride_z_; i < stride_z_ + size_; ++i) {
            const std::uint64_t more =
                AxisSteps<Axis>::up(leaving[i], leaving[i - stride]) & points_[i] & ~seen_[i];
            fresh |= more;
            seen_[i] |= more;
        }
        return fresh;
    }

    template <int Axis>
    std::uint64_t spread_down(std::size_t stride) {
        std::uint64_t fresh = 0;
        for (std::size_t i = stride_z_; i < stride_z_ + size_; ++i) {
            const std::uint64_t more =
                AxisSteps<Axis>::down(seen_[i], seen_[i + stride]) & open_[Axis][i] & points_[i] & ~seen_[i];
            fresh |= more;
            seen_[i] |= more;
        }
        return fresh;
    }

    glm::ivec3 first_;
    std::size_t stride_y_;
    std::size_t stride_z_;
    std::size_t size_;
    std::uint64_t points_[capacity];
    std::uint64_t open_[3][capacity];
    std::uint64_t seen_[capacity];
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
/// just in front of it, nearest first. In front by more than the tie rule of `Hemisphere` asks for, so that the
/// cube of a wall on a grid plane is the one before it, not the one behind.
inline std::array<glm::ivec3, 8> light_points_around(const Grid& grid, const glm::vec3& point,
                                                     const glm::vec3& unit_normal) {
    const double rounding = static_cast<double>(largest_component(point)) * 0x1p-20 / grid.step();
    const glm::dvec3 place = grid.locate(point) + (0x1p-8 + rounding) * glm::dvec3(unit_normal);
    const glm::ivec3 low(static_cast<int>(std::floor(place.x)), static_cast<int>(std::floor(place.y)),
                         static_cast<int>(std::floor(place.z)));
    const glm::dvec3 fraction = place - glm::dvec3(low);
    // Distances are not negative: their bits are in the same order as they. The corner's number breaks ties.
    std::array<std::uint64_t, 8> keys;
    for (std::uint32_t c = 0; c < 8; ++c) {
        const glm::dvec3 way = glm::dvec3(c & 1, c >> 1 & 1, c >> 2) - fraction;
        const auto distance = static_cast<float>(way.x * way.x + way.y * way.y + way.z * way.z);
        keys[c] = std::uint64_t{std::bit_cast<std::uint32_t>(distance)} << 3 | c;
    }
    std::ranges::sort(keys);
    std::array<glm::ivec3, 8> nearest_first;
    for (std::size_t i = 0; i < 8; ++i) {
        const auto c = static_cast<int>(keys[i] & 7);
        nearest_first[i] = low + glm::ivec3(c & 1, c >> 1 & 1, c >> 2);
    }
    return nearest_first;
}

}  // namespace lightmesh::detail
