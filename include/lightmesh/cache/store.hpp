// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/cache/fall.hpp>
#include <lightmesh/cache/lamp_rows.hpp>
#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/record_table.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace lightmesh {

/// Rows of a visibility cache by rays to lamps: penumbrae that harden towards the contact.
struct LampRows {};

/// Rows of a visibility cache from a light mesh: the published blur, but continuous.
template <class Mesh>
struct MeshRows {
    Mesh mesh;  ///< a `LightMesh`
};

}  // namespace lightmesh

namespace lightmesh::detail {

/// A record where it stands.
struct Column {
    const Record* record = nullptr;
    std::atomic<std::uint16_t>* links = nullptr;  ///< null: not kept
    glm::ivec3 index{0};                          ///< the record's own lattice point
    glm::vec3 place{0.0f};
    glm::vec3 normal{0.0f};  ///< zero: there is no surface
};

/// A record that is not kept, because the cache is full, and its row.
struct Spare {
    Record record;
    std::array<std::atomic<std::uint64_t>, 8> octets{};
};

/// What a visibility cache is made of: adapter, lights, settings, and all records so far. Makes what it is
/// asked for and does not know. To its users it is constant, and any number of threads may ask.
///
/// A record is made complete before it can be found, and a row's bytes before they are known: an exception of
/// the adapter or of an allocation leaves nothing half-made.
template <Intersector Tracer, class Rows>
class CacheStore {
public:
    CacheStore(Tracer tracer, Rows rows, std::span<const Light> lights, const CacheSettings& settings)
        : tracer_(std::move(tracer)), rows_(std::move(rows)), settings_(settings), lattice_(settings),
          lamps_(lights) {}

    const Tracer& tracer() const { return tracer_; }
    const Rows& rows() const { return rows_; }
    const CacheSettings& settings() const { return settings_; }
    const Lattice& lattice() const { return lattice_; }
    const LampTable& lamps() const { return lamps_; }

    /// The greatest length of a ray, as far as segments to the sky go.
    double reach() const { return 0x1p24 * static_cast<double>(settings_.spacing); }

    /// The record that falls from a lattice point.
    Column column(glm::ivec3 index, const Way& way, int level, Spare& spare) const {
        // A record far below belongs to a lattice point nearer to it: then two points of a slope, which start
        // at different heights, share it.
        for (;;) {
            const RecordKey key(index, RecordKind::fallen, way, level);
            if (const Record* known = table_.find(key))
                return stand(*known, way, true);
            spare.record.key = key;
            const int down = make(spare.record, index, way, level);
            if (down == 0)
                return keep(spare, way);
            index[way.axis] -= down * static_cast<int>(way.sign);
            if (is_full())
                continue;
            const Column below = column(index, way, level, spare);
            if (below.links != nullptr)
                table_.add_alias(key, *below.record);
            return below;
        }
    }

    /// A record in the air, at a lattice point.
    Column air(const glm::ivec3& index, const Way& way, int level, Spare& spare) const {
        const RecordKey key(index, RecordKind::air, way, level);
        if (const Record* known = table_.find(key))
            return stand(*known, way, true);
        reset(spare.record, key);
        return keep(spare, way);
    }

    /// The probe of the cell of four columns whose least indices along u and v are those of `index`, and
    /// whose highest lattice point has that of `index` along the axis.
    Column probe(const glm::ivec3& index, const Way& way, int level, Spare& spare) const {
        const RecordKey key(index, RecordKind::probe, way, level);
        if (const Record* known = table_.find(key))
            return stand(*known, way, true);
        reset(spare.record, key);
        std::uint64_t rays = 0;
        const auto step = static_cast<float>(lattice_.step(level));
        const auto landing =
            fall_onto_surface(tracer_, probe_start(index, way, level), way, 4.0f * step, step, rays);
        place_rays_.fetch_add(rays, std::memory_order_relaxed);
        if (landing) {
            spare.record.fall = landing->fall;
            spare.record.set_normal(landing->normal);
        }
        return keep(spare, way);
    }

