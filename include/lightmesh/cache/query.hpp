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
#include <lightmesh/cache/near_cells.hpp>
#include <lightmesh/cache/point_rays.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/row_table.hpp>
#include <lightmesh/cache/taps.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/segment.hpp>
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

/// One thread's queries. Points that are asked for together pass level by level, so that neighbours share
/// cells, and rays and look-ups of all of them are made side by side. Lives on the stack.
template <class Store>
class CacheQuery {
public:
    explicit CacheQuery(const Store& store) : store_(store), kernels_(cache_kernels()), cells_(store) {}

    /// S of all lights, a row for each of `count` points.
    template <class PointAt>
    void all(std::size_t count, const PointAt& point_at, std::span<float> rows) {
        const LampTable& lamps = store_.lamps();
        for (std::size_t first = 0; first < count;) {
            const std::size_t last = begin_points(first, count, point_at);
            for (std::size_t tile = 0; tile < lamps.tile_count(); ++tile) {
                for (std::size_t i = 0; i < point_count_; ++i)
                    points_[i].lit = rows.subspan((first + i) * lamps.size() + tile * lamps_per_tile,
                                                  lamps.tile_size(tile));
                find(tile, ~std::uint64_t{0});
            }
            first = last;
        }
        count_guard_rays();
    }
    /// The same for one point.
    void all(const SurfacePoint& point, std::span<float> lit) {
        all(
            1, [&](std::size_t) -> const SurfacePoint& { return point; }, lit);
    }

    /// Lists the values that `all` would have to find at these points and keep; of a light first those of the
    /// coarsest level that lacks any.
    template <class PointAt>
    void list(std::size_t count, const PointAt& point_at, RowTable& rows) {
        const LampTable& lamps = store_.lamps();
        std::array<float, lamps_per_tile> unused;
        listed_ = &rows;
        for (std::size_t first = 0; first < count && !store_.is_full();) {
            first = begin_points(first, count, point_at);
            for (std::size_t tile = 0; tile < lamps.tile_count(); ++tile) {
                for (std::size_t i = 0; i < point_count_; ++i)
                    points_[i].lit = std::span(unused).first(lamps.tile_size(tile));
                find(tile, ~std::uint64_t{0});
            }
        }
        listed_ = nullptr;
        count_guard_rays();
    }

    /// S of one light.
    float one(const SurfacePoint& point, std::size_t light) {
        begin_points(0, 1, [&](std::size_t) -> const SurfacePoint& { return point; });
        std::array<float, lamps_per_tile> lit;
        const std::size_t tile = light / lamps_per_tile;
        points_[0].lit = std::span<float>(lit).first(store_.lamps().tile_size(tile));
        find(tile, std::uint64_t{1} << light % lamps_per_tile);
        count_guard_rays();
        return lit[light % lamps_per_tile];
    }

private:
    static constexpr std::uint32_t all_four = 15;

    /// So many ways are gone side by side.
    static constexpr std::size_t most_walks = 64;

    /// Which lattice points a point sees: four bits for each level, and one that says that they are known.
    using SeenOfLevels = std::array<std::uint8_t, Lattice::level_count>;
    static constexpr std::uint32_t is_seen_known = 16;

    /// The position of a surface. Neighbouring points often have the same.
    struct Plane {
        glm::vec3 given;   ///< the normal as a point has it
        glm::vec3 normal;  ///< unit length, or zero
        WeightedFacings facings;
        std::array<TangentPlane, WeightedFacings::most> tangents;  ///< for each facing
    };

    /// A point that is asked for.
    struct Point {
        bool is_finite;
        bool is_smooth;  ///< whether the smooth normal differs from the geometric one
        int first_level;
        const Plane* plane;
        glm::vec3 position;
        glm::vec3 smooth_normal;
        double footprint;
        SeenOfLevels seen;  ///< as other tiles of lights have found

        // Of a tile.
        std::span<float> lit;
        std::uint64_t below;  ///< the lights that only the smooth normal faces
        bool is_written;      ///< whether `lit` has its values but for those
        std::size_t first_walk;
        std::size_t walk_count;

        const glm::vec3& normal() const { return plane->normal; }
    };

