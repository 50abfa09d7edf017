// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/blend.hpp>
#include <lightmesh/cache/cell.hpp>
#include <lightmesh/cache/cell_values.hpp>
#include <lightmesh/cache/column.hpp>
#include <lightmesh/cache/kernels/kernels.hpp>
#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/cache/lanes.hpp>
#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/lazy_array.hpp>
#include <lightmesh/cache/point_rays.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/record_brick.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/row_table.hpp>
#include <lightmesh/cache/taps.hpp>
#include <lightmesh/support/vectors.hpp>
#include <lightmesh/surface_point.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace lightmesh::detail {

/// The state of one thread's queries: what neighbouring points share. Lives on the stack.
template <class Store>
class CacheQuery {
public:
    explicit CacheQuery(const Store& store) : store_(store), kernels_(cache_kernels()) {}

    /// S of all lights, a row for each of `count` points: of one tile of lights after the other, so that what
    /// neighbouring points share is read once a tile.
    template <class PointAt>
    void all(std::size_t count, const PointAt& point_at, std::span<float> rows) {
        const LampTable& lamps = store_.lamps();
        // Points outside the lattice are refused also where there is no light.
        for (std::size_t i = 0; i < count && lamps.tile_count() == 0; ++i)
            begin(point_at(i));
        for (std::size_t first = 0; first < count; first += block_size) {
            const std::size_t last = (std::min)(count, first + block_size);
            if (lamps.tile_count() > 1)
                std::fill_n(seen_of_points_.begin(), last - first, SeenOfLevels{});
            for (std::size_t tile = 0; tile < lamps.tile_count(); ++tile)
                for (std::size_t i = first; i < last; ++i) {
                    const std::span<float> lit =
                        rows.subspan(i * lamps.size() + tile * lamps_per_tile, lamps.tile_size(tile));
                    if (begin(point_at(i), lamps.tile_count() > 1 ? &seen_of_points_[i - first] : nullptr))
                        find(tile, ~std::uint64_t{0}, lit);
                    else
                        std::fill(lit.begin(), lit.end(), std::numeric_limits<float>::quiet_NaN());
                }
        }
    }
    /// The same for one point.
    void all(const SurfacePoint& point, std::span<float> lit) {
        all(
            1, [&](std::size_t) { return point; }, lit);
    }

    /// Lists the values that `all` would have to find at these points and keep; of a light first those of the
    /// coarsest level that lacks any.
    template <class PointAt>
    void list(std::size_t count, const PointAt& point_at, RowTable& rows) {
        listed_ = &rows;
        std::array<float, lamps_per_tile> unused;
        for (std::size_t tile = 0; tile < store_.lamps().tile_count(); ++tile)
            for (std::size_t i = 0; i < count && !store_.is_full(); ++i)
                if (begin(point_at(i)))
                    find(tile, ~std::uint64_t{0}, std::span(unused).first(store_.lamps().tile_size(tile)));
        listed_ = nullptr;
    }

    /// S of one light.
    float one(const SurfacePoint& point, std::size_t light) {
        if (!begin(point))
            return std::numeric_limits<float>::quiet_NaN();
        std::array<float, lamps_per_tile> lit;
        const std::size_t tile = light / lamps_per_tile;
        find(tile, std::uint64_t{1} << light % lamps_per_tile,
             std::span<float>(lit).first(store_.lamps().tile_size(tile)));
        return lit[light % lamps_per_tile];
    }

private:
    static constexpr std::uint32_t all_four = 15;

    /// For so many points one tile of lights is found after the other.
    static constexpr std::size_t block_size = 256;
    /// Which lattice points a point sees: four bits for each level, and one that says that they are known.
    using SeenOfLevels = std::array<std::uint8_t, Lattice::level_count>;
    static constexpr std::uint32_t is_seen_known = 16;

    /// A record that neighbouring cells share, and what is known of its row.
    struct NearColumn {
        bool is_made = false;
        RecordKey key;  ///< that was asked for
        Column column;
        std::size_t tile;  ///< of the row
        RowBytes row;
    };
    /// On all levels together.
    static constexpr std::size_t cell_count = 64;