    /// Whether the way between the lattice points of two neighbouring columns is free: `direction` 0 along u,
    /// 1 along v, from the lesser index. Not, if they differ by more than a step along the axis.
    bool is_linked(const Column& from, const Column& to, int direction, const Way& way, int level) const {
        const int rise = to.index[way.axis] - from.index[way.axis];
        if (rise < -1 || rise > 1)
            return false;
        const int bit = link_bit(direction, rise);
        if (from.links != nullptr) {
            const std::uint16_t links = from.links->load(std::memory_order_relaxed);
            if ((links >> bit & 1) != 0)
                return (links >> (bit + 6) & 1) != 0;
        }
        link_rays_.fetch_add(1, std::memory_order_relaxed);
        const bool open =
            !tracer_.occluded({lattice_.position(from.index, level), lattice_.position(to.index, level)});
        if (from.links != nullptr)
            from.links->fetch_or(static_cast<std::uint16_t>((open ? 65 : 1) << bit),
                                 std::memory_order_relaxed);
        return open;
    }

    /// The row of a column's record, after making sure that it knows the lights in `wanted`.
    TileRow row(const Column& column, std::size_t tile, std::uint64_t wanted, Spare& spare) const {
        // A record that is not kept has no links.
        const bool is_kept = column.links != nullptr;
        TileRow row;
        if (is_kept) {
            row = RowList(table_.pool(), const_cast<Record*>(column.record)->rows).gather(tile);
            if ((wanted & ~row.known) == 0)
                return row;
            wanted &= ~row.known;
        }
        TileValues values{};
        find_row(column, tile, wanted, values);
        if (is_kept && !is_full()) {
            RowList list(table_.pool(), const_cast<Record*>(column.record)->rows);
            octets_.fetch_add(list.make_room(tile, octets_of(wanted)), std::memory_order_relaxed);
            list.publish(tile, wanted, values);
            return list.gather(tile);
        }
        for (std::size_t o = 0; o < 8; ++o) {
            std::uint64_t bytes =
                row.octets[o] != nullptr ? row.octets[o]->load(std::memory_order_relaxed) : 0;
            for (std::size_t b = 0; b < 8; ++b)
                if ((wanted >> (8 * o + b) & 1u) != 0)
                    bytes |= static_cast<std::uint64_t>(values[8 * o + b]) << 8 * b;
            spare.octets[o].store(bytes, std::memory_order_relaxed);
            row.octets[o] = &spare.octets[o];
        }
        row.known |= wanted;
        row.tile = TileRow::no_tile;
        return row;
    }

    /// Shares of lamps that are open, by rays from a surface point itself.
    void exact(const glm::vec3& point, const glm::vec3& unit_normal, std::size_t tile, std::uint64_t wanted,
               TileValues& values) const {
        const double step = lattice_.step(lattice_.finest_level());
        LampRays<Tracer> rays(
            tracer_, lamps_, tile,
            {off_surface(point, unit_normal, step), unit_normal, seed_of(point), step, reach()});
        rays.find(wanted, static_cast<std::size_t>(settings_.lamp_rays), values);
        lamp_rays_.fetch_add(rays.rays(), std::memory_order_relaxed);
    }

    /// The same for a point of a smooth surface that coarse facets stand for: rays start on that surface, as
    /// far above the facet as it takes to clear it, and lamps are seen as its normal sees them.
    void exact(const glm::vec3& point, const glm::vec3& unit_normal, const glm::vec3& smooth_normal,
               std::size_t tile, std::uint64_t wanted, TileValues& values) const {
        const std::uint64_t seed = seed_of(point);
        const double step = lattice_.step(lattice_.finest_level());
        for (; wanted != 0; wanted &= wanted - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(wanted));
            const Lamp& lamp = lamps_.lamp(tile * lamps_per_tile + l);
            const glm::vec3 start = lifted(point, unit_normal, smooth_normal, lamp);
            LampRays<Tracer> rays(tracer_, lamps_, tile, {start, smooth_normal, seed, step, reach()});
            rays.find(wanted & (~wanted + 1u), static_cast<std::size_t>(settings_.lamp_rays), values);
            lamp_rays_.fetch_add(rays.rays(), std::memory_order_relaxed);
        }
    }