    /// A point on its way through the levels, along one of its facings.
    struct Walk {
        Point* point;
        const TangentPlane* tangent;
        std::uint64_t lights;         ///< about which the next level has to say something
        std::uint64_t smooth_lights;  ///< those that the smooth normal faces
        bool is_begun;                ///< whether there is anything in `blend`

        // Of a level.
        bool is_flat;        ///< whether all four records fit the point without further questions
        std::uint32_t seen;  ///< the lattice points that the point sees, one bit for each
        Fits fits;           ///< of a cell that is not flat
        CacheCell* cell;
        CellStencil stencil;

        Blend blend;
    };

    /// A walk that asks which lattice points of a cell its point sees.
    struct Sight {
        Walk* walk;
        glm::vec3 end;  ///< of the rays
        std::array<std::int32_t, 4> weights;
        std::uint32_t rest;  ///< lattice points that may be asked for, one bit for each
        std::uint32_t seen;
        std::size_t asked;  ///< the lattice point that is
    };

    /// Takes points from `first` on, before `last`, as many as there is room for. Returns the first that is
    /// left.
    template <class PointAt>
    std::size_t begin_points(std::size_t first, std::size_t last, const PointAt& point_at) {
        point_count_ = 0;
        plane_count_ = 0;
        for (std::size_t walks = 0; first < last && walks + WeightedFacings::most <= most_walks; ++first) {
            begin(points_[point_count_], point_at(first));
            walks += WeightedFacings::most;
            const Point& point = points_[point_count_++];
            if (point.is_finite)
                walks -= WeightedFacings::most - (std::max)(point.plane->facings.count, std::size_t{1});
        }
        return first;
    }

    void begin(Point& point, const SurfacePoint& given) {
        point.is_finite = is_finite(given.position) && is_finite(given.normal);
        if (!point.is_finite)
            return;
        point.position = given.position;
        store_.lattice().check_inside(point.position);
        point.plane = &plane_of(given.normal);
        point.footprint = given.footprint > 0.0f ? static_cast<double>(given.footprint) : 0.0;
        point.is_smooth = false;
        if (is_finite(given.shading_normal)) {
            point.smooth_normal = unit_or_zero(given.shading_normal);
            const float cosine = glm::dot(point.smooth_normal, point.normal());
            point.is_smooth = cosine > 0.0f && cosine < 0.999999f;
        }
        point.first_level = Lattice::base_level;
        while (point.first_level > 0 && share_of(point.first_level, point.footprint) < one_weight)
            --point.first_level;
        if (store_.lamps().tile_count() > 1)
            point.seen.fill(0);
    }

    const Plane& plane_of(const glm::vec3& normal) {
        if (plane_count_ != 0 && planes_[plane_count_ - 1].given == normal)
            return planes_[plane_count_ - 1];
        Plane& plane = planes_[plane_count_++];
        plane.given = normal;
        plane.normal = unit(normal);
        plane.facings = is_zero(plane.normal) ? WeightedFacings{} : facings_of(plane.normal);
        for (std::size_t i = 0; i < plane.facings.count; ++i)
            plane.tangents[i] = TangentPlane(plane.normal, plane.facings.all[i]);
        return plane;
    }

    /// A vector at length 1; as it is, if that is its length but for rounding.
    static glm::vec3 unit(const glm::vec3& v) {
        const glm::dvec3 w(v);
        return std::abs(w.x * w.x + w.y * w.y + w.z * w.z - 1.0) < 3e-7 ? v : unit_or_zero(v);
    }

    /// The weight of a level, by the footprint: less within the last fifth of an octave.
    std::int32_t share_of(int level, double footprint) const {
        const double step = store_.lattice().step(level);
        if (step > 1.15 * footprint)
            return one_weight;
        return step > footprint ? weight_of((step / footprint - 1.0) / 0.1487) : 0;
    }

    /// Finds some lights of a tile at the points.
    void find(std::size_t tile, std::uint64_t asked) {
        walk_count_ = 0;
        live_count_ = 0;
        int level = Lattice::base_level;
        for (std::size_t i = 0; i < point_count_; ++i) {
            begin_walks(points_[i], tile, asked);
            if (points_[i].walk_count != 0)
                level = (std::min)(level, points_[i].first_level);
        }
        for (; live_count_ != 0; ++level)
            pass_level(level, tile);
        for (std::size_t i = 0; i < point_count_; ++i)
            finish(points_[i], tile);
    }