    /// A brick in which neighbouring cells have records.
    struct NearBrick {
        RecordBrick* brick = nullptr;
    };

    /// A level's cell about the point, and what it says.
    struct Visit {
        CellStencil stencil;
        CacheCell* cell;
        bool is_flat;   ///< whether all four records fit the point without further questions
        bool has_taps;  ///< whether it is known which records serve the point
        BlendLevel level;
    };

    /// `seen`: what was found of this point for other tiles, or null.
    bool begin(const SurfacePoint& point, SeenOfLevels* seen = nullptr) {
        seen_of_levels_ = seen;
        if (!is_finite(point.position) || !is_finite(point.normal))
            return false;
        point_ = point.position;
        store_.lattice().check_inside(point_);
        // Neighbouring points often have the same normal.
        if (!has_normal_ || point.normal != given_normal_) {
            given_normal_ = point.normal;
            has_normal_ = true;
            normal_ = unit(point.normal);
            facings_ = is_zero(normal_) ? WeightedFacings{} : facings_of(normal_);
            has_tangent_ = false;
        }
        footprint_ = point.footprint > 0.0f ? static_cast<double>(point.footprint) : 0.0;
        is_smooth_ = false;
        if (is_finite(point.shading_normal)) {
            smooth_normal_ = unit_or_zero(point.shading_normal);
            const float cosine = glm::dot(smooth_normal_, normal_);
            is_smooth_ = cosine > 0.0f && cosine < 0.999999f;
        }
        visited_ = 0;
        first_level_ = Lattice::base_level;
        while (first_level_ > 0 && share_of(first_level_) < one_weight)
            --first_level_;
        return true;
    }

    /// A vector at length 1; as it is, if that is its length but for rounding.
    static glm::vec3 unit(const glm::vec3& v) {
        const glm::dvec3 w(v);
        return std::abs(w.x * w.x + w.y * w.y + w.z * w.z - 1.0) < 3e-7 ? v : unit_or_zero(v);
    }

    /// How much a level may say, by the footprint: less within the last fifth of an octave.
    std::int32_t share_of(int level) const {
        const double step = store_.lattice().step(level);
        if (step > 1.15 * footprint_)
            return one_weight;
        return step > footprint_ ? weight_of((step / footprint_ - 1.0) / 0.1487) : 0;
    }

    void find(std::size_t tile, std::uint64_t asked, std::span<float> lit) {
        const std::uint64_t lights = asked & store_.lamps().reaching(tile, point_, normal_);
        smooth_lights_ = is_smooth_ ? asked & store_.lamps().reaching(tile, point_, smooth_normal_) : 0;
        if ((lights | smooth_lights_) == 0) {
            std::fill(lit.begin(), lit.end(), 0.0f);
            return;
        }
        if (is_zero(normal_)) {
            kernels_.start(blend_, lights);
            add_exact(tile, lights);
            kernels_.write_blend(blend_, lit);
            return;
        }
        if (facings_.count == 1) {
            if (smooth_lights_ == 0 && find_uniform(tile, lights, lit))
                return;
            find_along(facings_.all[0], tile, lights);
            kernels_.write_blend(blend_, lit);
        } else {
            find_along_all(tile, lights, lit);
        }
        // Below the facet, but not below the smooth surface that it stands for.
        if (const std::uint64_t below = smooth_lights_ & ~lights; below != 0 && listed_ == nullptr) {
            TileValues values{};
            store_.exact(point_, normal_, smooth_normal_, tile, below, values);
            for (std::uint64_t rest = below; rest != 0; rest &= rest - 1) {
                const auto l = static_cast<std::size_t>(std::countr_zero(rest));
                lit[l] = static_cast<float>(values[l]) * (1.0f / 255.0f);
            }
        }
    }

