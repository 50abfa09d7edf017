// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace lightmesh::detail {

/// The light points that a surface point may take as its seed: the corners of the grid cube that holds a
/// place just in front of it. In front by more than the tie rule of `Hemisphere` asks for, so that the cube
/// of a wall on a grid plane is the one before it, not the one behind.
///
/// One after the other, those with an even sum of indices first, the nearer ones before the others. Half of
/// all light points are even, none farther than a step from any place: so there are half as many seeds to
/// keep something for.
class SeedCandidates {
public:
    SeedCandidates() = default;

    SeedCandidates(const Grid& grid, const glm::vec3& point, const glm::vec3& unit_normal) {
        const double rounding = static_cast<double>(largest_component(point)) * 0x1p-20 / grid.step();
        const glm::dvec3 place = grid.locate(point) + (0x1p-8 + rounding) * glm::dvec3(unit_normal);
        low_ = {floor_to_int(place.x), floor_to_int(place.y), floor_to_int(place.z)};
        const glm::vec3 fraction(place - glm::dvec3(low_));
        for (int corner = 0; corner < 8; ++corner) {
            const glm::vec3 way = glm::vec3(step_to(corner)) - fraction;
            constexpr float beyond_all_even = 16.0f;
            ranks_[static_cast<std::size_t>(corner)] =
                way.x * way.x + way.y * way.y + way.z * way.z + (is_even(corner) ? 0.0f : beyond_all_even);
        }
        left_ = 8;
    }

    bool empty() const { return left_ == 0; }

    /// Only if not `empty`.
    glm::ivec3 next() {
        const auto first = std::min_element(ranks_.begin(), ranks_.end());
        *first = std::numeric_limits<float>::infinity();
        --left_;
        return low_ + step_to(static_cast<int>(first - ranks_.begin()));
    }

private:
    static glm::ivec3 step_to(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2}; }

    bool is_even(int corner) const {
        const glm::ivec3 index = low_ + step_to(corner);
        return ((index.x ^ index.y ^ index.z) & 1) == 0;
    }

    glm::ivec3 low_{0};
    std::array<float, 8> ranks_{};
    int left_ = 0;
};

}  // namespace lightmesh::detail
