// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/blend.hpp>
#include <lightmesh/cache/cell_values.hpp>
#include <lightmesh/cache/column.hpp>
#include <lightmesh/cache/lanes.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/taps.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// Four columns and the links between them, and records in the air at their lattice points, with what a query
/// may take for granted there.
struct CacheCell {
    CellCorners corners;
    Facing facing;
    int level = -1;
    bool is_made = false;  ///< whether it may be used again
    bool is_flat;
    bool is_shared;  ///< whether more than one point has asked for it
    CellLinks links;
    std::array<bool, CellValues::record_count> has_column;
    glm::vec3 normal;        ///< of a flat cell
    glm::vec3 position;      ///< a record of a flat cell
    float slack;             ///< how far from its plane points may lie, world units
    std::uint64_t compared;  ///< the lights of the values' tile that are known in all rows, and compared
    std::uint64_t uniform;   ///< those of them that are the same in all rows
    CellSurface surface;
    CellValues values;
    std::array<Column, CellValues::record_count> columns;

    /// Puts another cell in the place of this one, of which nothing more is known yet.
    void put(const CellCorners& of_corners, const Facing& of_facing, int of_level) {
        is_made = false;
        is_shared = false;
        corners = of_corners;
        facing = of_facing;
        level = of_level;
    }
    bool is_at(const CellCorners& of_corners, const Facing& of_facing, int of_level) const {
        return level == of_level && corners == of_corners && facing == of_facing;
    }

    /// After the four columns and the links are there.
    void finish(double step) {
        std::fill(has_column.begin() + CellValues::first_in_air, has_column.end(), false);
        begin(CellValues::no_tile);
        normal = columns[0].normal;
        position = columns[0].position;
        float farthest = 0.0f;
        is_flat = links.are_all_open();
        for (std::size_t k = 0; k < 4; ++k) {
            const Column& column = columns[k];
            surface.set(k, column.position, column.normal);
            is_flat &= column.record->is_on_surface() && is_same(column.normal, normal);
            farthest = (std::max)(farthest, std::abs(glm::dot(normal, column.position - position)));
        }
        slack = 0.002f * static_cast<float>(step) - farthest;
    }

    /// Begins with another tile.
    void begin(std::size_t tile) {
        values.begin(tile);
        compared = 0;
        uniform = 0;
    }

    /// True if all four records fit a point wholly, and nothing lies between: then `fit_of` need not be
    /// asked, which would say so.
    bool fits(const glm::vec3& point, const glm::vec3& unit_normal) const {
        return is_flat && is_same(unit_normal, normal) &&
               std::abs(glm::dot(normal, point - position)) < slack;
    }

    /// The lights that have the same value in all four rows, and nothing that says that there may be others
    /// between them, as far as they have been compared.
    std::uint64_t uniform_of(std::size_t tile) const { return values.tile == tile ? uniform : 0; }

    /// Compares some lights, which all rows know; also with what the probe says, if there is one.
    void compare(std::uint64_t lights, bool has_probe) {
        lights &= ~compared;
        if (has_probe)
            lights &= values.known(CellValues::centre);
        for (std::uint32_t octets = octets_of(lights); octets != 0; octets &= octets - 1) {
            const int o = std::countr_zero(octets);
            const auto word = [&](std::size_t record) {
                return values.octet(record, static_cast<std::size_t>(o));
            };
            const std::uint64_t first = word(0);
            Lanes lanes;
            spread_bytes((first ^ word(1)) | (first ^ word(2)) | (first ^ word(3)), lanes);
            if (has_probe) {
                Lanes value;
                Lanes probe;
                spread_bytes(first, value);
                spread_bytes(word(CellValues::centre), probe);
                mark_missed(lanes, probe, value, value);
            }
            uniform |= (mask_of(lanes) ^ 255u) << 8 * o & lights;
        }
        for (const std::uint64_t misses : values.misses)
            uniform &= ~misses;
        compared |= lights;
    }

    /// The lights of which a record that serves a point does not tell what lies around it.
    std::uint64_t misses_of(const BlendLevel& serving) const {
        std::uint64_t misses = 0;
        for (std::size_t k = 0; k < serving.taps; ++k)
            if (serving.records[k] < CellValues::first_in_air)
                misses |= values.misses[serving.records[k]];
        return misses;
    }

private:
    static bool is_same(const glm::vec3& a, const glm::vec3& b) { return largest_component(a - b) < 1e-4f; }
};

}  // namespace lightmesh::detail
