// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace lightmesh::detail {

/// The light points that a surface point may take as seeds of the linked short test, around a pos just in
/// front of it. In front by more than the tie rule of `Hemisphere` asks for, so that a wall on a grid plane
/// takes those before it, not those behind.
///
/// First those of the grid cube that holds the pos whose positions in the grid have an even sum, the nearer
/// ones before the others; then the other corners of the cube. So there are half as many light points to keep
/// floods for.
class SeedCandidates {
public:
    static constexpr int count = 8;

    SeedCandidates() = default;

    /// The exponent of two of how far in front of a point the pos lies, in steps; from the greatest of the
    /// magnitudes of the point's components.
    static int exponent_in_front(float largest_component_of_point, double step) {
        const double rounding = static_cast<double>(largest_component_of_point) * 0x1p-20 / step;
        // As std::frexp, which is a call.
        return static_cast<int>(std::bit_cast<std::uint64_t>(0x1p-8 + rounding) >> 52) - 1022;
    }

    SeedCandidates(const Grid& grid, const glm::dvec3& grid_pos, const glm::vec3& point,
                   const glm::vec3& unit_normal) {
        // A power of two, so that its products are exact.
        const int exponent = exponent_in_front(largest_component(point), grid.step());
        const auto in_front = std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
        const glm::dvec3 pos = grid_pos + in_front * glm::dvec3(unit_normal);
        low_ = {floor_to_int(pos.x), floor_to_int(pos.y), floor_to_int(pos.z)};
        const glm::ivec3 fraction{floor_to_int((pos.x - low_.x) * 1024.0),
                                  floor_to_int((pos.y - low_.y) * 1024.0),
                                  floor_to_int((pos.z - low_.z) * 1024.0)};
        for (int corner = 0; corner < count; ++corner) {
            const glm::ivec3 offset = 1024 * step_to(corner) - fraction;
            constexpr std::int32_t beyond_all_even = 1 << 24;
            // In the low bits the corner itself: ties are broken in a fixed order.
            ranks_[static_cast<std::size_t>(corner)] =
                8 * (offset.x * offset.x + offset.y * offset.y + offset.z * offset.z +
                     (is_even(corner) ? 0 : beyond_all_even)) +
                corner;
        }
        left_ = count;
    }

    bool empty() const { return left_ == 0; }

    /// Position in the grid; only if not `empty`.
    glm::ivec3 next() {
        const auto first = std::min_element(ranks_.begin(), ranks_.end());
        const int corner = *first & 7;
        *first = (std::numeric_limits<std::int32_t>::max)();
        --left_;
        return low_ + step_to(corner);
    }

private:
    static glm::ivec3 step_to(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2}; }

    bool is_even(int corner) const {
        const glm::ivec3 pos = low_ + step_to(corner);
        return ((pos.x ^ pos.y ^ pos.z) & 1) == 0;
    }

    glm::ivec3 low_{0};
    std::array<std::int32_t, count> ranks_{};
    int left_ = 0;
};

}  // namespace lightmesh::detail