    /// Blends what is found along several ways.
    void find_along_all(std::size_t tile, std::uint64_t lights, std::span<float> lit) {
        std::array<std::uint64_t, lamps_per_tile> sums{};
        for (std::size_t i = 0; i < static_cast<std::size_t>(facings_.count); ++i) {
            find_along(facings_.all[i], tile, lights);
            for (std::size_t l = 0; l < lit.size(); ++l)
                sums[l] += static_cast<std::uint64_t>(blend_.found[l / 8][l % 8]) *
                           static_cast<std::uint64_t>(facings_.weights[i]);
        }
        constexpr double whole = static_cast<double>(one_value) * one_weight * one_weight;
        for (std::size_t l = 0; l < lit.size(); ++l)
            lit[l] = static_cast<float>(static_cast<double>(sums[l]) / whole);
    }

    /// Where the first level's cell has the same value in all records, for every light, no more is needed.
    bool find_uniform(std::size_t tile, std::uint64_t lights, std::span<float> lit) {
        if (first_level_ < Lattice::base_level)
            return false;
        set_facing(facings_.all[0]);
        const Visit& visit = visit_level(first_level_);
        if (!visit.is_flat || (lights & ~visit.cell->uniform_of(tile)) != 0)
            return false;
        kernels_.write_first(visit.cell->values, lights, lit);
        return true;
    }

    void find_along(const Facing& facing, std::size_t tile, std::uint64_t lights) {
        kernels_.start(blend_, lights);
        set_facing(facing);
        for (int level = first_level_; lights != 0; ++level) {
            const int finest = store_.lattice().finest_level();
            const std::int32_t next = level < finest ? share_of(level + 1) : 0;
            const bool is_last = next == 0;
            Visit& visit = visit_level(level);
            CacheCell& cell = *visit.cell;
            if (!visit.has_taps)
                make_taps(visit, level);
            BlendLevel& blended = visit.level;
            if (blended.taps == 0) {
                if (!is_last)
                    continue;
                add_exact(tile, lights);
                return;
            }
            if (smooth_lights_ != 0) {
                const std::uint64_t bent = bent_lights(visit, tile, lights);
                add_exact(tile, bent);
                lights &= ~bent;
                if (lights == 0)
                    return;
            }
            const bool is_base = level >= Lattice::base_level;
            if (visit.is_flat && is_base) {
                if (const std::uint64_t done = lights & cell.uniform_of(tile); done != 0) {
                    kernels_.give_to_first(blend_, cell.values, done);
                    lights &= ~done;
                    if (lights == 0)
                        return;
                }
            }
            if (cell.values.tile != tile)
                cell.begin(tile);
            const bool is_exact = is_last && store_.settings().exact_edges;
            blended.is_last = is_last && !is_exact;
            blended.force = is_exact || is_base ? 0 : one_weight;
            blended.fade = static_cast<std::uint32_t>(is_exact ? one_weight : next);
            const bool has_probes = store_.lattice().has_probes(level);
            blended.window = has_probes && !is_last ? window_of(visit.stencil) : 0;
            if (blended.window != 0)
                place_probe(cell, level);
            if ((lights & ~known_to_all(cell, blended)) != 0)
                read(cell, blended, tile, lights);
            blended.misses = cell.misses_of(blended);
            if (listed_ != nullptr) {
                // What is listed waits for its values.
                lights &= known_to_all(cell, blended);
                if (lights == 0)
                    return;
            }
            // For one point alone it is as fast to blend them.
            if (visit.is_flat && cell.is_shared && (lights & ~cell.compared) != 0)
                cell.compare(lights, has_probes);
            lights = kernels_.blend_level(blend_, lights, blended);
            if (is_exact && lights != 0) {
                add_exact(tile, lights);
                return;
            }
        }
    }

