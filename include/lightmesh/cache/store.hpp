// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/cache/blend.hpp>
#include <lightmesh/cache/cache_change.hpp>
#include <lightmesh/cache/column.hpp>
#include <lightmesh/cache/fall.hpp>
#include <lightmesh/cache/lamp_rows.hpp>
#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/point_rays.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/record_brick.hpp>
#include <lightmesh/cache/record_table.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/taps.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/free_slots.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/frame_ages.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
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

/// The parts that a visibility cache is made of: adapter, lights, settings, and all records so far. Makes
/// what it is asked for and does not know. To its users it is constant, and any number of threads may ask.
///
/// A record is made complete before it can be found, and a row's bytes before they are known: an exception of
/// the adapter or of an allocation leaves nothing half-made.
///
/// What changes lights or forgets records is for one thread, while nobody else uses the store.
template <Intersector Tracer, class Rows>
class CacheStore {
public:
    CacheStore(Tracer tracer, Rows rows, std::span<const Light> lights, const CacheSettings& settings)
        : tracer_(std::move(tracer)), rows_(std::move(rows)), settings_(usable(settings)),
          lattice_(settings_), user_lights_(lights.begin(), lights.end()), lamps_(lights) {}

    std::span<const Light> user_lights() const { return user_lights_; }
    const Tracer& tracer() const { return tracer_; }
    const Rows& rows() const { return rows_; }
    const CacheSettings& settings() const { return settings_; }
    const Lattice& lattice() const { return lattice_; }
    const LampTable& lamps() const { return lamps_; }

    /// All records so far.
    RecordTable& table() const { return *table_; }
    /// Notes that somebody asks for a record of a brick in this frame.
    void mark_used(RecordBrick& brick) const {
        if (brick.used.load(std::memory_order_relaxed) != frame_)
            brick.used.store(frame_, std::memory_order_relaxed);
    }
    /// True if nothing more is to be kept.
    bool is_full() const {
        return settings_.memory_budget != (std::numeric_limits<std::size_t>::max)() &&
               table_->bytes() - table_->free_bytes() >= settings_.memory_budget;
    }
    /// Keeps the values of some lights of a tile for a record of this cache.
    void keep_row(Record& record, std::size_t tile, std::uint64_t lights, const TileValues& values) const {
        octets_.fetch_add(RowList(table_->pool(), record.rows).add(tile, lights, values),
                          std::memory_order_relaxed);
    }

    /// The record that falls from a lattice point. `nearby`, here and below: see `RecordTable::find`.
    Column column(glm::ivec3 index, const Facing& facing, int level, Record& spare,
                  RecordBrick*& nearby) const {
        // A record far below belongs to a lattice point nearer to it: then two points of a slope, which start
        // at different heights, share it.
        for (;;) {
            const RecordKey key(index, RecordKind::fallen, facing, level);
            if (const RecordEntry known = table_->find(key, nearby))
                return stand(known, facing);
            const int down = make(spare, index, facing, level);
            if (down == 0)
                return keep(key, spare, facing);
            index[facing.axis] -= down * static_cast<int>(facing.sign);
            if (is_full())
                continue;
            const Column below = column(index, facing, level, spare, nearby);
            if (below.links != nullptr)
                table_->add_alias(key, below.key);
            return below;
        }
    }

    /// A record in the air, at a lattice point.
    Column air(const glm::ivec3& index, const Facing& facing, int level, Record& spare,
               RecordBrick*& nearby) const {
        const RecordKey key(index, RecordKind::air, facing, level);
        if (const RecordEntry known = table_->find(key, nearby))
            return stand(known, facing);
        spare = Record();
        return keep(key, spare, facing);
    }

    /// The probe of the cell of four columns whose least indices along u and v are those of `index`, and
    /// whose highest lattice point has that of `index` along the axis. Of blur rows it lies on the surface
    /// below the cell's centre; of lamp rows it stands for places all over the cell.
    Column probe(const glm::ivec3& index, const Facing& facing, int level, Record& spare,
                 RecordBrick*& nearby) const {
        const RecordKey key(index, RecordKind::probe, facing, level);
        if (const RecordEntry known = table_->find(key, nearby))
            return stand(known, facing);
        spare = Record();
        if constexpr (has_mesh) {
            if (const auto landing = land(probe_start(lattice_, index, facing, level), facing, level, 4.0f)) {
                spare.fall = landing->fall;
                spare.set_normal(landing->normal);
            }
        }
        return keep(key, spare, facing);
    }

