// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/bounds.hpp>
#include <lightmesh/cache/column.hpp>
#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/mesh/scene_change.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace lightmesh::detail {

/// The parts of a cache that may have to do with boxes in which the scene has changed: where records have
/// fallen, the segments between them, and what they see. For one thread.
class CacheChange {
public:
    CacheChange(const Lattice& lattice, const LampTable& lamps, const RowSource& rows,
                std::span<const Bounds> boxes)
        : lattice_(lattice), lamps_(lamps), rows_(rows), boxes_(boxes),
          block_side_(static_cast<float>(8.0 * lattice.step(Lattice::base_level))) {}

    bool is_nothing() const { return boxes_.empty(); }

    /// True if a record may be somewhere else now.
    bool moves(const RecordKey& key, const Record& record) const {
        return !is_nothing() && meets_any(fall_of(key, record), boxes_);
    }
    /// True if a key may lead to another record now.
    bool moves(const RecordKey& alias, const RecordKey& key, const Record& record) const {
        if (is_nothing())
            return false;
        Bounds fall = fall_of(key, record);
        const glm::vec3 start = lattice_.position(alias.index(), alias.level());
        const float slack = slack_of(alias);
        fall.low = (glm::min)(fall.low, start - slack);
        fall.high = (glm::max)(fall.high, start + slack);
        return meets_any(fall, boxes_);
    }
    /// True if segments from a record to its neighbours may be open or closed now.
    bool relinks(const RecordKey& key) const {
        if (is_nothing())
            return false;
        const glm::vec3 start = lattice_.position(key.index(), key.level());
        return meets_any(widened({start, start}, 1.1f * static_cast<float>(lattice_.step(key.level()))),
                         boxes_);
    }

    /// Those of some lights of a tile of which a record sees the same as before.
    std::uint64_t unchanged(const RecordKey& key, const Record& record, std::size_t tile,
                            std::uint64_t lights) const {
        if (is_nothing())
            return lights;
        const Bounds from = eye_of(key, record);
        if (rows_.is_mesh != 0 && (!sees_by_rays() || meets_any(from, boxes_)))
            return 0;
        return lights & ~changed_from(from, tile, lights & changed_in_block(from, tile));
    }

private:
    /// Those of some lights of a tile of which a box may hide, or have hidden, something.
    std::uint64_t changed_from(const Bounds& from, std::size_t tile, std::uint64_t lights) const {
        std::uint64_t changed = 0;
        for (std::uint64_t rest = lights; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const Lamp& lamp = lamps_.lamp(tile * lamps_per_tile + l);
            if (std::ranges::any_of(boxes_, [&](const Bounds& box) { return is_between(from, lamp, box); }))
                changed |= rest & (~rest + 1u);
        }
        return changed;
    }

    /// The same of all lights, from anywhere near: found once for all that look from there.
    std::uint64_t changed_in_block(const Bounds& from, std::size_t tile) const {
        const glm::dvec3 block = glm::floor(glm::dvec3(from.low) / static_cast<double>(block_side_));
        constexpr double farthest = 1 << 20;
        if (largest_component(from.high - from.low) > block_side_ ||
            !(std::abs(block.x) < farthest && std::abs(block.y) < farthest && std::abs(block.z) < farthest))
            return ~std::uint64_t{0};
        const auto bits = [](double coordinate) {
            return static_cast<std::uint64_t>(coordinate + farthest);
        };
        const std::uint64_t key = bits(block.x) | bits(block.y) << 21 | bits(block.z) << 42;
        std::vector<std::uint64_t>& tiles = blocks_[key];
        if (tiles.empty()) {
            const glm::vec3 low(block * static_cast<double>(block_side_));
            // With a little more to all sides, for the rounding of the corner.
            const Bounds widest = widened({low, low + 2.0f * block_side_}, 0.01f * block_side_);
            tiles.resize(lamps_.tile_count());
            for (std::size_t t = 0; t < tiles.size(); ++t) {
                const std::size_t size = lamps_.tile_size(t);
                tiles[t] = changed_from(widest, t, ~std::uint64_t{0} >> (lamps_per_tile - size));
            }
        }
        return tiles[tile];
    }

