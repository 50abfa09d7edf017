// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

/// The hemisphere of equation (2) without its short test: { x in LM : |P - x| < r, (n, x - P) > 0 }, as one
/// 64-bit mask for each brick of 4x4x4 light points.

namespace lightmesh::detail {

/// Light points of one brick, the brick counted from the first of a box.
struct BrickMask {
    std::uint8_t x, y, z;
    std::uint64_t points;  ///< bits as in `bit_of`
};

/// A hemisphere around a surface point, in fixed-point numbers, over a box of bricks: what the kernels need
/// to find its masks.
///
/// Positions are rounded to 2^-f steps, f = 11 up to q = 8 and 10 above, and normals to 2^-15 of their
/// length: the masks are exact in these integers, so every compiler and instruction set yields the same bits.
/// The one rule for ties: a light point belongs to the hemisphere only if it lies more than 2^(1-f) steps,
/// plus what the point's own float coordinates may be off (|P|_inf * 2^-22), above the tangent plane. Thus
/// the light points of a grid plane are out for all points of a wall that lies on it. The distance has no
/// such band: |x - P| < r.
///
/// Both conditions are sums over the axes: the squared distance and the height over the tangent plane of
/// light point (x, y, z) are sums of a number for x, one for y and one for z.
struct Hemisphere {
    static constexpr int max_bricks_per_axis = 10;  // 2q + 1 <= 33 light points
    static constexpr std::size_t most_bricks =
        max_bricks_per_axis * max_bricks_per_axis * max_bricks_per_axis;
    static constexpr int normal_bits = 15;

    glm::ivec3 first_brick;  ///< coordinates of the first brick of the box that the ball touches
    glm::ivec3 bricks;       ///< number of bricks of the box in each axis
    glm::ivec3 position;     ///< of the surface point, from the first brick's first light point; fixed-point
    glm::ivec3 slope;        ///< the unit normal, fixed-point
    int fraction_bits;       ///< f
    std::int32_t radius_squared;
    std::int32_t lowest_height;

    /// `grid_pos` is what `Grid::locate` says of the point. A zero normal gives an empty hemisphere.
    Hemisphere(const Grid& grid, const glm::dvec3& grid_pos, const glm::vec3& point,
               const glm::vec3& unit_normal) {
        const double quality = static_cast<double>(grid.quality());
        fraction_bits = fraction_bits_of(quality);
        const double one = static_cast<double>(1 << fraction_bits);
        radius_squared = -floor_to_int(-quality * quality * one * one);
        constexpr double normal_one = 1 << normal_bits;
        const double rounding = static_cast<double>(largest_component(point)) * 0x1p-22 / grid.step();
        lowest_height =
            static_cast<std::int32_t>((std::min)(normal_one * (2.0 + one * rounding), 2147483647.0));
        for (int axis = 0; axis < 3; ++axis) {
            const double at = grid_pos[axis];
            first_brick[axis] = brick_of(floor_to_int(at - quality));
            bricks[axis] = brick_of(floor_to_int(at + quality)) - first_brick[axis] + 1;
            const double from_first = at - static_cast<double>(first_brick[axis] * brick_side);
            position[axis] = floor_to_int(from_first * one + 0.5);
            slope[axis] = floor_to_int(static_cast<double>(unit_normal[axis]) * normal_one + 0.5);
        }
    }

    /// The most bricks that a box has in each axis.
    static int largest_side(float quality) { return static_cast<int>(2.0f * quality + 3.0f) / 4 + 1; }
    static std::size_t largest_box(float quality) {
        const auto side = static_cast<std::size_t>(largest_side(quality));
        return side * side * side;
    }

private:
    /// As many as keep 3 (q + 4)^2, the greatest squared distance in the box, within 31 bits.
    static int fraction_bits_of(double quality) { return quality <= 8.0 ? 11 : 10; }
};

}  // namespace lightmesh::detail
