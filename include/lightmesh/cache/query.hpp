// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/blend.hpp>
#include <lightmesh/cache/cell.hpp>
#include <lightmesh/cache/lamp_rows.hpp>
#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/lazy_array.hpp>
#include <lightmesh/cache/point_rays.hpp>
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
#include <cstring>
#include <limits>
#include <span>

namespace lightmesh::detail {

/// The state of one thread's queries: what neighbouring points share. Lives on the stack.
template <class Store>
class CacheQuery {
public:
    explicit CacheQuery(const Store& store) : store_(store) {}

    /// S of all lights.
    void all(const SurfacePoint& point, std::span<float> lit) {
        const LampTable& lamps = store_.lamps();
        if (!begin(point)) {
            std::fill(lit.begin(), lit.end(), std::numeric_limits<float>::quiet_NaN());
            return;
        }
        for (std::size_t tile = 0; tile < lamps.tile_count(); ++tile)
            find(tile, ~std::uint64_t{0}, lit.subspan(tile * lamps_per_tile, lamps.tile_size(tile)));
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
    /// What a level offers to the point.
    struct Taps {
        std::size_t count;
        std::array<const Column*, 8> columns;
        std::array<TileRow*, 8> rows;
        std::array<std::uint32_t, 8> weights;
        const Column* probe;
        TileRow* probe_row;
        std::uint32_t window;
    };

    /// A level's cell about the point.
    struct Visit {
        CellPlace place;
        CacheCell* cell;
        bool is_flat;  ///< whether all four records fit the point without further questions
        bool has_taps;
        Taps taps;
    };

    bool begin(const SurfacePoint& point) {
        if (!is_finite(point.position) || !is_finite(point.normal))
            return false;
        point_ = point.position;
        normal_ = unit(point.normal);
        ways_ = is_zero(normal_) ? WeightedWays{} : ways_of(normal_);
        store_.lattice().check_inside(point_);
        footprint_ = point.footprint > 0.0f ? static_cast<double>(point.footprint) : 0.0;
        smooth_normal_ =
            is_finite(point.shading_normal) ? unit_or_zero(point.shading_normal) : glm::vec3(0.0f);
        const float cosine = glm::dot(smooth_normal_, normal_);
        is_smooth_ = cosine > 0.0f && cosine < 0.999999f;
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
            blend_.start(lights);
            add_exact(tile, lights);
            write(lit);
            return;
        }
        if (ways_.count == 1) {
            if (smooth_lights_ == 0 && find_uniform(tile, lights, lit))
                return;
            find_along(ways_.ways[0], tile, lights);
            write(lit);
        } else {
            find_along_all(tile, lights, lit);
        }
        // Below the facet, but not below the smooth surface that it stands for.
        if (const std::uint64_t below = smooth_lights_ & ~lights; below != 0) {
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
        for (std::size_t i = 0; i < static_cast<std::size_t>(ways_.count); ++i) {
            find_along(ways_.ways[i], tile, lights);
            for (std::size_t l = 0; l < lit.size(); ++l)
                sums[l] += static_cast<std::uint64_t>(blend_.found[l / 8][l % 8]) *
                           static_cast<std::uint64_t>(ways_.weights[i]);
        }
        constexpr double whole = static_cast<double>(one_value) * one_weight * one_weight;
        for (std::size_t l = 0; l < lit.size(); ++l)
            lit[l] = static_cast<float>(static_cast<double>(sums[l]) / whole);
    }

    void write(std::span<float> lit) const {
        constexpr float scale = 1.0f / (static_cast<float>(one_value) * static_cast<float>(one_weight));
        for (std::size_t first = 0; first < lit.size(); first += 8) {
            // Below 2^31, so that signed numbers, which are faster, do.
            const auto found = __builtin_convertvector(blend_.found[first / 8], SignedLanes);
            const FloatLanes values = __builtin_convertvector(found, FloatLanes) * scale;
            std::memcpy(lit.data() + first, &values,
                        sizeof(float) * (std::min)(lit.size() - first, std::size_t{8}));
        }
    }

    /// Where the first level's cell has the same value in all records, for every light, no more is needed.
    bool find_uniform(std::size_t tile, std::uint64_t lights, std::span<float> lit) {
        if (first_level_ < Lattice::base_level)
            return false;
        const Visit& visit = visit_level(first_level_, ways_.ways[0]);
        if (!visit.is_flat || (lights & ~visit.cell->uniform_of(tile)) != 0)
            return false;
        blend_.start(lights);
        blend_.add(visit.cell->rows[0], lights);
        write(lit);
        return true;
    }

    void find_along(const Way& way, std::size_t tile, std::uint64_t lights) {
        blend_.start(lights);
        for (int level = first_level_; lights != 0; ++level) {
            const int finest = store_.lattice().finest_level();
            const std::int32_t next = level < finest ? share_of(level + 1) : 0;
            const bool is_last = next == 0;
            Visit& visit = visit_level(level, way);
            CacheCell& cell = *visit.cell;
            if (!visit.has_taps)
                make_taps(visit, level);
            Taps& taps = visit.taps;
            if (taps.count == 0) {
                if (!is_last)
                    continue;
                add_exact(tile, lights);
                return;
            }
            if (const std::uint64_t bent = bent_lights(taps, tile, lights); bent != 0) {
                add_exact(tile, bent);
                lights &= ~bent;
            }
            const bool is_base = level >= Lattice::base_level;
            if (visit.is_flat && is_base) {
                const std::uint64_t done = lights & cell.uniform_of(tile);
                blend_.add(cell.rows[0], done);
                lights &= ~done;
            }
            if (lights == 0)
                return;
            level_.taps = taps.count;
            for (std::size_t k = 0; k < taps.count; ++k) {
                level_.weights[k] = taps.weights[k];
                level_.rows[k] = &known_row(*taps.rows[k], *taps.columns[k], tile, lights, row_spares_[k]);
            }
            const bool is_exact = is_last && store_.settings().exact_edges;
            level_.is_last = is_last && !is_exact;
            level_.force = is_exact || is_base ? 0 : one_weight;
            level_.fade = static_cast<std::uint32_t>(is_exact ? one_weight : next);
            level_.probe = nullptr;
            const bool is_probed = is_base && level < Lattice::base_level + probed_levels;
            if (!is_last && is_probed && place_probe(visit, level)) {
                level_.probe = &known_row(*taps.probe_row, *taps.probe, tile, lights, row_spares_[8]);
                level_.window = taps.window;
            }
            if (visit.is_flat)
                cell.compare(tile, lights, is_probed);
            lights = blend_level(blend_, lights, level_);
            if (is_exact && lights != 0) {
                add_exact(tile, lights);
                return;
            }
        }
    }

    /// Makes a row know some lights, if it does not yet.
    const TileRow& known_row(TileRow& row, const Column& column, std::size_t tile, std::uint64_t lights,
                             Spare& spare) const {
        if (row.tile != tile || (lights & ~row.known) != 0)
            row = store_.row(column, tile, lights, spare);
        return row;
    }

    /// The lights about which the geometric normal of the point, or of a record that serves it, says
    /// something else than the smooth surface does: some of the lamp is below that plane.
    std::uint64_t bent_lights(const Taps& taps, std::size_t tile, std::uint64_t lights) const {
        lights &= smooth_lights_;
        if (lights == 0)
            return 0;
        float sine_squared = 0.0f;
        for (std::size_t k = 0; k < taps.count; ++k) {
            const glm::vec3& other = taps.columns[k]->normal;
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
            for (std::size_t k = 0; k < taps.count && !is_bent; ++k)
                is_bent = !is_zero(taps.columns[k]->normal) &&
                          lamp.is_cut(taps.columns[k]->place, taps.columns[k]->normal);
            if (is_bent)
                bent |= rest & (~rest + 1u);
        }
        return bent;
    }

    /// Gives what is left of the lights' weights to rays from the point itself.
    void add_exact(std::size_t tile, std::uint64_t lights) {
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

    Visit& visit_level(int level, const Way& way) {
        if (visited_ == 0 || way.number() != tangent_.way.number()) {
            visited_ = 0;
            tangent_ = TangentPlane(normal_, way);
        }
        Visit& visit = visits_[static_cast<std::size_t>(level)];
        if ((visited_ >> level & 1u) == 0) {
            visit.place = place_in_cell(store_.lattice(), point_, tangent_, level);
            visit.cell = &cell_at(visit.place, way, level);
            visit.is_flat = visit.cell->fits(point_, normal_);
            visit.has_taps = false;
            visited_ |= 1u << level;
        }
        return visit;
    }

    CacheCell& cell_at(const CellPlace& place, const Way& way, int level) {
        const std::size_t slot =
            static_cast<std::size_t>(place.index[0][way.u()] + 2 * place.index[0][way.v()]) & 3u;
        CacheCell& cell = cells_[4 * static_cast<std::size_t>(level) + slot];
        if (cell.is_made && cell.index == place.index && cell.way.number() == way.number())
            return cell;
        cell.is_made = false;
        cell.index = place.index;
        cell.way = way;
        bool is_kept = true;
        for (std::size_t k = 0; k < 4; ++k) {
            cell.columns[k] = store_.column(place.index[k], way, level, cell.spares[k]);
            is_kept &= cell.columns[k].links != nullptr;
        }
        const auto linked = [&](std::size_t from, std::size_t to, int direction) {
            return store_.is_linked(cell.columns[from], cell.columns[to], direction, way, level);
        };
        cell.links = {linked(0, 1, 0), linked(2, 3, 0), linked(0, 2, 1), linked(1, 3, 1)};
        cell.finish(store_.lattice().step(level));
        cell.is_made = is_kept;
        return cell;
    }

    void make_taps(Visit& visit, int level) {
        CacheCell& cell = *visit.cell;
        Taps& taps = visit.taps;
        const std::array<std::int32_t, 4> place_weights = visit.place.weights();
        visit.has_taps = true;
        taps.count = 0;
        std::array<std::int64_t, 8> raw{};
        if (visit.is_flat) {
            for (std::size_t k = 0; k < 4; ++k)
                add_tap(taps, raw, cell.columns[k], cell.rows[k], place_weights[k] + 1);
            set_weights(taps, raw);
            return;
        }
        const double step = store_.lattice().step(level);
        std::array<std::int32_t, 4> fits;
        std::array<bool, 4> suspect{};
        bool fits_all = true;
        for (std::size_t k = 0; k < 4; ++k) {
            const Column& column = cell.columns[k];
            Fit fit;
            if (column.record->is_on_surface())
                fit = fit_of(column.place, column.normal, point_, normal_, step);
            fits[k] = fit.share;
            suspect[k] = fit.is_suspect;
            fits_all &= fit.share > 0;
        }
        std::array<bool, 4> seen{true, true, true, true};
        if (!fits_all || !cell.all_linked || std::ranges::find(suspect, true) != suspect.end())
            find_seen(seen, suspect, cell, place_weights, level);
        for (std::size_t k = 0; k < 4; ++k) {
            if (!seen[k])
                continue;
            const std::int64_t weight = place_weights[k] + 1;
            if (fits[k] == 256) {
                add_tap(taps, raw, cell.columns[k], cell.rows[k], 2560 * weight);
                continue;
            }
            if (fits[k] > 0)
                add_tap(taps, raw, cell.columns[k], cell.rows[k], 10 * weight * fits[k]);
            if (!cell.has_air[k])
                cell.set_air(k, store_.air(cell.index[k], cell.way, level, cell.spares[4 + k]));
            add_tap(taps, raw, cell.columns[4 + k], cell.rows[4 + k], 3 * weight * (256 - fits[k]));
        }
        set_weights(taps, raw);
    }

    static void add_tap(Taps& taps, std::array<std::int64_t, 8>& raw, const Column& column, TileRow& row,
                        std::int64_t weight) {
        taps.columns[taps.count] = &column;
        taps.rows[taps.count] = &row;
        raw[taps.count++] = weight;
    }

    /// Weights that sum to one_weight. What they are made of is below 2^53.
    static void set_weights(Taps& taps, const std::array<std::int64_t, 8>& raw) {
        if (taps.count == 0)
            return;
        std::int64_t sum = 0;
        std::size_t heaviest = 0;
        for (std::size_t k = 0; k < taps.count; ++k) {
            sum += raw[k];
            if (raw[k] > raw[heaviest])
                heaviest = k;
        }
        std::int64_t rest = one_weight;
        for (std::size_t k = 0; k < taps.count; ++k) {
            const double share = static_cast<double>(raw[k] * one_weight) / static_cast<double>(sum);
            taps.weights[k] = static_cast<std::uint32_t>(static_cast<std::int32_t>(share));
            rest -= taps.weights[k];
        }
        taps.weights[heaviest] += static_cast<std::uint32_t>(rest);
    }

    /// Which lattice points the point sees: rays to them, the nearest first, until one is open; from there on
    /// over links. Those behind something that may lie before the point are seen by their own rays alone:
    /// near the edge of a sheet links lead around it.
    void find_seen(std::array<bool, 4>& seen, const std::array<bool, 4>& suspect, const CacheCell& cell,
                   const std::array<std::int32_t, 4>& weights, int level) const {
        const glm::vec3 end = off_surface(point_, normal_, store_.lattice().step(level));
        seen.fill(false);
        std::array<std::size_t, 4> order{0, 1, 2, 3};
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return weights[a] != weights[b] ? weights[a] > weights[b] : a < b;
        });
        bool is_any_open = false;
        for (const std::size_t k : order) {
            if (is_any_open && !suspect[k])
                continue;
            seen[k] = !store_.tracer().occluded({end, store_.lattice().position(cell.index[k], level)});
            is_any_open |= seen[k] && !suspect[k];
        }
        constexpr std::array<std::array<std::size_t, 2>, 4> ends{{{0, 1}, {2, 3}, {0, 2}, {1, 3}}};
        for (int pass = 0; pass < 3; ++pass)
            for (std::size_t link = 0; link < 4; ++link)
                if (const auto [a, b] = ends[link]; cell.links[link] && !suspect[a] && !suspect[b])
                    seen[a] = seen[b] = seen[a] || seen[b];
    }

