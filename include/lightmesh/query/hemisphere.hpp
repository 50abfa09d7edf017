// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/query/kernels/portable.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

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

    /// Of `normal` only the direction counts; a zero normal gives an empty hemisphere. Both must be finite.
    /// Throws std::out_of_range for a point outside the grid.
    Hemisphere(const Grid& grid, const glm::vec3& point, const glm::vec3& normal)
        : place_(grid.locate(point)) {
        const double quality = static_cast<double>(grid.quality());
        const int fraction_bits = fraction_bits_of(quality);
        const double one = static_cast<double>(1 << fraction_bits);
        radius_squared_ = static_cast<std::int32_t>(std::ceil(quality * quality * one * one));

        constexpr double normal_one = 1 << normal_bits;
        const double rounding = static_cast<double>(largest_component(point)) * 0x1p-22 / grid.step();
        lowest_height_ =
            static_cast<std::int32_t>((std::min)(normal_one * (2.0 + one * rounding), 2147483647.0));

        const glm::vec3 direction = unit_or_zero(normal);
        for (int axis = 0; axis < 3; ++axis) {
            const double at = place_[axis];
            first_brick_[axis] = floor_to_int(at - quality) >> 2;
            bricks_[axis] = (floor_to_int(at + quality) >> 2) - first_brick_[axis] + 1;
            const double from_first = at - static_cast<double>(first_brick_[axis] * brick_side);
            const std::int32_t position = floor_to_int(from_first * one + 0.5);
            const std::int32_t slope = floor_to_int(static_cast<double>(direction[axis]) * normal_one + 0.5);
            fill_axis(static_cast<std::size_t>(axis), position, slope, fraction_bits);
        }
    }

    /// The surface point, in steps (see `Grid::locate`).
    const glm::dvec3& place() const { return place_; }

    /// Of the box of bricks that the ball touches: index of its first brick, and number of bricks, in each
    /// axis.
    const glm::ivec3& first_brick() const { return first_brick_; }
    const glm::ivec3& bricks() const { return bricks_; }

    /// Calls visit(y, z, masks) for the rows of bricks along x that may hold any of the hemisphere's light
    /// points; y and z count from `first_brick`, and masks[x], x < bricks().x, are those of the row's bricks.
    template <class Kernel, class Visitor>
    void for_each_row(Visitor&& visit) const {
        std::uint64_t masks[max_bricks_per_axis];
        for (int z = 0; z < bricks_.z; ++z) {
            for (int y = 0; y < bricks_.y; ++y) {
                if (least_square_[2][z] + least_square_[1][y] >= radius_squared_ ||
                    greatest_height_[2][z] + greatest_height_[1][y] + greatest_height_x_ <= lowest_height_)
                    continue;
                Kernel::row_masks(AxisEntries{square_[0], &square_[1][4 * y], &square_[2][4 * z]},
                                  AxisEntries{height_[0], &height_[1][4 * y], &height_[2][4 * z]},
                                  radius_squared_, lowest_height_, bricks_.x, masks);
                visit(y, z, masks);
            }
        }
    }

private:
    static constexpr int normal_bits = 15;
    static constexpr int max_points_per_axis = brick_side * max_bricks_per_axis;

    /// As many as keep 3 (q + 4)^2, the greatest squared distance in the box, within 31 bits.
    static int fraction_bits_of(double quality) { return quality <= 8.0 ? 11 : 10; }

    void fill_axis(std::size_t axis, std::int32_t position, std::int32_t slope, int fraction_bits) {
        const auto bricks = static_cast<std::size_t>(bricks_[static_cast<int>(axis)]);
        // Blocks of a fixed size become vector instructions; entries past the box are not used.
        constexpr std::size_t block = 8;
        for (std::size_t first = 0; first < brick_side * bricks; first += block) {
            for (std::size_t i = first; i < first + block; ++i) {
                const std::int32_t distance = (static_cast<std::int32_t>(i) << fraction_bits) - position;
                square_[axis][i] = distance * distance;
                height_[axis][i] = distance * slope;
            }
        }
        std::int32_t greatest = (std::numeric_limits<std::int32_t>::min)();
        for (std::size_t b = 0; b < bricks; ++b) {
            const std::int32_t low = (static_cast<std::int32_t>(4 * b) << fraction_bits) - position;
            const std::int32_t gap = (std::max)((std::max)(low, -low - (3 << fraction_bits)), 0);
            least_square_[axis][b] = gap * gap;
            greatest_height_[axis][b] = (std::max)(height_[axis][4 * b], height_[axis][4 * b + 3]);
            greatest = (std::max)(greatest, greatest_height_[axis][b]);
        }
        if (axis == 0)
            greatest_height_x_ = greatest;
    }

    glm::dvec3 place_;
    glm::ivec3 first_brick_{0};
    glm::ivec3 bricks_{0};
    std::int32_t radius_squared_ = 0;
    std::int32_t lowest_height_ = 0;
    std::int32_t greatest_height_x_ = 0;
    alignas(64) std::int32_t square_[3][max_points_per_axis];
    alignas(64) std::int32_t height_[3][max_points_per_axis];
    std::int32_t least_square_[3][max_bricks_per_axis];
    std::int32_t greatest_height_[3][max_bricks_per_axis];
};

}  // namespace lightmesh::detail
