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
#include <array>
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
        : lattice_(lattice), lamps_(lamps), rows_(rows),
          boxes_(boxes), blocks_{{{.side = 8.0 * lattice.step(Lattice::base_level), .tiles = {}},
                                  {.side = 2.0 * lattice.step(Lattice::base_level), .tiles = {}}}} {}

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

    /// From where a record sees the lights, and which of these a box may hide, or have hidden, from there.
    struct Sight {
        Bounds from;
        bool is_lost = false;                                 ///< nothing holds any more
        const std::vector<std::uint64_t>* changed = nullptr;  ///< for each tile no others; null: any
    };
    Sight sight_of(const RecordKey& key, const Record& record) const {
        Sight sight;
        if (is_nothing())
            return sight;
        const bool is_shaft = has_shaft_row(lattice_, key, record);
        sight.from = eye_of(key, record, is_shaft);
        sight.is_lost = (is_shaft && meets_any(shaft_of(key), boxes_)) ||
                        (rows_.is_mesh != 0 && (!sees_by_rays() || meets_any(sight.from, boxes_)));
        if (sight.is_lost)
            return sight;
        // Smaller blocks say more.
        for (Blocks& blocks : blocks_)
            sight.changed = changed_near(blocks, sight);
        return sight;
    }
    /// Whether all that a record sees is as before.
    bool is_unchanged(const Sight& sight) const {
        return is_nothing() ||
               (!sight.is_lost && sight.changed != nullptr &&
                std::ranges::all_of(*sight.changed, [](std::uint64_t lights) { return lights == 0; }));
    }
    /// Those of some lights of a tile of which a record sees the same as before.
    std::uint64_t unchanged(const Sight& sight, std::size_t tile, std::uint64_t lights) const {
        if (is_nothing())
            return lights;
        if (sight.is_lost)
            return 0;
        return lights & ~changed_from(sight.from, tile, lights & changed_at_most(sight, tile));
    }

private:
    /// For each block of a size that was looked at, and each tile, the lights that may have changed somewhere
    /// in it.
    struct Blocks {
        double side;  ///< world units
        std::unordered_map<std::uint64_t, std::vector<std::uint64_t>> tiles;
    };

    /// The lights of a tile that may have changed.
    std::uint64_t changed_at_most(const Sight& sight, std::size_t tile) const {
        return sight.changed != nullptr ? (*sight.changed)[tile]
                                        : ~std::uint64_t{0} >> (lamps_per_tile - lamps_.tile_size(tile));
    }

    /// Those of some lights of a tile of which a box may hide, or have hidden, something.
    std::uint64_t changed_from(const Bounds& from, std::size_t tile, std::uint64_t lights) const {
        std::uint64_t changed = 0;
        for (std::uint64_t rest = lights; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const Lamp& lamp = lamps_.lamp(tile * lamps_per_tile + l);
            const glm::dvec3 extent = 1.001 * lamp.extent_from(from);
            if (std::ranges::any_of(boxes_, [&](const Bounds& box) {
                    return crosses(from, lamp.shape(), box, SegmentEnd::at_point, extent);
                }))
                changed |= rest & (~rest + 1u);
        }
        return changed;
    }

    /// The lights that may have changed from anywhere near, of those that the sight has by now: found once
    /// for all that look from there. Where a block says nothing, these.
    const std::vector<std::uint64_t>* changed_near(Blocks& blocks, const Sight& sight) const {
        const Bounds& from = sight.from;
        const glm::dvec3 block = glm::floor(glm::dvec3(from.low) / blocks.side);
        constexpr double farthest = 1 << 20;
        if (static_cast<double>(largest_component(from.high - from.low)) > 0.5 * blocks.side ||
            !(std::abs(block.x) < farthest && std::abs(block.y) < farthest && std::abs(block.z) < farthest))
            return sight.changed;
        const auto bits = [](double coordinate) {
            return static_cast<std::uint64_t>(coordinate + farthest);
        };
        std::vector<std::uint64_t>& tiles =
            blocks.tiles[bits(block.x) | bits(block.y) << 21 | bits(block.z) << 42];
        if (tiles.empty()) {
            const glm::vec3 low(block * blocks.side);
            const auto side = static_cast<float>(blocks.side);
            // With a little more to all sides, for the rounding of the corner.
            const Bounds widest = widened({low, low + 1.5f * side}, 0.01f * side);
            tiles.resize(lamps_.tile_count());
            for (std::size_t t = 0; t < tiles.size(); ++t)
                tiles[t] = changed_from(widest, t, changed_at_most(sight, t));
        }
        return &tiles;
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
    Bounds eye_of(const RecordKey& key, const Record& record, bool is_shaft) const {
        if (key.is_probe() && rows_.is_mesh == 0)
            return fall_of(key, record);
        const Column column = column_of(lattice_, key, record, key.facing(), false);
        const glm::vec3& position = column.position;
        if (is_shaft)
            return around(column);
        // A mesh's values depend on light points within its radius, on others of their bricks, and on links
        // between them.
        const float reach = rows_.is_mesh != 0 ? rows_.radius * (1.0f + 4.0f / rows_.quality) : 0.0f;
        return widened({position, position}, reach + offset_of(key, position));
    }

    /// Where the places around a record lie that look for it: three eighths of a step to the sides, and on
    /// surfaces that it fits, which lie within .45 steps of its tangent plane.
    Bounds around(const Column& column) const {
        const Facing facing = column.key.facing();
        const auto step = static_cast<float>(lattice_.step(column.key.level()));
        const glm::vec3 slope = glm::abs(column.normal);
        const float aside = 0.38f * step;
        glm::vec3 half(aside);
        // Or where they start, and as far down as they fall.
        half[facing.axis] = (std::min)((0.46f * step + aside * (slope[facing.u()] + slope[facing.v()])) /
                                           (std::max)(slope[facing.axis], 1e-6f),
                                       7.0f * step);
        return widened({column.position - half, column.position + half},
                       offset_of(column.key, column.position));
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

    /// The distance off a surface at which rays of a record start, and more: see `off_surface`.
    float offset_of(const RecordKey& key, const glm::vec3& position) const {
        return 0.001f * static_cast<float>(lattice_.step(key.level())) + greatest_offset(position);
    }
    static float greatest_offset(const glm::vec3& position) { return 0x1p-18f * largest_component(position); }

    /// Texels of a shadow map show what lies beyond a point, too, and to its sides; how a directional light
    /// looks at shadow volumes depends on where all triangles are.
    bool sees_by_rays() const { return static_cast<LongTest>(rows_.long_tests) == LongTest::rays; }

    const Lattice& lattice_;
    const LampTable& lamps_;
    RowSource rows_;
    std::span<const Bounds> boxes_;
    mutable std::array<Blocks, 2> blocks_;
};

}  // namespace lightmesh::detail