    /// Makes some lights known in the values of a level's records and probe, or lists those that are not.
    void read(CacheCell& cell, const BlendLevel& level, std::size_t tile, std::uint64_t lights) {
        for (std::size_t k = 0; k < level.taps; ++k)
            read(cell, level.records[k], tile, lights);
        if (level.window != 0)
            read(cell, CellValues::centre, tile, lights);
    }
    void read(CacheCell& cell, std::size_t record, std::size_t tile, std::uint64_t lights) {
        if ((lights & ~cell.values.known(record)) == 0)
            return;
        const Column& column = cell.columns[record];
        const bool is_shaft = has_shaft_row(store_.lattice(), column.key, *column.record);
        if (listed_ == nullptr) {
            NearColumn* const near_column = near_column_of(cell, record);
            if (near_column == nullptr) {
                cell.values.set(record, store_.row(column, tile, lights), is_shaft);
                return;
            }
            if (near_column->tile != tile || (lights & ~near_column->row.known) != 0) {
                near_column->row = store_.row(column, tile, lights);
                near_column->tile = tile;
            }
            cell.values.set(record, near_column->row, is_shaft);
            return;
        }
        cell.values.set(record, store_.known_row(*column.record, tile), is_shaft);
        const std::uint64_t missing = lights & ~cell.values.known(record);
        // A record that is not kept has no links.
        if (missing != 0 && column.links != nullptr)
            listed_->add({column.key, tile}, missing);
    }

    /// The lights that all records know which serve a point, and the probe if it is asked.
    static std::uint64_t known_to_all(const CacheCell& cell, const BlendLevel& level) {
        std::uint64_t known = level.window != 0 ? cell.values.known(CellValues::centre) : ~std::uint64_t{0};
        for (std::size_t k = 0; k < level.taps; ++k)
            known &= cell.values.known(level.records[k]);
        return known;
    }

    /// The lights about which the geometric normal of the point, or of a record that serves it, says
    /// something else than the smooth surface does: some of the lamp is below that plane.
    std::uint64_t bent_lights(const Visit& visit, std::size_t tile, std::uint64_t lights) const {
        const CacheCell& cell = *visit.cell;
        const BlendLevel& taps = visit.level;
        lights &= smooth_lights_;
        if (lights == 0)
            return 0;
        float sine_squared = 0.0f;
        for (std::size_t k = 0; k < taps.taps; ++k) {
            const glm::vec3& other = cell.columns[taps.records[k]].normal;
            if (is_zero(other))
                continue;
            const float cosine = glm::dot(normal_, other);
            sine_squared = (std::max)(sine_squared, 1.0f - cosine * cosine);
        }
        // With room for roundings.
        lights &= store_.lamps().grazing(tile, point_, normal_, 1.01f * sine_squared + 1e-6f);
        std::uint64_t bent = 0;
        for (std::uint64_t rest = lights; rest != 0; rest &= rest - 1) {
            const Lamp& lamp =
                store_.lamps().lamp(tile * lamps_per_tile + static_cast<std::size_t>(std::countr_zero(rest)));
            bool is_bent = lamp.is_cut(point_, normal_);
            for (std::size_t k = 0; k < taps.taps && !is_bent; ++k) {
                const Column& column = cell.columns[taps.records[k]];
                is_bent = !is_zero(column.normal) && lamp.is_cut(column.position, column.normal);
            }
            if (is_bent)
                bent |= rest & (~rest + 1u);
        }
        return bent;
    }