    void begin_walks(Point& point, std::size_t tile, std::uint64_t asked) {
        point.first_walk = walk_count_;
        point.walk_count = 0;
        point.is_written = true;
        point.below = 0;
        if (!point.is_finite) {
            std::ranges::fill(point.lit, std::numeric_limits<float>::quiet_NaN());
            return;
        }
        const LampTable& lamps = store_.lamps();
        const std::uint64_t lights = asked & lamps.reaching(tile, point.position, point.normal());
        const std::uint64_t smooth =
            point.is_smooth ? asked & lamps.reaching(tile, point.position, point.smooth_normal) : 0;
        point.below = smooth & ~lights;
        if (lights == 0) {
            std::ranges::fill(point.lit, 0.0f);
            return;
        }
        point.is_written = false;
        const Plane& plane = *point.plane;
        const bool has_facing = plane.facings.count != 0;
        point.walk_count = has_facing ? plane.facings.count : 1;
        for (std::size_t i = 0; i < point.walk_count; ++i) {
            Walk& walk = walks_[walk_count_];
            walk.point = &point;
            walk.tangent = &plane.tangents[i];
            walk.lights = lights;
            walk.smooth_lights = smooth;
            walk.is_begun = false;
            if (has_facing)
                live_[live_count_++] = &walk;
            else
                add_exact(walk, tile, lights);
            ++walk_count_;
        }
    }

    void begin_blend(Walk& walk) {
        if (walk.is_begun)
            return;
        kernels_.start(walk.blend, walk.lights);
        walk.is_begun = true;
    }

    /// Writes what the walks of a point have found.
    void finish(Point& point, std::size_t tile) {
        if (listed_ != nullptr)
            return;
        if (!point.is_written) {
            if (point.walk_count == 1)
                kernels_.write_blend(walks_[point.first_walk].blend, point.lit);
            else
                write_sum(point);
        }
        // Below the facet, but not below the smooth surface that it stands for.
        if (point.below == 0)
            return;
        TileValues values{};
        store_.exact(point.position, point.normal(), point.smooth_normal, tile, point.below, values);
        for (std::uint64_t rest = point.below; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            point.lit[l] = static_cast<float>(values[l]) * (1.0f / 255.0f);
        }
    }

    /// Of the walks along several facings.
    void write_sum(const Point& point) {
        constexpr double whole = static_cast<double>(one_value) * one_weight * one_weight;
        for (std::size_t l = 0; l < point.lit.size(); ++l) {
            std::uint64_t sum = 0;
            for (std::size_t i = 0; i < point.walk_count; ++i)
                sum += static_cast<std::uint64_t>(walks_[point.first_walk + i].blend.found[l / 8][l % 8]) *
                       static_cast<std::uint64_t>(point.plane->facings.weights[i]);
            point.lit[l] = static_cast<float>(static_cast<double>(sum) / whole);
        }
    }

    /// Lets all walks that have come to a level pass it, as many at once as there is room for their cells.
    void pass_level(int level, std::size_t tile) {
        const std::size_t count = live_count_;
        live_count_ = 0;
        visitor_count_ = 0;
        new_cell_count_ = 0;
        used_cells_ = 0;
        for (std::size_t i = 0; i < count; ++i) {
            Walk& walk = *live_[i];
            if (walk.point->first_level > level) {
                live_[live_count_++] = &walk;
                continue;
            }
            find_stencil(store_.lattice(), walk.point->position, *walk.tangent, level, walk.stencil);
            const Facing& facing = walk.tangent->facing;
            CacheCell& cell = cells_.place_of(walk.stencil.corners, facing, level);
            const std::uint64_t place = std::uint64_t{1} << cells_.number_of(cell);
            if (cell.is_at(walk.stencil.corners, facing, level) &&
                (cell.is_made || (used_cells_ & place) != 0)) {
                cell.is_shared = true;
            } else {
                if ((used_cells_ & place) != 0)
                    visit(level, tile);
                cell.put(walk.stencil.corners, facing, level);
                new_cells_[new_cell_count_++] = &cell;
            }
            used_cells_ |= place;
            walk.cell = &cell;
            visitors_[visitor_count_++] = &walk;
        }
        visit(level, tile);
    }

