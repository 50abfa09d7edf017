// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/blend.hpp>
#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/lazy_array.hpp>
#include <lightmesh/cache/store.hpp>
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
    /// Four columns and the links between them.
    struct Cell {
        std::array<glm::ivec3, 4> index;
        Way way;
        bool is_made = false;
        std::array<bool, 4> links;  ///< 0-1, 2-3 along u; 0-2, 1-3 along v
        std::array<Column, 4> columns;
        std::array<Spare, 4> spares;
        Column probe;
        Spare probe_spare;
        std::array<TileRow, 4> rows;
        TileRow probe_row;
        bool has_probe;
        bool all_linked() const { return links[0] && links[1] && links[2] && links[3]; }
    };

    /// What a level offers to the point.
    struct Taps {
        std::size_t count;
        std::array<const Column*, 8> columns;
        std::array<TileRow*, 8> rows;
        std::array<std::uint32_t, 8> weights;
        std::array<Column, 4> air;
        std::array<TileRow, 4> air_rows;
        std::uint32_t force;
        const Column* probe;
        TileRow* probe_row;
        std::uint32_t window;
    };

    bool begin(const SurfacePoint& point) {
        if (!is_finite(point.position) || !is_finite(point.normal))
            return false;
        point_ = point.position;
        normal_ = unit_or_zero(point.normal);
        store_.lattice().check_inside(point_);
        footprint_ = point.footprint > 0.0f ? static_cast<double>(point.footprint) : 0.0;
        smooth_normal_ =
            is_finite(point.shading_normal) ? unit_or_zero(point.shading_normal) : glm::vec3(0.0f);
        const float cosine = glm::dot(smooth_normal_, normal_);
        is_smooth_ = cosine > 0.0f && cosine < 0.999999f;
        made_taps_ = 0;
        first_level_ = Lattice::base_level;
        while (first_level_ > 0 && share_of(first_level_) < one_weight)
            --first_level_;
        return true;
    }

    /// How much a level may say, by the footprint: less within the last fifth of an octave.
    std::int32_t share_of(int level) const {
        if (footprint_ == 0.0)
            return one_weight;
        return weight_of((store_.lattice().step(level) / footprint_ - 1.0) / 0.1487);
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
        const WeightedWays ways = ways_of(normal_);
        if (ways.count == 1) {
            find_along(ways.ways[0], tile, lights);
            write(lit);
        } else {
            find_along(ways, tile, lights, lit);
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
    void find_along(const WeightedWays& ways, std::size_t tile, std::uint64_t lights, std::span<float> lit) {
        std::array<std::uint64_t, lamps_per_tile> sums{};
        for (std::size_t i = 0; i < static_cast<std::size_t>(ways.count); ++i) {
            find_along(ways.ways[i], tile, lights);
            for (std::size_t l = 0; l < lit.size(); ++l)
                sums[l] += static_cast<std::uint64_t>(blend_.found[l / 8][l % 8]) *
                           static_cast<std::uint64_t>(ways.weights[i]);
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

    void find_along(const Way& way, std::size_t tile, std::uint64_t lights) {
        blend_.start(lights);
        if (way.number() != taps_way_)
            made_taps_ = 0;
        taps_way_ = way.number();
        for (int level = first_level_; lights != 0; ++level) {
            const int finest = store_.lattice().finest_level();
            const std::int32_t next = level < finest ? share_of(level + 1) : 0;
            const bool is_last = next == 0;
            Taps& taps = taps_[static_cast<std::size_t>(level)];
            if ((made_taps_ >> level & 1u) == 0)
                make_taps(taps, way, level, is_last);
            made_taps_ |= 1u << level;
            if (taps.count == 0) {
                if (!is_last)
                    continue;
                add_exact(tile, lights);
                return;
            }
            if (!is_last && taps.force == one_weight && next == one_weight)
                continue;
            if (const std::uint64_t bent = bent_lights(taps, tile, lights); bent != 0) {
                add_exact(tile, bent);
                lights &= ~bent;
                if (lights == 0)
                    return;
            }
            level_.taps = taps.count;
            for (std::size_t k = 0; k < taps.count; ++k) {
                level_.weights[k] = taps.weights[k];
                level_.rows[k] = &known_row(*taps.rows[k], *taps.columns[k], tile, lights, row_spares_[k]);
            }
            const bool is_exact = is_last && store_.settings().exact_edges;
            level_.is_last = is_last && !is_exact;
            level_.force = is_exact ? 0 : level < Lattice::base_level ? one_weight : taps.force;
            level_.fade = static_cast<std::uint32_t>(is_exact ? one_weight : next);
            level_.probe = nullptr;
            if (!is_last && taps.window > 0) {
                level_.probe = &known_row(*taps.probe_row, *taps.probe, tile, lights, row_spares_[8]);
                level_.window = taps.window;
            }
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

    Cell& cell_at(const CellPlace& place, const Way& way, int level) {
        const std::size_t slot =
            static_cast<std::size_t>(place.index[0][way.u()] + 2 * place.index[0][way.v()]) & 3u;
        Cell& cell = cells_[4 * static_cast<std::size_t>(level) + slot];
        if (cell.is_made && cell.index == place.index && cell.way.number() == way.number())
            return cell;
        cell.is_made = false;
        cell.has_probe = false;
        cell.index = place.index;
        cell.way = way;
        bool is_kept = true;
        for (std::size_t k = 0; k < 4; ++k) {
            cell.columns[k] = store_.column(place.index[k], way, level, cell.spares[k]);
            cell.rows[k].tile = TileRow::no_tile;
            is_kept &= cell.columns[k].links != nullptr;
        }
        const auto linked = [&](std::size_t from, std::size_t to, int direction) {
            return store_.is_linked(cell.columns[from], cell.columns[to], direction, way, level);
        };
        cell.links = {linked(0, 1, 0), linked(2, 3, 0), linked(0, 2, 1), linked(1, 3, 1)};
        cell.is_made = is_kept;
        return cell;
    }

    void make_taps(Taps& taps, const Way& way, int level, bool is_last) {
        const double step = store_.lattice().step(level);
        const CellPlace place = place_in_cell(store_.lattice(), point_, normal_, way, level);
        Cell& cell = cell_at(place, way, level);
        std::array<std::int32_t, 4> fits;
        bool is_suspect = false;
        bool fits_all = true;
        std::int32_t bad = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            const Column& column = cell.columns[k];
            Fit fit;
            if (column.record->is_on_surface())
                fit = fit_of(column.place, column.normal, point_, normal_, step);
            fits[k] = fit.share;
            is_suspect |= fit.is_suspect;
            fits_all &= fit.share > 0;
            bad += place.weight[k] * (256 - fit.share) >> 8;
        }
        std::array<bool, 4> seen{true, true, true, true};
        if (is_suspect || !fits_all || !cell.all_linked())
            find_seen(seen, cell, place, level);
        std::array<std::int64_t, 8> raw{};
        std::int64_t sum = 0;
        taps.count = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            if (!seen[k])
                continue;
            const std::int64_t weight = place.weight[k] + 1;
            if (fits[k] > 0)
                add_tap(taps, raw, sum, cell.columns[k], cell.rows[k], 10 * weight * fits[k]);
            if (fits[k] < 256) {
                taps.air[k] = store_.air(place.index[k], way, level, air_spares_[k]);
                taps.air_rows[k].tile = TileRow::no_tile;
                add_tap(taps, raw, sum, taps.air[k], taps.air_rows[k], 3 * weight * (256 - fits[k]));
            }
        }
        std::int64_t rest = one_weight;
        std::size_t heaviest = 0;
        for (std::size_t k = 0; k < taps.count; ++k) {
            taps.weights[k] = static_cast<std::uint32_t>(raw[k] * one_weight / sum);
            rest -= taps.weights[k];
            if (raw[k] > raw[heaviest])
                heaviest = k;
        }
        if (taps.count > 0)
            taps.weights[heaviest] += static_cast<std::uint32_t>(rest);
        taps.force = 0;
        if (level < Lattice::base_level + forced_levels)
            taps.force = static_cast<std::uint32_t>((std::min)(4 * bad, one_weight));
        taps.window = 0;
        if (!is_last && level >= Lattice::base_level && level < Lattice::base_level + probed_levels)
            place_probe(taps, cell, place, way, level);
    }

    static void add_tap(Taps& taps, std::array<std::int64_t, 8>& raw, std::int64_t& sum, const Column& column,
                        TileRow& row, std::int64_t weight) {
        taps.columns[taps.count] = &column;
        taps.rows[taps.count] = &row;
        raw[taps.count++] = weight;
        sum += weight;
    }

    /// Which lattice points the point sees: rays to them, the nearest first, until one is open; from there on
    /// over links.
    void find_seen(std::array<bool, 4>& seen, const Cell& cell, const CellPlace& place, int level) const {
        const glm::vec3 end = Store::off_surface(point_, normal_, store_.lattice().step(level));
        seen.fill(false);
        std::array<std::size_t, 4> order{0, 1, 2, 3};
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return place.weight[a] != place.weight[b] ? place.weight[a] > place.weight[b] : a < b;
        });
        for (const std::size_t k : order) {
            if (!store_.tracer().occluded({end, store_.lattice().position(place.index[k], level)})) {
                seen[k] = true;
                break;
            }
        }
        constexpr std::array<std::array<std::size_t, 2>, 4> ends{{{0, 1}, {2, 3}, {0, 2}, {1, 3}}};
        for (int pass = 0; pass < 3; ++pass)
            for (std::size_t link = 0; link < 4; ++link)
                if (cell.links[link]) {
                    const bool either = seen[ends[link][0]] || seen[ends[link][1]];
                    seen[ends[link][0]] = seen[ends[link][1]] = either;
                }
    }

    /// What four records miss between them: one ray to each light from the middle of the cell. It has no say
    /// at the cell's border, where the next cell may know nothing of it.
    void place_probe(Taps& taps, Cell& cell, const CellPlace& place, const Way& way, int level) {
        const auto inside = [](float at) {
            return weight_of(static_cast<double>((std::min)(at, 1.0f - at)) / 0.125);
        };
        const std::int32_t window = (std::min)(inside(place.at[0]), inside(place.at[1]));
        if (window == 0)
            return;
        if (!cell.has_probe) {
            glm::ivec3 index = place.index[0];
            for (std::size_t k = 1; k < 4; ++k)
                if (way.sign > 0.0f ? place.index[k][way.axis] > index[way.axis]
                                    : place.index[k][way.axis] < index[way.axis])
                    index[way.axis] = place.index[k][way.axis];
            cell.probe = store_.probe(index, way, level, cell.probe_spare);
            cell.probe_row.tile = TileRow::no_tile;
            cell.has_probe = true;
        }
        taps.probe = &cell.probe;
        taps.probe_row = &cell.probe_row;
        taps.window = static_cast<std::uint32_t>(window);
    }

    static constexpr int probed_levels = 2;
    static constexpr int forced_levels = 0;

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
    std::uint32_t made_taps_ = 0;  ///< one bit for each level
    std::uint32_t taps_way_ = 0;
    LazyArray<Taps, Lattice::level_count> taps_;
    LazyArray<Cell, 4 * Lattice::level_count> cells_;
    LazyArray<Spare, 9> row_spares_;
    LazyArray<Spare, 4> air_spares_;
};

}  // namespace lightmesh::detail
