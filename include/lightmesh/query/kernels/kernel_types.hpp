// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/query/hemisphere.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// Light points of a cell, and a `CellRow` with what they see.
struct RowPoints {
    const std::uint8_t* row;
    std::uint8_t points;
};

/// Light points of a cell or of a brick, and what they see in words (see `CellIndex`).
struct WordPoints {
    std::uint64_t lit;           ///< lights that all of them see
    const std::uint64_t* mixed;  ///< lights that some see, and the bytes for `points`; null if there are none
    std::uint8_t points;         ///< of the cell
    std::uint8_t count;          ///< how many light points, up to 64
};

/// The inner loops of a query, for one kind of processor. All kinds give the same bits: whatever decides is
/// computed in integers, or in floats whose order of rounding is fixed.
struct Kernels {
    const char* name;  ///< such as "AVX2"

    /// The bricks with light points of the hemisphere, in order of z, y, x. Returns how many; `masks` has
    /// room for `Hemisphere::largest_box` of the grid's quality.
    std::size_t (*find_masks)(const Hemisphere& hemisphere, BrickMask* masks);

    /// The lights of a tile for which chi of equation (3) is 1 and whose range holds the point; all cones.
    std::uint64_t (*find_facing)(const LightColumns& lights, const glm::vec3& point, const glm::vec3& normal);

    /// Adds to counts[l] (modulo 2^16), for each light l of a tile, how many of the light points see it; or
    /// subtracts it.
    void (*add_rows)(const RowPoints* rows, std::size_t size, bool subtract, std::uint16_t* counts);
    void (*add_words)(const WordPoints* points, std::size_t size, bool subtract, std::uint16_t* counts);

    /// values[l] = counts[l] / count for the lights in `reaching`, 0 for the others. Returns whether for each
    /// light in `reaching` all light points agree.
    bool (*divide)(const std::uint16_t* counts, int count, std::uint64_t reaching, float* values);
};

}  // namespace lightmesh::detail