    /// Lets some walks, whose cells have their places, pass a level. Those that go on are live.
    void visit(int level, std::size_t tile) {
        for (std::size_t i = 0; i < new_cell_count_; ++i)
            cells_.make(*new_cells_[i]);
        new_cell_count_ = 0;
        sight_count_ = 0;
        for (std::size_t i = 0; i < visitor_count_; ++i)
            fit(*visitors_[i], level);
        find_sights(level);
        for (std::size_t i = 0; i < visitor_count_; ++i) {
            Walk& walk = *visitors_[i];
            blend(walk, level, tile);
            if (walk.lights != 0)
                live_[live_count_++] = &walk;
        }
        visitor_count_ = 0;
        used_cells_ = 0;
    }

    /// The fit of a cell's records to a walk's point, and which of them it sees, or that it must ask.
    void fit(Walk& walk, int level) {
        const Point& point = *walk.point;
        const CacheCell& cell = *walk.cell;
        walk.is_flat = cell.fits(point.position, point.normal());
        if (walk.is_flat)
            return;
        walk.fits = fits_of(cell.surface, point.position, point.normal(), store_.lattice().step(level));
        walk.seen = all_four;
        if (walk.fits.are_enough() && cell.links.are_all_open())
            return;
        if (has_kept_sights(point)) {
            const std::uint8_t kept = point.seen[static_cast<std::size_t>(level)];
            walk.seen = kept & all_four;
            if (kept != 0)
                return;
        }
        sights_[sight_count_++] = {
            .walk = &walk,
            .end = off_surface(point.position, point.normal(), store_.lattice().step(level)),
            .weights = walk.stencil.weights(),
            .rest = all_four,
            .seen = 0,
            .asked = 0};
    }

    /// True if what a point sees is kept for other tiles of lights.
    bool has_kept_sights(const Point& point) const {
        return store_.lamps().tile_count() > 1 && point.plane->facings.count == 1;
    }

    /// Which lattice points the points see: rays to them, the nearest first; from those that are seen on over
    /// links, and rays only to where these don't lead, so that which ones are seen does not hang on which is
    /// nearest. Those behind something that may lie before the point are seen by their own rays alone: near
    /// the edge of a sheet links lead around it.
    void find_sights(int level) {
        std::array<Segment, most_walks> segments;
        std::array<std::uint8_t, most_walks> hit;
        for (std::size_t count = sight_count_; count != 0;) {
            for (std::size_t i = 0; i < count; ++i) {
                Sight& sight = sights_[i];
                // Heavier first, and the lesser number first among equals.
                auto k = static_cast<std::size_t>(std::countr_zero(sight.rest));
                for (std::size_t other = k + 1; other < 4; ++other)
                    if ((sight.rest >> other & 1u) != 0 && sight.weights[other] > sight.weights[k])
                        k = other;
                sight.asked = k;
                const CacheCell& cell = *sight.walk->cell;
                segments[i] = {sight.end,
                               store_.lattice().position(cell.corners.index(k, cell.facing), level)};
            }
            trace(store_.tracer(), std::span<const Segment>(segments).first(count),
                  std::span<std::uint8_t>(hit).first(count));
            guard_rays_ += count;
            std::size_t left = 0;
            for (std::size_t i = 0; i < count; ++i) {
                Sight& sight = sights_[i];
                Walk& walk = *sight.walk;
                const std::uint32_t suspect = walk.fits.suspect;
                sight.rest &= ~(1u << sight.asked);
                if (hit[i] == 0)
                    sight.seen |= 1u << sight.asked;
                walk.seen = walk.cell->links.reach(sight.seen, suspect);
                sight.rest &= ~walk.seen;
                if (sight.rest != 0) {
                    sights_[left++] = sight;
                    continue;
                }
                if (has_kept_sights(*walk.point))
                    walk.point->seen[static_cast<std::size_t>(level)] =
                        static_cast<std::uint8_t>(is_seen_known | walk.seen);
            }
            count = left;
        }
    }