    /// A place moved off its surface: by some roundings of its coordinates and 2^-14 steps.
    static glm::vec3 off_surface(const glm::vec3& place, const glm::vec3& unit_normal, double step) {
        return place +
               (largest_component(place) * 0x1p-20f + static_cast<float>(step * 0x1p-14)) * unit_normal;
    }

    CacheStatistics statistics() const {
        CacheStatistics sum;
        for (std::size_t level = 0; level < sum.records_of_level.size(); ++level) {
            sum.records_of_level[level] = table_.records_of_level(level);
            sum.records += sum.records_of_level[level];
        }
        sum.rows = octets_.load(std::memory_order_relaxed);
        sum.lamp_rays = lamp_rays_.load(std::memory_order_relaxed);
        sum.place_rays = place_rays_.load(std::memory_order_relaxed);
        sum.link_rays = link_rays_.load(std::memory_order_relaxed);
        sum.bytes = table_.bytes() + lamps_.bytes() + sizeof *this;
        return sum;
    }

private:
    bool is_full() const {
        return settings_.memory_budget != (std::numeric_limits<std::size_t>::max)() &&
               table_.bytes() >= settings_.memory_budget;
    }

    static std::uint64_t seed_of(const glm::vec3& point) {
        const auto bits = [](float value) -> std::uint64_t {
            return std::bit_cast<std::uint32_t>(value);
        };
        return mix_bits(bits(point.x) ^ bits(point.y) << 17 ^ bits(point.z) << 34);
    }

    /// A point moved from its facet to the smooth surface, or beyond: where rays to a lamp below the facet's
    /// plane clear facets that bend away. How much that takes, the way through the solid to where it leaves
    /// towards the lamp tells: the solid does not rise above the planes at both of its ends. (Hanika,
    /// "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021, has the vertices to do it with.) Behind a
    /// wall that does not bend away, or is not closed, such a ray stays blocked.
    glm::vec3 lifted(const glm::vec3& point, const glm::vec3& unit_normal, const glm::vec3& smooth_normal,
                     const Lamp& lamp) const {
        const double step = lattice_.step(lattice_.finest_level());
        const glm::vec3 start = off_surface(point, unit_normal, step);
        const Lamp::LowWay way = lamp.low_way(point, unit_normal, reach());
        const double sine = -glm::dot(glm::dvec3(unit_normal), way.direction);
        if (sine <= 0.0)
            return start;
        std::uint64_t rays = 0;
        const auto out =
            find_way_out(tracer_, off_surface(point, -unit_normal, step), way.direction, way.length, rays);
        place_rays_.fetch_add(rays, std::memory_order_relaxed);
        if (!out)
            return start;
        // A ray is before the facet's plane at first, and from some place on before the plane where the way
        // leaves. The lift is one at which the second begins before the first ends.
        const glm::dvec3 lift(smooth_normal);
        const double rise = glm::dot(glm::dvec3(unit_normal), lift) / sine;
        const double sine_out = glm::dot(out->normal, way.direction);
        const double rise_out = glm::dot(out->normal, lift);
        const double both = rise + (rise_out > 0.0 ? rise_out / (std::max)(sine_out, 1e-3) : 0.0);
        // Seen from higher up, a lamp nearby lies lower.
        const double nearness = (std::max)(1.0 - out->distance / way.length, 0.1);
        const glm::vec3 end = start +
                              static_cast<float>(1.02 * out->distance / (both * nearness)) * smooth_normal +
                              (start - point);
        place_rays_.fetch_add(1, std::memory_order_relaxed);
        return tracer_.occluded({start, end}) ? start : end;
    }

    static void reset(Record& record, const RecordKey& key) {
        record.key = key;
        record.fall = -1.0f;
        record.set_normal(glm::vec3(0.0f));
    }