    /// True if the segment between the lattice points of two neighbouring columns is free: `direction` 0
    /// along u, 1 along v, from the lesser index. Not, if they differ by more than a step along the axis.
    bool is_linked(const Column& from, const Column& to, int direction, const Facing& facing,
                   int level) const {
        const glm::ivec3 start = from.key.index();
        const glm::ivec3 end = to.key.index();
        const int rise = end[facing.axis] - start[facing.axis];
        if (rise < -1 || rise > 1)
            return false;
        const int bit = link_bit(direction, rise);
        if (from.links != nullptr) {
            const std::uint16_t links = from.links->load(std::memory_order_relaxed);
            if ((links >> bit & 1) != 0)
                return (links >> (bit + 6) & 1) != 0;
        }
        link_rays_.fetch_add(1, std::memory_order_relaxed);
        const bool open = !tracer_.occluded({lattice_.position(start, level), lattice_.position(end, level)});
        if (from.links != nullptr)
            from.links->fetch_or(static_cast<std::uint16_t>((open ? 65 : 1) << bit),
                                 std::memory_order_relaxed);
        return open;
    }

    /// The row of a column's record, after making sure that it knows the lights in `wanted`.
    RowBytes row(const Column& column, std::size_t tile, std::uint64_t wanted) const {
        // A record that is not kept has no links.
        const bool is_kept = column.links != nullptr;
        RowBytes row{};
        if (is_kept)
            row = known_row(*column.record, tile);
        wanted &= ~row.known;
        if (wanted == 0)
            return row;
        TileValues values{};
        find_row(column, tile, wanted, values);
        if (is_kept && !is_full()) {
            Record& record = const_cast<Record&>(*column.record);
            keep_row(record, tile, wanted, values);
            return known_row(record, tile);
        }
        for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            row.octets[l / 8] |= static_cast<std::uint64_t>(values[l]) << l % 8 * 8;
        }
        row.known |= wanted;
        return row;
    }

    /// All that is known of the row of a record.
    RowBytes known_row(const Record& record, std::size_t tile) const {
        return RowList(table_->pool(), const_cast<Record&>(record).rows).gather(tile);
    }

    /// From where rays tell the row of a column's record; places around it are found by rays.
    RowLook look_of(const Column& column) const {
        const RecordKey& key = column.key;
        // The same for all heights of a column: those on one surface give the same values.
        RecordKey seed_key = key;
        seed_key.words[key.facing().axis] &= ~RecordKey::index_mask;
        RowLook look;
        look.origin.seed = hash_of(seed_key);
        look.origin.step = lattice_.step(key.level());
        look.origin.reach = greatest_reach(lattice_);
        if (key.is_probe()) {
            look_around_cell(column, look);
            return look;
        }
        look.origin = origin_at(look, column.position, column.normal);
        const int below = key.level() - Lattice::base_level;
        const auto most = [&](int halvings) {
            return most_rays(settings_.lamp_rays, halvings);
        };
        if (has_shaft_row(lattice_, key, *column.record)) {
            look_around_record(column, look);
            // Where places around have seen both, rays to the rim need not tell whether there is a penumbra.
            look.plan = {.has_rim = false, .first = most(2), .most = most(below - 1)};
        } else if (column.record->is_on_surface()) {
            look.plan = RayPlan::full(most(below - 1));
        } else {
            look.plan = RayPlan::glance(static_cast<std::size_t>(settings_.lamp_rays), below >= 2);
        }
        return look;
    }

    /// Counts rays to lamps that a caller's own tracer was asked for.
    void count_listed_rays(std::uint64_t rays) const {
        listed_rays_.fetch_add(rays, std::memory_order_relaxed);
    }

    /// Counts rays from points.
    void count_point_rays(std::uint64_t rays) const {
        point_rays_.fetch_add(rays, std::memory_order_relaxed);
    }

    /// Shares of lamps that are open, by rays from a surface point itself.
    void exact(const glm::vec3& point, const glm::vec3& unit_normal, std::size_t tile, std::uint64_t wanted,
               TileValues& values) const {
        PointRays<Tracer> rays(tracer_, lattice_, lamps_, settings_);
        rays.find(point, unit_normal, tile, wanted, values);
        count_point_rays(rays.rays());
    }
    /// The same in place of records that do not serve the point: by fewer rays.
    void stand_in(const glm::vec3& point, const glm::vec3& unit_normal, std::size_t tile,
                  std::uint64_t wanted, TileValues& values) const {
        PointRays<Tracer> rays(tracer_, lattice_, lamps_, settings_);
        rays.stand_in(point, unit_normal, tile, wanted, values);
        count_point_rays(rays.rays());
    }
    /// The same for a point of a smooth surface.
    void exact(const glm::vec3& point, const glm::vec3& unit_normal, const glm::vec3& smooth_normal,
               std::size_t tile, std::uint64_t wanted, TileValues& values) const {
        PointRays<Tracer> rays(tracer_, lattice_, lamps_, settings_);
        rays.find(point, unit_normal, smooth_normal, tile, wanted, values);
        count_point_rays(rays.rays());
    }

    /// The mesh of blur rows.
    Rows& rows() { return rows_; }

    /// Puts a light in the place of another, whose values are forgotten. Throws what `LampTable` throws, and
    /// what the mesh of blur rows does; nothing has changed then.
    void set_light(std::size_t i, const Light& light) {
        replace(i, light, [&] {
            if constexpr (has_mesh)
                rows_.mesh.set_light(i, light);
            else
                free_.take(i);
        });
    }

    /// Adds a light, which is not one of `user_lights`, and returns its number. Throws as above.
    std::size_t add_light(const Light& light) {
        if constexpr (has_mesh) {
            LampTable more = lamps_;
            more.add(light);
            make_room_for_light();
            const std::size_t i = rows_.mesh.add_light(light);
            if (i < lamps_.size()) {
                try {
                    replace(i, light, [] {});
                } catch (...) {
                    rows_.mesh.remove_light(i);
                    throw;
                }
                return i;
            }
            lamps_ = std::move(more);
        } else {
            if (!free_.is_empty()) {
                const std::size_t i = free_.lowest();
                set_light(i, light);
                return i;
            }
            make_room_for_light();
            lamps_.add(light);
        }
        user_lights_.push_back(light);
        return user_lights_.size() - 1;
    }

    /// Takes a light out. Throws std::out_of_range for one that was taken out before.
    void remove_light(std::size_t i) {
        replace(i, no_light(), [&] {
            if constexpr (has_mesh)
                rows_.mesh.remove_light(i);
            else
                free_.add(i);
        });
    }

    /// Forgets all that may have to do with a change of the scene.
    void forget(const CacheChange& change) {
        forgotten_records_ += table_->forget(
            [&](const RecordKey& key, const RecordEntry& entry) {
                return change.moves(key, entry.key, *entry.record);
            },
            [&](const RecordEntry& entry) {
                Record& record = *entry.record;
                RowList rows(table_->pool(), record.rows);
                if (change.moves(entry.key, record)) {
                    rows.for_each([&](std::size_t, std::uint64_t known) {
                        forgotten_values_ += static_cast<std::uint64_t>(std::popcount(known));
                    });
                    octets_.fetch_sub(rows.give_back(), std::memory_order_relaxed);
                    return true;
                }
                if (change.relinks(entry.key))
                    record.links.store(0, std::memory_order_relaxed);
                const auto sight = change.sight_of(entry.key, record);
                if (change.is_unchanged(sight))
                    return false;
                rows.for_each([&](std::size_t tile, std::uint64_t known) {
                    if (const std::uint64_t gone = known & ~change.unchanged(sight, tile, known); gone != 0)
                        forgotten_values_ += rows.forget(tile, gone);
                });
                return false;
            });
    }

    /// Copies the records that queries have asked for in the last frames, at most so many frames before this
    /// one, to memory without gaps; the others are forgotten. Throws std::bad_alloc; nothing has changed
    /// then.
    void compact(int most_frames_unused = 0xffff) {
        auto copy = std::make_unique<RecordTable>();
        std::size_t octets = 0;
        std::size_t evicted = 0;
        table_->for_each_record([&](const RecordEntry& entry) {
            if (frames_unused(*entry.brick) > most_frames_unused) {
                ++evicted;
                return;
            }
            Record without_rows = *entry.record;
            without_rows.rows.store(0, std::memory_order_relaxed);
            const RecordEntry own = copy->add(entry.key, without_rows);
            own.brick->used.store(entry.brick->used.load(std::memory_order_relaxed),
                                  std::memory_order_relaxed);
            const RowList from(table_->pool(), entry.record->rows);
            RowList to(copy->pool(), own.record->rows);
            from.for_each([&](std::size_t tile, std::uint64_t) {
                const RowBytes row = from.gather(tile);
                if (const std::uint64_t lights = row.known & ~to.gather(tile).known; lights != 0)
                    octets += to.add(tile, lights, values_of(row));
            });
        });
        table_->for_each_alias([&](const RecordKey& key, const RecordEntry& entry) {
            if (copy->find(entry.key))
                copy->add_alias(key, entry.key);
        });
        table_ = std::move(copy);
        evicted_records_ += evicted;
        octets_.store(octets, std::memory_order_relaxed);
    }

    /// Begins the next frame. If the budget is taken, forgets the records that have gone unused for the
    /// longest time, so that three quarters of it are left, but none that was used in this one. Throws
    /// std::bad_alloc; nothing has changed then.
    void begin_frame() {
        if (is_full()) {
            FrameAges ages;
            table_->for_each_record([&](const RecordEntry& entry) { ages.add(frames_unused(*entry.brick)); });
            const auto least = static_cast<double>(RecordTable::least_bytes());
            const int frames = ages.most_of((0.75 * static_cast<double>(settings_.memory_budget) - least) /
                                            (static_cast<double>(table_->bytes()) - least));
            if (ages.has_older(frames))
                compact(frames);
        }
        ++frame_;
    }

    CacheStatistics statistics() const {
        CacheStatistics sum;
        for (std::size_t level = 0; level < sum.records_of_level.size(); ++level) {
            sum.records_of_level[level] = table_->records_of_level(level);
            sum.records += sum.records_of_level[level];
        }
        sum.rows = octets_.load(std::memory_order_relaxed);
        sum.lamp_rays = lamp_rays_.load(std::memory_order_relaxed);
        sum.listed_rays = listed_rays_.load(std::memory_order_relaxed);
        sum.drop_rays = drop_rays_.load(std::memory_order_relaxed);
        sum.link_rays = link_rays_.load(std::memory_order_relaxed);
        sum.point_rays = point_rays_.load(std::memory_order_relaxed);
        sum.forgotten_records = forgotten_records_;
        sum.forgotten_values = forgotten_values_;
        sum.evicted_records = evicted_records_;
        sum.bytes = table_->bytes() + lamps_.bytes() + user_lights_.capacity() * sizeof(Light) + sizeof *this;
        return sum;
    }