    /// Once a call: what all threads count in is slow to touch.
    void count_guard_rays() {
        if (guard_rays_ != 0)
            store_.count_point_rays(guard_rays_);
        guard_rays_ = 0;
    }

    /// Adds what the records of a level say about a walk's lights. Those are left that finer levels, or rays,
    /// have to say something about.
    void blend(Walk& walk, int level, std::size_t tile) {
        const Lattice& lattice = store_.lattice();
        CacheCell& cell = *walk.cell;
        const bool is_base = level >= Lattice::base_level;
        if (walk.is_flat && is_base && blend_uniform(walk, tile))
            return;
        const std::int32_t next =
            level < lattice.finest_level() ? share_of(level + 1, walk.point->footprint) : 0;
        const bool is_last = next == 0;
        BlendLevel taps;
        taps.values = &cell.values;
        const std::int32_t covered = make_taps(walk, level, taps);
        // Under a sheet's edge the records that are seen lie beside the sheet, and know nothing of it. What
        // the next level has no share of rays have.
        const std::int32_t by_rays = (taps.taps == 0 ? one_weight : covered) * (one_weight - next) >> 15;
        if (by_rays == one_weight || taps.taps == 0) {
            if (by_rays != 0)
                stand_in(walk, tile, by_rays);
            if (by_rays == one_weight)
                walk.lights = 0;
            return;
        }
        begin_blend(walk);
        if (walk.smooth_lights != 0) {
            const std::uint64_t bent = bent_lights(walk, taps, tile);
            add_exact(walk, tile, bent);
            walk.lights &= ~bent;
            if (walk.lights == 0)
                return;
        }
        if (by_rays != 0)
            stand_in(walk, tile, by_rays);
        if (walk.is_flat && is_base) {
            if (const std::uint64_t done = walk.lights & cell.uniform_of(tile); done != 0) {
                kernels_.give_to_first(walk.blend, cell.values, done);
                walk.lights &= ~done;
                if (walk.lights == 0)
                    return;
            }
        }
        if (cell.values.tile != tile)
            cell.begin(tile);
        const bool is_exact = is_last && store_.settings().exact_edges;
        taps.is_last = is_last && !is_exact;
        taps.spread_low =
            spread_lows[static_cast<std::size_t>(std::clamp(level - Lattice::base_level, 0, 2))];
        taps.force = is_exact || is_base ? 0 : one_weight;
        taps.fade = static_cast<std::uint32_t>(is_exact ? one_weight : next);
        const bool has_probes = lattice.has_probes(level);
        taps.window = has_probes && !is_last ? window_of(walk.stencil) : 0;
        if (taps.window != 0)
            cells_.add_probe(cell);
        if ((walk.lights & ~known_to_all(walk, taps)) != 0)
            read(cell, taps, tile, walk.lights);
        taps.misses = walk.is_flat ? cell.values.misses_of_four() : cell.misses_of(taps);
        if (listed_ != nullptr) {
            // What is listed waits for its values.
            walk.lights &= known_to_all(walk, taps);
            if (walk.lights == 0)
                return;
        }
        // For one point alone it is as fast to blend them.
        if (walk.is_flat && cell.is_shared && (walk.lights & ~cell.compared) != 0)
            cell.compare(walk.lights, has_probes);
        walk.lights = kernels_.blend_level(walk.blend, walk.lights, taps);
        if (is_exact && walk.lights != 0)
            end_exactly(walk, tile);
    }

    /// Ends the search where the first cell that a point visits has the same value in all records, for every
    /// light: no more is needed.
    bool blend_uniform(Walk& walk, std::size_t tile) {
        Point& point = *walk.point;
        if (walk.is_begun || point.walk_count != 1 || walk.smooth_lights != 0 ||
            (walk.lights & ~walk.cell->uniform_of(tile)) != 0)
            return false;
        kernels_.write_first(walk.cell->values, walk.lights, point.lit);
        point.is_written = true;
        walk.lights = 0;
        return true;
    }