    /// Lets a record fall. Returns how many steps farther down its lattice point should be; then it is not
    /// made.
    int make(Record& record, const glm::ivec3& index, const Way& way, int level) const {
        const auto step = static_cast<float>(lattice_.step(level));
        std::uint64_t rays = 0;
        const auto landing =
            fall_onto_surface(tracer_, lattice_.position(index, level), way, 2.5f * step, step, rays);
        place_rays_.fetch_add(rays, std::memory_order_relaxed);
        reset(record, record.key);
        if (!landing)
            return 0;
        const int down = static_cast<int>(std::floor(landing->fall / step - 0.25f));
        if (down >= 1)
            return down;
        record.fall = landing->fall;
        record.set_normal(landing->normal);
        return 0;
    }

    Column keep(const Spare& made, const Way& way) const {
        return is_full() ? stand(made.record, way, false) : stand(*table_.add(made.record), way, true);
    }

    glm::vec3 probe_start(const glm::ivec3& index, const Way& way, int level) const {
        glm::vec3 start = lattice_.position(index, level);
        const auto half = static_cast<float>(0.5 * lattice_.step(level));
        start[way.u()] += half;
        start[way.v()] += half;
        return start;
    }

    static int sign_extended(std::uint32_t word) { return static_cast<std::int32_t>(word << 5) >> 5; }

    Column stand(const Record& record, const Way& way, bool is_kept) const {
        const int level = record.key.level();
        Column column;
        column.record = &record;
        if (is_kept)
            column.links = &const_cast<Record&>(record).links;
        column.index = {sign_extended(record.key.words[0]), sign_extended(record.key.words[1]),
                        sign_extended(record.key.words[2])};
        const std::uint32_t kind = record.key.words[0] >> 27;
        const bool is_probe = kind >= static_cast<std::uint32_t>(RecordKind::probe);
        column.place =
            is_probe ? probe_start(column.index, way, level) : lattice_.position(column.index, level);
        if (record.is_on_surface()) {
            column.place -= record.fall * way.up();
            column.normal = record.unit_normal();
        }
        return column;
    }

    void find_row(const Column& column, std::size_t tile, std::uint64_t wanted, TileValues& values) const {
        const RecordKey& key = column.record->key;
        const int level = key.level();
        const double step = lattice_.step(level);
        const std::uint32_t kind = key.words[0] >> 27;
        // The same for all heights of a column: those on one surface give the same values.
        RecordKey seed = key;
        seed.words[kind % 6 / 2] &= ~((1u << 27) - 1u);
        const bool is_probe = kind >= static_cast<std::uint32_t>(RecordKind::probe);
        if constexpr (!std::is_same_v<Rows, LampRows>) {
            // The air above a surface looks to the side that the surface is seen from.
            const Way way{static_cast<int>(kind % 6 / 2), kind % 2 == 0 ? 1.0f : -1.0f};
            const glm::vec3 normal = column.record->is_on_surface() ? column.normal : way.up();
            std::vector<float> all(lamps_.size());
            rows_.mesh.visibility(column.place, normal, std::span<float>(all));
            for (std::size_t l = 0; l < lamps_.tile_size(tile); ++l)
                values[l] = static_cast<std::uint8_t>(
                    floor_to_int(static_cast<double>(255.0f * all[tile * lamps_per_tile + l]) + 0.5));
            return;
        }
        LampRays<Tracer> rays(
            tracer_, lamps_, tile,
            {off_surface(column.place, column.normal, step), column.normal, hash_of(seed), step, reach()});
        if (is_probe) {
            rays.probe(wanted, values);
        } else {
            const int most = settings_.lamp_rays >> std::clamp(level - Lattice::base_level - 1, 0, 2);
            rays.find(wanted, static_cast<std::size_t>((std::max)(most, (std::min)(settings_.lamp_rays, 16))),
                      values);
        }
        lamp_rays_.fetch_add(rays.rays(), std::memory_order_relaxed);
    }

    Tracer tracer_;
    Rows rows_;
    CacheSettings settings_;
    Lattice lattice_;
    LampTable lamps_;
    mutable RecordTable table_;
    mutable std::atomic<std::uint64_t> lamp_rays_{0};
    mutable std::atomic<std::uint64_t> place_rays_{0};
    mutable std::atomic<std::uint64_t> link_rays_{0};
    mutable std::atomic<std::size_t> octets_{0};
};

}  // namespace lightmesh::detail