private:
    void make_room_for_light() {
        if (user_lights_.size() == user_lights_.capacity())
            user_lights_.reserve(2 * user_lights_.size() + 1);
    }

    int frames_unused(const RecordBrick& brick) const {
        return static_cast<std::uint16_t>(frame_ - brick.used.load(std::memory_order_relaxed));
    }

    static constexpr bool has_mesh = !std::is_same_v<Rows, LampRows>;

    /// A mesh tells rows as they are.
    static CacheSettings usable(CacheSettings settings) {
        settings.shaft_rows &= !has_mesh;
        return settings;
    }

    /// Puts a light in the place of another and calls commit(), which may throw: then nothing has changed.
    template <class Commit>
    void replace(std::size_t i, const Light& light, Commit&& commit) {
        if (record_of(light) == record_of(user_lights_[i]))
            return commit();
        LampTable::Replaced replaced = lamps_.set(i, light);
        try {
            commit();
        } catch (...) {
            lamps_.restore(std::move(replaced));
            throw;
        }
        user_lights_[i] = light;
        const std::size_t tile = i / lamps_per_tile;
        table_->for_each_record([&](const RecordEntry& entry) {
            forgotten_values_ += RowList(table_->pool(), entry.record->rows)
                                     .forget(tile, std::uint64_t{1} << i % lamps_per_tile);
        });
    }

    /// The place down from another one onto a surface, within some steps.
    std::optional<Landing> land(const glm::vec3& start, const Facing& facing, int level, float steps) const {
        const auto step = static_cast<float>(lattice_.step(level));
        std::uint64_t rays = 0;
        const auto landing = fall_onto_surface(tracer_, start, facing, steps * step, step, rays);
        drop_rays_.fetch_add(rays, std::memory_order_relaxed);
        return landing;
    }

    /// A place on a surface, as a record looks from there.
    static RowOrigin origin_at(const RowLook& look, const glm::vec3& position, const glm::vec3& normal) {
        RowOrigin origin = look.origin;
        origin.position = off_surface(position, normal, origin.step);
        origin.unit_normal = normal;
        return origin;
    }

    /// The middle of part i of a square of a step that is cut into `side` times `side`, seen from the
    /// square's own middle.
    static glm::dvec2 middle_of_part(std::size_t i, std::size_t side, double step) {
        const auto along = [&](std::size_t part) {
            return step * ((static_cast<double>(part) + 0.5) / static_cast<double>(side) - 0.5);
        };
        return {along(i % side), along(i / side)};
    }

    /// Four places all over a probe's cell.
    void look_around_cell(const Column& column, RowLook& look) const {
        const RecordKey& key = column.key;
        const Facing facing = key.facing();
        look.around = RowLook::Around::only;
        for (std::size_t i = 0; i < 4; ++i) {
            const glm::dvec2 aside = middle_of_part(i, 2, look.origin.step);
            glm::vec3 start = probe_start(lattice_, key.index(), facing, key.level());
            start[facing.u()] += static_cast<float>(aside.x);
            start[facing.v()] += static_cast<float>(aside.y);
            if (const auto landing = land(start, facing, key.level(), 4.0f))
                look.add_place(i, origin_at(look, start - landing->fall * facing.up(), landing->normal));
        }
    }

    /// Sixteen places around a record, on the plane of its surface as far as the record's lattice point sees
    /// them, else where something falls. Beyond an edge a place in the air does as well: it looks at the same
    /// lamps. One of the middle ones is the record itself. Of the finest level of shaft rows, which has most
    /// records, there are eight, in turn, and from each two rays: to find a place takes rays, too.
    void look_around_record(const Column& column, RowLook& look) const {
        constexpr std::size_t own_part = 5;
        const RecordKey& key = column.key;
        const Facing facing = key.facing();
        const auto step = static_cast<float>(look.origin.step);
        const float fall = column.record->fall;
        const float slack = landing_slack(step);
        const glm::vec3 lattice_point = lattice_.position(key.index(), key.level());
        const bool has_half = key.level() == Lattice::finest_shaft_level;
        struct Place {
            glm::vec3 start;
            bool has_ray;  ///< not the record's own place, nor one on a slope too steep to follow
        };
        std::array<Place, RowLook::most_places> places;
        std::array<Segment, RowLook::most_places> segments;
        std::array<std::uint8_t, RowLook::most_places> hit{};
        const bool has_room = fall > slack;
        std::size_t rays = 0;
        std::size_t count = 0;
        std::size_t own_place = 0;
        for (std::size_t part = 0; part < RowLook::most_places; ++part) {
            if (has_half && part % 2 != part / 4 % 2)
                continue;
            if (part == own_part)
                own_place = count;
            const glm::dvec2 aside = middle_of_part(part, 4, look.origin.step);
            const float rise = slope_rise(column.normal, facing, aside.x, aside.y, look.origin.step);
            Place& place = places[count++];
            place.start = lattice_point;
            place.start[facing.u()] += static_cast<float>(aside.x);
            place.start[facing.v()] += static_cast<float>(aside.y);
            place.start[facing.axis] += rise;
            place.has_ray = has_room && part != own_part && std::abs(rise) < step;
            if (place.has_ray)
                segments[rays++] = {lattice_point, place.start - (fall - slack) * facing.up()};
        }
        trace(tracer_, std::span<const Segment>(segments).first(rays),
              std::span<std::uint8_t>(hit).first(rays));
        drop_rays_.fetch_add(rays, std::memory_order_relaxed);
        look.around = RowLook::Around::first;
        // A quarter of the rays that a lamp may take, but 16 at least.
        look.rays_of_place =
            (std::max)(static_cast<std::size_t>(settings_.lamp_rays) / 4, RowLook::most_places) / count;
        look.parts_apart = count;
        const std::uint8_t* next_hit = hit.data();
        for (std::size_t i = 0; i < count; ++i) {
            if (i == own_place) {
                look.add_place(i, look.origin);
                continue;
            }
            const Place& place = places[i];
            const auto landing = place.has_ray && *next_hit++ == 0
                                     ? std::optional<Landing>({fall - slack, column.normal})
                                     : land(place.start, facing, key.level(), 4.0f);
            if (!landing)
                continue;
            const glm::vec3 position = place.start - landing->fall * facing.up();
            // Another surface, of which the record says nothing.
            if (fit_of(position, landing->normal, column.position, column.normal, look.origin.step) != 0)
                look.add_place(i, origin_at(look, position, landing->normal));
        }
    }

    /// Lets a record fall. Returns how many steps farther down its lattice point should be; then it is not
    /// made.
    int make(Record& record, const glm::ivec3& index, const Facing& facing, int level) const {
        const auto step = static_cast<float>(lattice_.step(level));
        const auto landing = land(lattice_.position(index, level), facing, level, 2.5f);
        record = Record();
        if (!landing)
            return 0;
        const int down = static_cast<int>(std::floor(landing->fall / step - 0.25f));
        if (down >= 1)
            return down;
        record.fall = landing->fall;
        record.set_normal(landing->normal);
        return 0;
    }

    Column keep(const RecordKey& key, const Record& made, const Facing& facing) const {
        return is_full() ? column_of(lattice_, key, made, facing, false)
                         : stand(table_->add(key, made), facing);
    }

    Column stand(const RecordEntry& entry, const Facing& facing) const {
        mark_used(*entry.brick);
        // Its row is asked for a little later.
        if (const std::uint32_t rows = entry.record->rows.load(std::memory_order_relaxed); rows != 0)
            table_->pool().fetch_ahead(rows);
        return column_of(lattice_, entry.key, *entry.record, facing, true);
    }

    void find_row(const Column& column, std::size_t tile, std::uint64_t wanted, TileValues& values) const {
        if constexpr (has_mesh) {
            const RecordKey& key = column.key;
            // The air above a surface looks to the side that the surface is seen from.
            const glm::vec3 normal = column.record->is_on_surface() ? column.normal : key.facing().up();
            std::vector<float> all(lamps_.size());
            rows_.mesh.visibility(column.position, normal, std::span<float>(all));
            for (std::size_t l = 0; l < lamps_.tile_size(tile); ++l) {
                const float lit = all[tile * lamps_per_tile + l];
                values[l] = static_cast<std::uint8_t>(floor_to_int(static_cast<double>(255.0f * lit) + 0.5));
                if (key.is_probe() && values[l] != 0 && values[l] != 255)
                    values[l] = probe_sees_both;
            }
            return;
        }
        LampRays<Tracer> rays(tracer_);
        rays.find(lamps_, tile, look_of(column), wanted, values);
        lamp_rays_.fetch_add(rays.rays(), std::memory_order_relaxed);
    }

    /// The height by which, higher or lower than at a record, its surface is beside it, world units, at most
    /// a step.
    static float slope_rise(const glm::vec3& normal, const Facing& facing, double u, double v, double step) {
        const double along = static_cast<double>(normal[facing.axis]);
        const double rise =
            -(u * static_cast<double>(normal[facing.u()]) + v * static_cast<double>(normal[facing.v()])) /
            along;
        return along == 0.0 ? 0.0f : static_cast<float>(std::clamp(rise, -step, step));
    }

    Tracer tracer_;
    Rows rows_;
    CacheSettings settings_;
    Lattice lattice_;
    std::vector<Light> user_lights_;
    FreeSlots free_;  ///< of blur rows the mesh's own count
    LampTable lamps_;
    std::unique_ptr<RecordTable> table_ = std::make_unique<RecordTable>();
    mutable std::atomic<std::uint64_t> lamp_rays_{0};
    mutable std::atomic<std::uint64_t> listed_rays_{0};
    mutable std::atomic<std::uint64_t> drop_rays_{0};
    mutable std::atomic<std::uint64_t> link_rays_{0};
    mutable std::atomic<std::uint64_t> point_rays_{0};
    mutable std::atomic<std::size_t> octets_{0};
    std::uint16_t frame_ = 0;
    std::uint64_t forgotten_records_ = 0;
    std::uint64_t forgotten_values_ = 0;
    std::uint64_t evicted_records_ = 0;
};

}  // namespace lightmesh::detail
