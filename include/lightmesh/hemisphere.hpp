// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/grid.hpp>
#include <lightmesh/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

/// The hemisphere of equation (2) without its short test: { x in LM : |P - x| < r, (n, x - P) > 0 }, as one
/// 64-bit mask for each brick of 4x4x4 light points.

namespace lightmesh::detail {

/// The light points of a brick are numbered cell by cell: bits 8c .. 8c+7 of a mask are the 2x2x2 light
/// points of cell c. Within a brick, light point (x, y, z), each in 0..3, lies in cell (x/2) + 2 (y/2) + 4
/// (z/2) and is its point number (x%2) + 2 (y%2) + 4 (z%2).
inline constexpr int brick_side = 4;
inline constexpr int cells_per_brick = 8;

/// The number of a light point within its brick.
constexpr int bit_of(int x, int y, int z) {
    return 8 * (x / 2 + 2 * (y / 2) + 4 * (z / 2)) + x % 2 + 2 * (y % 2) + 4 * (z % 2);
}

/// The place of a light point within its brick: the inverse of `bit_of`.
inline glm::ivec3 place_of(int bit) {
    const int cell = bit / 8;
    return {2 * (cell % 2) + bit % 2, 2 * (cell / 2 % 2) + bit / 2 % 2, 2 * (cell / 4) + bit / 4 % 2};
}

/// A hemisphere around a surface point, in fixed-point numbers, over a box of bricks.
///
/// Positions are rounded to 2^-f steps, f = 11 up to q = 8 and 10 above, and normals to 2^-15 of their
/// length: the masks are exact in these integers, so every compiler and instruction set yields the same bits.
/// The one rule for ties: a light point belongs to the hemisphere only if it lies more than 2^(1-f) steps,
/// plus what the point's own float coordinates may be off (|P|_inf * 2^-22), above the tangent plane. Thus
/// the light points of a grid plane are out for all points of a wall that lies on it. The distance has no
/// such band: |x - P| < r.
///
/// Both conditions are sums over the axes, so three short tables per condition hold all of it: the squared
/// distance and the height over the tangent plane of light point (x, y, z) are the sums of entries x, y and
/// z.
class Hemisphere {
public:
    static constexpr int max_bricks_per_axis = 10;  // 2q + 1 <= 33 light points
    static constexpr int max_entries = max_bricks_per_axis * max_bricks_per_axis * max_bricks_per_axis;

    Hemisphere() = default;

    /// Of `normal` only the direction counts; a zero normal gives an empty hemisphere. Both must be finite.
    /// Throws std::out_of_range for a point outside the grid.
    Hemisphere(const Grid& grid, const glm::vec3& point, const glm::vec3& normal) {
        const glm::dvec3 place = grid.locate(point);
        const double quality = static_cast<double>(grid.quality());
        const int fraction_bits = fraction_bits_of(quality);
        const double one = static_cast<double>(1 << fraction_bits);
        radius_squared_ = static_cast<std::int32_t>(std::ceil(quality * quality * one * one));

        const glm::vec3 direction = unit_or_zero(normal);
        const double rounding = static_cast<double>(largest_component(point)) * 0x1p-22 / grid.step();
        constexpr double normal_one = 1 << normal_bits;
        lowest_height_ =
            static_cast<std::int32_t>((std::min)(normal_one * (2.0 + one * rounding), 2147483647.0));

        for (int axis = 0; axis < 3; ++axis) {
            const double at = place[axis];
            const auto first = static_cast<std::int32_t>(std::floor(at - quality)) >> 2;
            const auto last = static_cast<std::int32_t>(std::floor(at + quality)) >> 2;
            first_brick_[axis] = first;
            bricks_[axis] = last - first + 1;
            const auto position =
                static_cast<std::int32_t>(std::lrint((at - static_cast<double>(first * brick_side)) * one));
            const auto slope =
                static_cast<std::int32_t>(std::lrint(static_cast<double>(direction[axis]) * normal_one));
            fill_axis(axis, position, slope, fraction_bits);
        }
    }

    /// Of the box of bricks that the ball touches: index of its first brick, and number of bricks, in each
    /// axis.
    const glm::ivec3& first_brick() const { return first_brick_; }
    const glm::ivec3& bricks() const { return bricks_; }

    /// Calls visit(brick, mask) for each brick of the box whose mask is not 0; `brick` counts from
    /// `first_brick`.
    template <class Kernel, class Visitor>
    void for_each_brick(Visitor&& visit) const {
        for (int z = 0; z < bricks_.z; ++z) {
            for (int y = 0; y < bricks_.y; ++y) {
                const std::int32_t square_zy = least_square_[2][z] + least_square_[1][y];
                const std::int32_t height_zy = greatest_height_[2][z] + greatest_height_[1][y];
                if (square_zy >= radius_squared_)
                    continue;
                for (int x = 0; x < bricks_.x; ++x) {
                    if (square_zy + least_square_[0][x] >= radius_squared_ ||
                        height_zy + greatest_height_[0][x] <= lowest_height_)
                        continue;
                    const std::uint64_t mask =
                        Kernel::brick_mask({&square_[0][4 * x], &square_[1][4 * y], &square_[2][4 * z]},
                                           {&height_[0][4 * x], &height_[1][4 * y], &height_[2][4 * z]},
                                           radius_squared_, lowest_height_);
                    if (mask != 0)
                        visit(glm::ivec3(x, y, z), mask);
                }
            }
        }
    }

private:
    static constexpr int normal_bits = 15;
    static constexpr int max_points_per_axis = brick_side * max_bricks_per_axis;

    /// As many as keep 3 (q + 4)^2, the greatest squared distance in the box, within 31 bits.
    static int fraction_bits_of(double quality) { return quality <= 8.0 ? 11 : 10; }

    void fill_axis(int axis, std::int32_t position, std::int32_t slope, int fraction_bits) {
        const auto a = static_cast<std::size_t>(axis);
        const int count = brick_side * bricks_[axis];
        for (int i = 0; i < count; ++i) {
            const std::int32_t distance = (i << fraction_bits) - position;
            square_[a][static_cast<std::size_t>(i)] = distance * distance;
            height_[a][static_cast<std::size_t>(i)] = distance * slope;
        }
        for (int b = 0; b < bricks_[axis]; ++b) {
            const std::int32_t* square = &square_[a][static_cast<std::size_t>(4 * b)];
            const std::int32_t* height = &height_[a][static_cast<std::size_t>(4 * b)];
            least_square_[a][b] =
                (std::min)((std::min)(square[0], square[1]), (std::min)(square[2], square[3]));
            greatest_height_[a][b] = (std::max)(height[0], height[3]);
        }
    }

    glm::ivec3 first_brick_{0};
    glm::ivec3 bricks_{0};
    std::int32_t radius_squared_ = 0;
    std::int32_t lowest_height_ = 0;
    alignas(64) std::int32_t square_[3][max_points_per_axis];
    alignas(64) std::int32_t height_[3][max_points_per_axis];
    std::int32_t least_square_[3][max_bricks_per_axis];
    std::int32_t greatest_height_[3][max_bricks_per_axis];
};

}  // namespace lightmesh::detail