    /// Makes some lights known in the values of a level's records and probe, or lists those that are not.
    void read(CacheCell& cell, const BlendLevel& level, std::size_t tile, std::uint64_t lights) {
        for (std::size_t k = 0; k < level.taps; ++k)
            cells_.read(cell, level.records[k], tile, lights, listed_);
        if (level.window != 0)
            cells_.read(cell, CellValues::centre, tile, lights, listed_);
    }

    /// The lights that all records know which serve a point, and the probe if it is asked.
    static std::uint64_t known_to_all(const Walk& walk, const BlendLevel& level) {
        const CellValues& values = walk.cell->values;
        std::uint64_t known = level.window != 0 ? values.known(CellValues::centre) : ~std::uint64_t{0};
        if (walk.is_flat)
            return known & values.known_to_four();
        for (std::size_t k = 0; k < level.taps; ++k)
            known &= values.known(level.records[k]);
        return known;
    }

    /// The lights about which the geometric normal of the point, or of a record that serves it, says
    /// something else than the smooth surface does: some of the lamp is below that plane.
    std::uint64_t bent_lights(const Walk& walk, const BlendLevel& taps, std::size_t tile) const {
        const Point& point = *walk.point;
        const CacheCell& cell = *walk.cell;
        std::uint64_t lights = walk.lights & walk.smooth_lights;
        if (lights == 0)
            return 0;
        float sine_squared = 0.0f;
        for (std::size_t k = 0; k < taps.taps; ++k) {
            const glm::vec3& other = cell.columns[taps.records[k]].normal;
            if (is_zero(other))
                continue;
            const float cosine = glm::dot(point.normal(), other);
            sine_squared = (std::max)(sine_squared, 1.0f - cosine * cosine);
        }
        // With room for roundings.
        lights &= store_.lamps().grazing(tile, point.position, point.normal(), 1.01f * sine_squared + 1e-6f);
        std::uint64_t bent = 0;
        for (std::uint64_t rest = lights; rest != 0; rest &= rest - 1) {
            const Lamp& lamp =
                store_.lamps().lamp(tile * lamps_per_tile + static_cast<std::size_t>(std::countr_zero(rest)));
            bool is_bent = lamp.is_cut(point.position, point.normal());
            for (std::size_t k = 0; k < taps.taps && !is_bent; ++k) {
                const Column& column = cell.columns[taps.records[k]];
                is_bent = !is_zero(column.normal) && lamp.is_cut(column.position, column.normal);
            }
            if (is_bent)
                bent |= rest & (~rest + 1u);
        }
        return bent;
    }

    /// Gives what is left of some lights' weights to rays from the point itself.
    void add_exact(Walk& walk, std::size_t tile, std::uint64_t lights) {
        add_rays(walk, tile, lights, one_weight, [&](std::uint64_t others, TileValues& values) {
            store_.exact(walk.point->position, walk.point->normal(), tile, others, values);
        });
    }
    void end_exactly(Walk& walk, std::size_t tile) {
        add_exact(walk, tile, walk.lights);
        walk.lights = 0;
    }
    /// Gives a share of what is left of all lights' weights to such rays in place of records that do not
    /// serve the point.
    void stand_in(Walk& walk, std::size_t tile, std::int32_t share) {
        add_rays(walk, tile, walk.lights, share, [&](std::uint64_t others, TileValues& values) {
            store_.stand_in(walk.point->position, walk.point->normal(), tile, others, values);
        });
    }

