// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/ray_ends.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/query/neighbours.hpp>
#include <lightmesh/query/seeds.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace lightmesh::detail {

/// Surface points that are asked together. What has one place for each point may be left empty.
struct PointBatch {
    std::span<const glm::vec3> positions;
    std::span<const glm::vec3> normals;
    std::span<const std::uint32_t> rows{};  ///< of the result; empty: in their order
    /// The share of what is in a row that the point's values replace; empty: 1 for each.
    std::span<const float> shares{};

    std::size_t size() const { return positions.size(); }
};

/// A surface point on its way through a query.
struct QueryPoint {
    static constexpr int most_far_seeds = 12;

    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f};  ///< of length 1 or 0
    glm::dvec3 grid_pos{0.0};
    Neighbours neighbours;
    SeedCandidates seeds;
    glm::ivec3 seed{0};
    const BrickPoints* seed_entry = nullptr;
    int linked_count = 0;      ///< neighbours that are linked by now
    int far_seeds = 0;         ///< those of all neighbours that were tried, not only those around the point
    std::size_t row = 0;       ///< the row of the result
    float share = 1.0f;        ///< see `PointBatch::shares`
    std::uint32_t window = 0;  ///< sets of one window can be compared
    std::uint32_t first_change = 0;
    std::uint32_t change_count = 0;
    bool differs_little = false;  ///< from the point before
    bool is_uniform = false;      ///< for each light that reaches the point all neighbours agree
    bool is_tested = false;       ///< by exact short tests
    bool lights_agree = true;     ///< for each light that reaches the point all neighbours agree

    QueryPoint() = default;
    QueryPoint(const glm::vec3& position_, const glm::vec3& normal_)
        : position(position_), normal(unit_or_zero(normal_)) {}

    /// Goes on to the next light point that may be a seed of the linked short test: those around the point,
    /// and where these together reach less than a quarter of the neighbours, it may lie in a hollow: then
    /// some of all neighbours, evenly, and where it sees none of these, all until it sees one: through a gap
    /// it may see few. False if there is none left: then the neighbours are those that are linked by now.
    bool next_seed() {
        while (!seeds.empty()) {
            seed = seeds.next();
            seed_entry = neighbours.entry_with(seed);
            if (seed_entry != nullptr && !is_linked(seed_entry, bit_in_brick(seed)))
                return true;
        }
        const int size = neighbours.point_count();
        while (4 * linked_count < size && far_seeds < most_far_seeds + (linked_count == 0 ? size : 0)) {
            const auto [entry, bit] = neighbours.point_at(
                far_seeds < most_far_seeds ? (2 * far_seeds + 1) * size / (2 * most_far_seeds)
                                           : far_seeds - most_far_seeds);
            ++far_seeds;
            seed = grid_pos_of(entry->brick->position(), bit);
            seed_entry = entry;
            if (!is_linked(entry, bit))
                return true;
        }
        neighbours.keep_linked();
        return false;
    }

private:
    /// True if a light point is linked already: it has hardly more to add.
    static bool is_linked(const BrickPoints* entry, int bit) { return (entry->linked >> bit & 1) != 0; }
};

/// The surface end of segments from a point.
inline glm::vec3 surface_end_of(const QueryPoint& point, const Grid& grid) {
    return surface_end(point.position, point.normal, static_cast<float>(grid.step()));
}

}  // namespace lightmesh::detail