    /// What four records miss between them: one ray to each light from the middle of the cell. It has no say
    /// at the cell's border, where the next cell may know nothing of it. Returns whether it has.
    bool place_probe(Visit& visit, int level) {
        CacheCell& cell = *visit.cell;
        const CellPlace& place = visit.place;
        const auto inside = [](float at) {
            return weight_of(static_cast<double>((std::min)(at, 1.0f - at)) / 0.125);
        };
        const std::int32_t window = (std::min)(inside(place.at[0]), inside(place.at[1]));
        if (window == 0)
            return false;
        if (!cell.has_probe) {
            glm::ivec3 index = place.index[0];
            for (std::size_t k = 1; k < 4; ++k)
                if (cell.way.sign > 0.0f ? place.index[k][cell.way.axis] > index[cell.way.axis]
                                         : place.index[k][cell.way.axis] < index[cell.way.axis])
                    index[cell.way.axis] = place.index[k][cell.way.axis];
            cell.probe = store_.probe(index, cell.way, level, cell.probe_spare);
            cell.probe_row.tile = TileRow::no_tile;
            cell.has_probe = true;
        }
        visit.taps.probe = &cell.probe;
        visit.taps.probe_row = &cell.probe_row;
        visit.taps.window = static_cast<std::uint32_t>(window);
        return true;
    }

    static constexpr int probed_levels = 2;

    const Store& store_;
    glm::vec3 point_{0.0f};
    glm::vec3 normal_{0.0f};
    glm::vec3 smooth_normal_{0.0f};
    bool is_smooth_ = false;           ///< whether the smooth normal differs from the geometric one
    std::uint64_t smooth_lights_ = 0;  ///< of the tile, those that the smooth normal faces
    double footprint_ = 0.0;
    int first_level_ = Lattice::base_level;
    Blend blend_;
    BlendLevel level_;
    WeightedWays ways_;
    std::uint32_t visited_ = 0;  ///< one bit for each level
    TangentPlane tangent_;
    LazyArray<Visit, Lattice::level_count> visits_;
    LazyArray<CacheCell, 4 * Lattice::level_count> cells_;
    LazyArray<Spare, 9> row_spares_;
};

}  // namespace lightmesh::detail