    /// The same, by find(lights, values) of all but smooth lights.
    template <class Find>
    void add_rays(Walk& walk, std::size_t tile, std::uint64_t lights, std::int32_t share, const Find& find) {
        if (listed_ != nullptr)
            return;
        begin_blend(walk);
        const Point& point = *walk.point;
        TileValues values{};
        if (const std::uint64_t smooth = lights & walk.smooth_lights; smooth != 0)
            store_.exact(point.position, point.normal(), point.smooth_normal, tile, smooth, values);
        if (const std::uint64_t others = lights & ~walk.smooth_lights; others != 0)
            find(others, values);
        for (; lights != 0; lights &= lights - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(lights));
            Lanes& found = walk.blend.found[l / 8];
            Lanes& left = walk.blend.left[l / 8];
            const std::uint32_t given = left[l % 8] * static_cast<std::uint32_t>(share) >> 15;
            found[l % 8] += given * (static_cast<std::uint32_t>(values[l]) << 8);
            left[l % 8] -= given;
        }
    }

    /// The records that serve a point. Returns how far it may be covered, of one_weight, by something thin
    /// that records lie on which it does not see. What looks another way does not count, such as leaves: in
    /// foliage they are nearly everywhere, and rays past them tell little more than records do.
    std::int32_t make_taps(const Walk& walk, int level, BlendLevel& taps) {
        CacheCell& cell = *walk.cell;
        const std::array<std::int32_t, 4> bilinear = walk.stencil.weights();
        if (walk.is_flat) {
            taps.taps = 4;
            for (std::size_t k = 0; k < 4; ++k)
                taps.set(k, k, static_cast<std::uint32_t>(bilinear[k]));
            return 0;
        }
        std::array<std::int64_t, 8> raw{};
        const std::array<std::int32_t, 4>& fits = walk.fits.shares;
        std::int32_t served = 0;
        std::int32_t hidden = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            if ((walk.seen >> k & 1u) != 0)
                served += bilinear[k] * fits[k] >> 8;
            else
                hidden += (walk.fits.suspect >> k & 1u) != 0 ? bilinear[k] * walk.fits.alike[k] >> 8 : 0;
        }
        const std::int32_t air = air_share(served);
        for (std::size_t k = 0; k < 4; ++k) {
            if ((walk.seen >> k & 1u) == 0)
                continue;
            const std::int64_t weight = bilinear[k] + 1;
            if (fits[k] > 0)
                add_tap(taps, raw, k, 10 * weight * fits[k]);
            if (const std::int64_t in_air = 3 * weight * (256 - fits[k]) * air >> 6; in_air != 0)
                add_tap(taps, raw, cells_.add_air(cell, k), in_air);
        }
        set_weights(taps, raw);
        taps.pad();
        // Objects about as large as the cell lie near: what records say that are left, or in the air, need
        // not hold for the point. On the finer levels less weight hangs on that.
        const bool is_coarse = level < Lattice::base_level + 2;
        const std::int32_t covered = (std::min)(5 * hidden, one_weight);
        const std::int32_t missing = is_coarse ? (std::min)(5 * (one_weight - served), one_weight) : covered;
        taps.missing = static_cast<std::uint32_t>(missing);
        return covered;
    }

    /// The share, of 64, that records in the air have of the weight of such as do not fit: all of it where
    /// others serve a quarter of the point or less, none where these serve three quarters.
    static std::int32_t air_share(std::int32_t served) {
        return std::clamp((3 * one_weight / 4 - served) / (one_weight / 128), 0, 64);
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

    /// The weight of a cell's centre: none at the cell's border, where the next cell may know nothing of it.
    static std::uint32_t window_of(const CellStencil& stencil) {
        const std::int32_t inside = (std::min)(
            {stencil.at[0], one_weight - stencil.at[0], stencil.at[1], one_weight - stencil.at[1]});
        return static_cast<std::uint32_t>((std::min)(8 * inside, one_weight));
    }

    const Store& store_;
    const CacheKernels& kernels_;
    NearCells<Store> cells_;
    RowTable* listed_ = nullptr;  ///< null: what is missing is found
    std::size_t plane_count_ = 0;
    std::size_t point_count_ = 0;
    std::size_t walk_count_ = 0;
    std::size_t live_count_ = 0;
    std::size_t visitor_count_ = 0;
    std::size_t new_cell_count_ = 0;
    std::size_t sight_count_ = 0;
    std::uint64_t guard_rays_ = 0;  ///< to lattice points, not counted yet
    std::uint64_t used_cells_ = 0;  ///< by visitors, one bit for each place
    LazyArray<Plane, most_walks> planes_;
    LazyArray<Point, most_walks> points_;
    LazyArray<Walk, most_walks> walks_;
    LazyArray<Sight, most_walks> sights_;
    std::array<Walk*, most_walks> live_;      ///< walks with lights that a level has something to say about
    std::array<Walk*, most_walks> visitors_;  ///< those that pass a level together
    std::array<CacheCell*, most_walks> new_cells_;  ///< of theirs, those that are not made yet
};

}  // namespace lightmesh::detail
