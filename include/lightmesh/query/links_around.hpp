// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/unit_table.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/query/query_point.hpp>
#include <lightmesh/support/atomics.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// Within so many steps of a point are the middles of cells whose links floods of its seeds may need: these
/// are half a step from their light points along each axis, a seed within a step of P, or little more.
constexpr double reach_of_links(float quality) {
    return static_cast<double>(FloodBox::radius(quality)) + 2.0;
}
/// Bricks that so many steps to either side touch along an axis, at most.
constexpr int bricks_of_links(float quality) {
    return static_cast<int>(2.0 * reach_of_links(quality)) / brick_side + 2;
}

/// Lists the links that are missing around points, where floods of their seeds can lead, one bit a cell. Also
/// behind surfaces: round their edges floods get there. What points that lie close together ask for is
/// collected before it is looked up. Lives on the stack.
class LinksAround {
public:
    LinksAround(const MeshView& mesh, UnitTable& cells)
        : mesh_(mesh), cells_(cells), reach_(reach_of_links(mesh.grid->quality())),
          side_(bricks_of_links(mesh.grid->quality()) + spare_bricks) {}

    void add(const QueryPoint& point) {
        const glm::ivec3 low = brick_at(point.grid_pos - reach_);
        const glm::ivec3 high = brick_at(point.grid_pos + reach_);
        if (!is_placed_ || !is_inside(low) || !is_inside(high)) {
            list();
            first_ = low - spare_bricks / 2;
            is_placed_ = true;
        }
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y)
                for (int x = low.x; x <= high.x; ++x) {
                    std::uint8_t& cells = wanted_[slot({x, y, z})];
                    if (cells != every_cell)
                        cells |= cells_around({x, y, z}, point.grid_pos);
                }
    }

    /// Lists what was collected. Throws std::bad_alloc.
    void list() {
        if (!is_placed_)
            return;
        is_placed_ = false;
        for (int z = 0; z < side_; ++z)
            for (int y = 0; y < side_; ++y)
                for (int x = 0; x < side_; ++x) {
                    const glm::ivec3 coord = first_ + glm::ivec3(x, y, z);
                    std::uint8_t& wanted = wanted_[slot(coord)];
                    if (wanted == 0)
                        continue;
                    std::uint32_t missing = wanted;
                    if (const Brick* brick = mesh_.find_brick(coord))
                        missing &= ~std::uint32_t{load_acquire(brick->links_known)};
                    if (missing != 0)
                        cells_.add({coord, 0}, missing);
                    wanted = 0;
                }
    }

private:
    /// By so many the box that is collected is wider than that of one point.
    static constexpr int spare_bricks = 2;
    static constexpr std::uint8_t every_cell = 0xff;
    static constexpr std::size_t largest_side = bricks_of_links(Grid::max_quality) + spare_bricks;

    static glm::ivec3 brick_at(const glm::dvec3& grid_pos) {
        return {floor_to_int(grid_pos.x / brick_side), floor_to_int(grid_pos.y / brick_side),
                floor_to_int(grid_pos.z / brick_side)};
    }

    bool is_inside(const glm::ivec3& coord) const {
        const glm::ivec3 p = coord - first_;
        return p.x >= 0 && p.x < side_ && p.y >= 0 && p.y < side_ && p.z >= 0 && p.z < side_;
    }
    std::size_t slot(const glm::ivec3& coord) const {
        const glm::ivec3 p = coord - first_;
        return static_cast<std::size_t>(p.x + side_ * (p.y + side_ * p.z));
    }

    /// The cells of a brick whose middles are within reach of a point.
    std::uint8_t cells_around(const glm::ivec3& coord, const glm::dvec3& grid_pos) const {
        // The middles of cells are sqrt(3) steps from the middle of the brick.
        constexpr double to_cells = 1.7321;
        const glm::dvec3 middle = glm::dvec3(brick_side * coord) + 1.5 - grid_pos;
        const double square = glm::dot(middle, middle);
        if (square >= (reach_ + to_cells) * (reach_ + to_cells))
            return 0;
        if (square < (reach_ - to_cells) * (reach_ - to_cells))
            return every_cell;
        std::uint32_t cells = 0;
        for (int cell = 0; cell < cells_per_brick; ++cell) {
            const glm::dvec3 offset = glm::dvec3(grid_pos_of(coord, 8 * cell)) + 0.5 - grid_pos;
            if (glm::dot(offset, offset) < reach_ * reach_)
                cells |= 1u << cell;
        }
        return static_cast<std::uint8_t>(cells);
    }

    const MeshView& mesh_;
    UnitTable& cells_;
    double reach_;
    int side_;
    bool is_placed_ = false;
    glm::ivec3 first_{0};
    std::array<std::uint8_t, largest_side * largest_side * largest_side> wanted_{};
};

}  // namespace lightmesh::detail