    float slack_of(const RecordKey& key) const {
        return 0.13f * static_cast<float>(lattice_.step(key.level()));
    }

    /// The space that a record's place depends on: the way that it fell, or found nothing on.
    Bounds fall_of(const RecordKey& key, const Record& record) const {
        const Facing facing = key.facing();
        const auto step = static_cast<float>(lattice_.step(key.level()));
        const bool in_air = !key.is_probe() && key.what() >= static_cast<std::uint32_t>(RecordKind::air);
        glm::vec3 start = key.is_probe() ? probe_start(lattice_, key.index(), facing, key.level())
                                         : lattice_.position(key.index(), key.level());
        // Slopes are found from places an eighth of a step beside, which may lie a quarter deeper.
        const float length = in_air                   ? 0.0f
                             : record.is_on_surface() ? record.fall + 0.13f * step
                                                      : (key.is_probe() ? 4.0f : 2.5f) * step;
        const glm::vec3 end = start - length * facing.up();
        // A probe's rays start a quarter of a step to its sides.
        const float aside = key.is_probe() ? 0.3f * step : 0.0f;
        return widened({(glm::min)(start, end), (glm::max)(start, end)},
                       aside + slack_of(key) + greatest_offset(start));
    }

    /// From where a record sees the lights.
    Bounds eye_of(const RecordKey& key, const Record& record) const {
        if (key.is_probe() && rows_.is_mesh == 0)
            return fall_of(key, record);
        if (has_shaft_row(lattice_, key, record))
            return shaft_of(key);
        const glm::vec3 position = column_of(lattice_, key, record, key.facing(), false).position;
        // A mesh's values depend on light points within its radius, on others of their bricks, and on links
        // between them.
        const float reach = rows_.is_mesh != 0 ? rows_.radius * (1.0f + 4.0f / rows_.quality) : slack_of(key);
        return widened({position, position}, reach + greatest_offset(position));
    }

    /// The box of the places around a record, and the ways that they fell: they start up to a step higher or
    /// lower, and three eighths of one to the sides.
    Bounds shaft_of(const RecordKey& key) const {
        const auto step = static_cast<float>(lattice_.step(key.level()));
        const glm::vec3 start = lattice_.position(key.index(), key.level());
        const glm::vec3 up = 1.1f * step * key.facing().up();
        const glm::vec3 end = start - 4.7f * up;
        return widened({(glm::min)(start + up, end), (glm::max)(start + up, end)},
                       0.4f * step + slack_of(key) + greatest_offset(start));
    }

    /// The distance off a surface at which rays start there, and more: see `off_surface`.
    static float greatest_offset(const glm::vec3& position) { return 0x1p-18f * largest_component(position); }

    /// Texels of a shadow map show what lies beyond a point, too, and to its sides; how a directional light
    /// looks at shadow volumes depends on where all triangles are.
    bool sees_by_rays() const { return static_cast<LongTest>(rows_.long_tests) == LongTest::rays; }

    /// Rays to all of a lamp pass within its size of those to its centre.
    static bool is_between(const Bounds& from, const Lamp& lamp, const Bounds& box) {
        double size = lamp.extent();
        if (lamp.shape().is_directional)
            size *= farthest_between(from, box);
        return crosses(from, lamp.shape(), widened(box, static_cast<float>(1.001 * size)));
    }

    const Lattice& lattice_;
    const LampTable& lamps_;
    RowSource rows_;
    std::span<const Bounds> boxes_;
    float block_side_;  ///< world units
    /// For each block that was looked at, and each tile, the lights that may have changed somewhere in it.
    mutable std::unordered_map<std::uint64_t, std::vector<std::uint64_t>> blocks_;
};

}  // namespace lightmesh::detail