    /// Gives what is left of the lights' weights to rays from the point itself.
    void add_exact(std::size_t tile, std::uint64_t lights) {
        if (listed_ != nullptr)
            return;
        TileValues values{};
        if (const std::uint64_t smooth = lights & smooth_lights_; smooth != 0)
            store_.exact(point_, normal_, smooth_normal_, tile, smooth, values);
        if (const std::uint64_t others = lights & ~smooth_lights_; others != 0)
            store_.exact(point_, normal_, tile, others, values);
        for (; lights != 0; lights &= lights - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(lights));
            Lanes& found = blend_.found[l / 8];
            Lanes& left = blend_.left[l / 8];
            found[l % 8] += left[l % 8] * (static_cast<std::uint32_t>(values[l]) << 8);
            left[l % 8] = 0;
        }
    }

    /// Before levels are visited along a facing.
    void set_facing(const Facing& facing) {
        if (has_tangent_ && tangent_.facing == facing)
            return;
        visited_ = 0;
        tangent_ = TangentPlane(normal_, facing);
        has_tangent_ = true;
    }

    Visit& visit_level(int level) {
        Visit& visit = visits_[static_cast<std::size_t>(level)];
        if ((visited_ >> level & 1u) == 0) {
            visit.stencil = stencil_at(store_.lattice(), point_, tangent_, level);
            visit.cell = &cell_at(visit.stencil.corners, tangent_.facing, level);
            visit.level.values = &visit.cell->values;
            visit.is_flat = visit.cell->fits(point_, normal_);
            visit.has_taps = false;
            visited_ |= 1u << level;
        }
        return visit;
    }

    CacheCell& cell_at(const CellCorners& corners, const Facing& facing, int level) {
        // Neighbours on a surface, and those on two surfaces, do not take each other's place.
        const auto place = static_cast<std::size_t>(corners.u + 2 * corners.v + 4 * corners.along[0]) & 7u;
        CacheCell& cell = cells_[8 * (static_cast<std::size_t>(level) & 7u) + place];
        if (cell.is_made && cell.corners == corners && cell.facing == facing && cell.level == level) {
            cell.is_shared = true;
            return cell;
        }
        cell.is_made = false;
        cell.corners = corners;
        cell.facing = facing;
        cell.level = level;
        bool is_kept = true;
        for (std::size_t k = 0; k < 4; ++k) {
            set_near_column(cell, k, RecordKind::fallen, [&](const glm::ivec3& index, Record& spare) {
                return store_.column(index, facing, level, spare, near_brick(cell, k));
            });
            is_kept &= cell.columns[k].links != nullptr;
        }
        const auto link = [&](std::size_t from, std::size_t to, int direction) -> std::uint32_t {
            return store_.is_linked(cell.columns[from], cell.columns[to], direction, facing, level) ? 1u : 0u;
        };
        cell.links.along_u = link(0, 1, 0) | link(2, 3, 0) << 2;
        cell.links.along_v = link(0, 2, 1) | link(1, 3, 1) << 1;
        cell.finish(store_.lattice().step(level));
        cell.is_made = is_kept;
        return cell;
    }

    /// The brick that was found last where records of a cell's level beside its k-th lattice point are.
    RecordBrick*& near_brick(const CacheCell& cell, std::size_t k = 0) {
        const std::size_t u = static_cast<std::size_t>(cell.corners.u) + (k & 1u);
        const std::size_t v = static_cast<std::size_t>(cell.corners.v) + (k >> 1);
        const std::size_t place = (u >> 2 & 1u) + 2 * (v >> 2 & 1u);
        return near_bricks_[4 * static_cast<std::size_t>(cell.level) + place].brick;
    }
    /// The place among those that were asked for last of one of a cell's records at its four lattice points,
    /// on a surface or in the air.
    NearColumn& near_place(const CacheCell& cell, std::size_t record) {
        static_assert(CellValues::first_in_air == 4 && CellValues::centre == 8);
        const std::size_t k = record & 3u;
        const auto u = static_cast<std::size_t>(cell.corners.u) + (k & 1u);
        const auto v = static_cast<std::size_t>(cell.corners.v) + (k >> 1);
        const auto along = static_cast<std::size_t>(cell.corners.along[k]);
        return near_columns_[(static_cast<std::size_t>(cell.level) & 3u) + (record & 4u)]
                            [(u & 3u) + 4 * (v & 3u) + 16 * (along & 3u)];
    }
    /// Sets one of these records, by find(index, where one stands that is not kept) if it must.
    template <class Find>
    void set_near_column(CacheCell& cell, std::size_t record, RecordKind kind, const Find& find) {
        const glm::ivec3 index = cell.corners.index(record & 3u, cell.facing);
        const RecordKey key(index, kind, cell.facing, cell.level);
        NearColumn& place = near_place(cell, record);
        if (place.is_made && place.key == key) {
            set_column(cell, record, place.column);
            return;
        }
        Record& own = spare(cell, record);
        set_column(cell, record, find(index, own));
        // What stands in the cell's own place goes with the cell.
        if (cell.columns[record].record == &own)
            return;
        place.is_made = true;
        place.key = key;
        place.column = cell.columns[record];
        place.tile = CellValues::no_tile;
    }
    /// One of these records among those that were asked for last, or null.
    NearColumn* near_column_of(const CacheCell& cell, std::size_t record) {
        if (record >= CellValues::centre)
            return nullptr;
        NearColumn& place = near_place(cell, record);
        return place.is_made && place.column.record == cell.columns[record].record ? &place : nullptr;
    }

    void make_taps(Visit& visit, int level) {
        CacheCell& cell = *visit.cell;
        BlendLevel& taps = visit.level;
        const std::array<std::int32_t, 4> bilinear = visit.stencil.weights();
        visit.has_taps = true;
        if (visit.is_flat) {
            taps.taps = 4;
            taps.missing = 0;
            for (std::size_t k = 0; k < 4; ++k)
                taps.set(k, k, static_cast<std::uint32_t>(bilinear[k]));
            return;
        }
        taps.taps = 0;
        std::array<std::int64_t, 8> raw{};
        const double step = store_.lattice().step(level);
        const auto [fits, suspect] = fits_of(cell.surface, point_, normal_, step);
        const bool fits_all = fits[0] > 0 && fits[1] > 0 && fits[2] > 0 && fits[3] > 0;
        std::uint32_t seen = all_four;
        if (!fits_all || !cell.links.are_all_open() || suspect != 0)
            seen = seen_by_point(suspect, cell, bilinear, level);
        std::int32_t served = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            if ((seen >> k & 1u) == 0)
                continue;
            served += bilinear[k] * fits[k] >> 8;
            const std::int64_t weight = bilinear[k] + 1;
            if (fits[k] == 256) {
                add_tap(taps, raw, k, 2560 * weight);
                continue;
            }
            if (fits[k] > 0)
                add_tap(taps, raw, k, 10 * weight * fits[k]);
            const std::size_t air = CellValues::first_in_air + k;
            if (!cell.has_column[air])
                set_near_column(cell, air, RecordKind::air, [&](const glm::ivec3& index, Record& spare) {
                    return store_.air(index, cell.facing, level, spare, near_brick(cell, k));
                });
            add_tap(taps, raw, air, 3 * weight * (256 - fits[k]));
        }
        set_weights(taps, raw);
        taps.pad();
        // Objects about as large as the cell lie near: what records say that are left, or in the air, need
        // not hold for the point. On the finer levels less weight hangs on that.
        const bool is_coarse = level < Lattice::base_level + 2;
        taps.missing =
            is_coarse ? static_cast<std::uint32_t>((std::min)(5 * (one_weight - served), one_weight)) : 0;
    }

    static void add_tap(BlendLevel& taps, std::array<std::int64_t, 8>& raw, std::size_t record,
                        std::int64_t weight) {
        taps.records[taps.taps] = static_cast<std::uint8_t>(record);
        raw[taps.taps++] = weight;
    }

    /// Weights that sum to one_weight. What they are made of is below 2^53.
    static void set_weights(BlendLevel& taps, const std::array<std::int64_t, 8>& raw) {
        if (taps.taps == 0)
            return;
        std::int64_t sum = 0;
        std::size_t heaviest = 0;
        for (std::size_t k = 0; k < taps.taps; ++k) {
            sum += raw[k];
            if (raw[k] > raw[heaviest])
                heaviest = k;
        }
        std::uint32_t rest = one_weight;
        for (std::size_t k = 0; k < taps.taps; ++k) {
            const double share = static_cast<double>(raw[k] * one_weight) / static_cast<double>(sum);
            taps.set(k, taps.records[k], static_cast<std::uint32_t>(static_cast<std::int32_t>(share)));
            rest -= taps.weights[k];
        }
        taps.set(heaviest, taps.records[heaviest], taps.weights[heaviest] + rest);
    }

    /// As below, but once for all tiles of lights.
    std::uint32_t seen_by_point(std::uint32_t suspect, const CacheCell& cell,
                                const std::array<std::int32_t, 4>& weights, int level) const {
        if (seen_of_levels_ == nullptr || facings_.count != 1)
            return find_seen(suspect, cell, weights, level);
        std::uint8_t& kept = (*seen_of_levels_)[static_cast<std::size_t>(level)];
        if (kept == 0)
            kept = static_cast<std::uint8_t>(is_seen_known | find_seen(suspect, cell, weights, level));
        return kept & all_four;
    }
    /// Which lattice points the point sees, one bit for each: rays to them, the nearest first, until one is
    /// open; from there on over links. Those behind something that may lie before the point are seen by their
    /// own rays alone: near the edge of a sheet links lead around it.
    std::uint32_t find_seen(std::uint32_t suspect, const CacheCell& cell,
                            const std::array<std::int32_t, 4>& weights, int level) const {
        const glm::vec3 end = off_surface(point_, normal_, store_.lattice().step(level));
        std::uint32_t seen = 0;
        for (std::uint32_t rest = all_four; rest != 0;) {
            // Heavier first, and the lesser number first among equals.
            auto k = static_cast<std::size_t>(std::countr_zero(rest));
            for (std::size_t other = k + 1; other < 4; ++other)
                if ((rest >> other & 1u) != 0 && weights[other] > weights[k])
                    k = other;
            rest &= ~(1u << k);
            if (!store_.tracer().occluded(
                    {end, store_.lattice().position(cell.corners.index(k, cell.facing), level)}))
                seen |= 1u << k;
            if ((seen & ~suspect) != 0)
                rest &= suspect;
        }
        return cell.links.reach(seen, suspect);
    }

    /// The weight of a cell's centre: none at the cell's border, where the next cell may know nothing of it.
    static std::uint32_t window_of(const CellStencil& stencil) {
        const std::int32_t inside = (std::min)(
            {stencil.at[0], one_weight - stencil.at[0], stencil.at[1], one_weight - stencil.at[1]});
        return static_cast<std::uint32_t>((std::min)(8 * inside, one_weight));
    }

    /// What four records miss between them: see `probe` of the store.
    void place_probe(CacheCell& cell, int level) {
        if (cell.has_column[CellValues::centre])
            return;
        const auto [lowest, highest] = std::ranges::minmax(cell.corners.along);
        glm::ivec3 index = cell.corners.index(0, cell.facing);
        index[cell.facing.axis] = cell.facing.sign > 0.0f ? highest : lowest;
        set_column(
            cell, CellValues::centre,
            store_.probe(index, cell.facing, level, spare(cell, CellValues::centre), near_brick(cell)));
    }

    static void set_column(CacheCell& cell, std::size_t record, const Column& column) {
        cell.columns[record] = column;
        cell.has_column[record] = true;
    }

    /// Where a record of a cell stands that is not kept.
    Record& spare(const CacheCell& cell, std::size_t record) {
        return spares_[static_cast<std::size_t>(&cell - &cells_[0])][record];
    }

    const Store& store_;
    const CacheKernels& kernels_;
    RowTable* listed_ = nullptr;  ///< null: what is missing is found
    glm::vec3 point_{0.0f};
    glm::vec3 given_normal_{0.0f};  ///< as the last point had it
    bool has_normal_ = false;
    bool has_tangent_ = false;
    glm::vec3 normal_{0.0f};
    glm::vec3 smooth_normal_{0.0f};
    bool is_smooth_ = false;           ///< whether the smooth normal differs from the geometric one
    std::uint64_t smooth_lights_ = 0;  ///< of the tile, those that the smooth normal faces
    double footprint_ = 0.0;
    int first_level_ = Lattice::base_level;
    Blend blend_;
    WeightedFacings facings_;
    std::uint32_t visited_ = 0;  ///< one bit for each level
    TangentPlane tangent_;
    SeenOfLevels* seen_of_levels_ = nullptr;  ///< the point's, or null
    std::array<SeenOfLevels, block_size> seen_of_points_;
    LazyArray<Visit, Lattice::level_count> visits_;
    LazyArray<CacheCell, cell_count> cells_;                ///< by level modulo 8
    LazyArray<LazyArray<NearColumn, 64>, 8> near_columns_;  ///< by level modulo 4, and in the air
    LazyArray<NearBrick, 4 * Lattice::level_count> near_bricks_;
    LazyArray<std::array<Record, CellValues::record_count>, cell_count> spares_;
};

}  // namespace lightmesh::detail
