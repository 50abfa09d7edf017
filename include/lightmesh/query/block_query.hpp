// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/long_fill.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/fill/unit_table.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/level.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/query/kernels/kernel_types.hpp>
#include <lightmesh/query/kernels/kernels.hpp>
#include <lightmesh/query/links_around.hpp>
#include <lightmesh/query/neighbours.hpp>
#include <lightmesh/query/point_block.hpp>
#include <lightmesh/query/query_point.hpp>
#include <lightmesh/query/result_rows.hpp>
#include <lightmesh/query/short_test.hpp>
#include <lightmesh/query/tally.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

/// Queries of a mesh that fills itself: first what is missing is listed, traced and stored, then it is
/// counted.

namespace lightmesh::detail {

/// S of all lights for many points, some at once: they share rays in batches, bricks, and what they have in
/// common is counted once. Its memory is on the stack.
template <class Filler>
class BlockQuery {
public:
    /// `statistics`, which may be null, has all added but the number of points.
    BlockQuery(const Filler& filler, QueryStatistics* statistics)
        : filler_(filler), mesh_(filler.data().view()), kernels_(kernels()),
          block_(grid(), lights(), kernels_), rows_(lights()), statistics_(statistics) {}

    /// As `LightMesh::visibility` for many points; `all` holds all their rows.
    void run(const PointBatch& batch, std::span<float> all) {
        rows_ = ResultRows(lights(), all);
        for (std::size_t done = 0; done < batch.size();) {
            done += prepare_block(batch, done);
            // What is blended into a row cannot be taken back if something missing cannot be found.
            if (!batch.shares.empty())
                resolve();
            count();
            if (short_test() == ShortTest::exact)
                test_all_neighbours();
        }
    }

    /// Finds and stores all that `run` would need for these points, but for what `ShortTest::exact` asks of
    /// each point alone.
    void fill(const PointBatch& batch) {
        for (std::size_t done = 0; done < batch.size();) {
            done += prepare_block(batch, done);
            resolve();
        }
    }

    /// The same, but long tests are listed instead of found.
    void list(const PointBatch& batch, UnitTable& units) {
        listed_ = &units;
        fill(batch);
        listed_ = nullptr;
    }

    /// Lists the links that are missing where floods of these points' seeds can lead, one bit a cell.
    void list_links(const PointBatch& batch, UnitTable& cells) {
        if (short_test() != ShortTest::linked)
            return;
        LinksAround links(mesh_, cells);
        for (std::size_t done = 0; done < batch.size();) {
            done += take_block(batch, done);
            find_uniform_points();
            for (const QueryPoint& point : points())
                if (!point.is_uniform)
                    links.add(point);
        }
        links.list();
    }

private:
    const LightTable& lights() const { return *mesh_.lights; }
    const Grid& grid() const { return *mesh_.grid; }
    ShortTest short_test() const { return mesh_.settings->short_test; }
    std::span<QueryPoint> points() { return block_.points(); }

    std::size_t take_block(const PointBatch& batch, std::size_t first) {
        return block_.take(batch, first, rows_,
                           [this](const glm::ivec3& coord) { return filler_.use_brick(mesh_, coord); });
    }

    /// Takes a block of points, and finds all that counting them needs but long tests.
    std::size_t prepare_block(const PointBatch& batch, std::size_t first) {
        const std::size_t taken = take_block(batch, first);
        if (short_test() == ShortTest::linked) {
            find_uniform_points();
            find_linked_neighbours();
        }
        block_.find_changes();
        return taken;
    }

    /// Points whose neighbours are known to agree about each light that reaches them: there the short test
    /// can't change the result, as long as it leaves any neighbour. That it leaves one, nothing but a ray
    /// from the point can tell: in a hollow thinner than a step, which no link and no long test passes, the
    /// point sees none of them.
    ///
    /// The masks of the neighbours are there by then. Whether the bricks that the ball touches agree could be
    /// asked before, but to find and ask these takes more instructions than the masks do with AVX2.
    void find_uniform_points() {
        for (QueryPoint& point : points()) {
            point.is_uniform = true;
            for (std::size_t t = 0; t < lights().tile_count() && point.is_uniform; ++t)
                point.is_uniform =
                    bricks_agree(mesh_, point.neighbours.entries(), t, block_.reaching(point, t));
        }
    }

    /// The linked short test: seeds by rays in batches, the next one of each point that did not see its last.
    void find_linked_neighbours() {
        mesh_ = filler_.data().view();
        std::array<QueryPoint*, most_segments> waiting;
        std::size_t waiting_count = 0;
        for (QueryPoint& point : points()) {
            point.seeds = {grid(), point.grid_pos, point.position, point.normal};
            waiting[waiting_count++] = &point;
        }
        while (waiting_count != 0) {
            std::array<Segment, most_segments> segments;
            std::array<std::uint8_t, most_segments> hit;
            std::size_t size = 0;
            for (std::size_t k = 0; k < waiting_count; ++k) {
                QueryPoint& point = *waiting[k];
                if (point.next_seed()) {
                    segments[size] = {surface_end_of(point, grid()), grid().position(point.seed)};
                    waiting[size++] = &point;
                }
            }
            trace(filler_.tracer(), std::span<const Segment>(segments).first(size),
                  std::span(hit).first(size));
            if (statistics_ != nullptr)
                statistics_->short_rays += size;
            waiting_count = 0;
            for (std::size_t k = 0; k < size; ++k) {
                QueryPoint& point = *waiting[k];
                if (hit[k] != 0 || !(point.is_uniform || link_to_seed(point)))
                    waiting[waiting_count++] = &point;
            }
        }
    }

    /// As `link_reached`.
    bool link_to_seed(QueryPoint& point) {
        // What was looked up in other windows is gone.
        if (!block_.is_in_window(point))
            return detail::link_to_seed(filler_, mesh_, point);
        if (!flood_.is_of(point.seed, point.window)) {
            const std::uint32_t flood = filler_.flood_of(mesh_, *point.seed_entry->brick, point.seed);
            flood_.unpack(FloodView(&mesh_.words[flood - 1]), point.seed, grid().quality(), block_.window(),
                          point.window);
        }
        return link_reached(point, [this](const BrickPoints& entry) { return flood_.in_slot(entry.slot); });
    }

    /// Lists the units that the block lacks, finds and stores them.
    void resolve() {
        missing_.clear();
        for (std::size_t t = 0; t < lights().tile_count(); ++t) {
            std::uint32_t groups_before = 0;
            for (const QueryPoint& point : points()) {
                const std::uint32_t groups = point.is_uniform ? 0 : cell_bits(block_.reaching(point, t));
                const bool is_checked = point.differs_little && (groups & ~groups_before) == 0;
                groups_before = groups;
                if (groups == 0)
                    continue;
                if (is_checked) {
                    for (const BrickChange& change : block_.changes_of(point))
                        need(*change.brick, t, change.added, groups);
                } else {
                    for (const BrickPoints& entry : point.neighbours.entries())
                        need(*entry.brick, t, entry.points, groups);
                }
            }
        }
        find_missing();
        mesh_ = filler_.data().view();
    }

    void find_missing() {
        if (missing_.entries().empty())
            return;
        if (listed_ == nullptr) {
            filler_.fill(missing_);
            return;
        }
        for (const MissingUnits& missing : missing_.entries())
            listed_->add({missing.brick->position(), missing.tile}, missing.units);
    }

    void need(const Brick& brick, std::size_t tile, std::uint64_t points, std::uint32_t groups) {
        const std::uint64_t missing = mesh_.missing(brick, tile, cells_in(points) & (groups * every_byte));
        if (missing == 0 || missing_.add(brick, tile, missing)) [[likely]]
            return;
        find_missing();
        missing_.clear();
        missing_.add(brick, tile, missing);
    }

    /// Adds up what differs from the point before. Returns whether all of it is known.
    bool add_changes(Tally& tally, const QueryPoint& point, std::uint32_t groups) const {
        for (const BrickChange& change : block_.changes_of(point)) {
            tally.add(*change.brick, change.added, groups);
            tally.remove(*change.brick, change.removed);
        }
        return tally.knows_all();
    }
    /// Adds up all neighbours anew. Returns whether all that is needed of them is known.
    static bool add_all(Tally& tally, const QueryPoint& point, std::uint32_t groups) {
        tally.start_anew();
        for (const BrickPoints& entry : point.neighbours.entries())
            tally.add(*entry.brick, entry.points, groups);
        return tally.knows_all();
    }

    /// Equation (3) for all points. Where long tests turn out to be missing, those of the whole block are
    /// found first; beside these nothing is traced but the shadow rays of points without neighbours.
    void count() {
        for (const QueryPoint& point : points())
            if (rows_.begins_with_zeros(point))
                rows_.fill(point, 0.0f);
        for (std::size_t t = 0; t < lights().tile_count(); ++t) {
            Tally tally(mesh_, kernels_, t);
            std::uint32_t counted_groups = 0;
            const QueryPoint* counted = nullptr;
            for (QueryPoint& point : points()) {
                const std::uint64_t lit = block_.reaching(point, t);
                const std::uint32_t groups = cell_bits(lit);
                if (groups == 0) {
                    rows_.give(point, t, nullptr);
                    continue;
                }
                if (point.neighbours.point_count() == 0) {
                    trace_shadow_rays(point, t, lit);
                    continue;
                }
                if (point.is_uniform) {
                    give_uniform(point, t, lit);
                    continue;
                }
                const bool is_near =
                    point.differs_little && counted == &point - 1 && (groups & ~counted_groups) == 0;
                if (!(is_near ? add_changes(tally, point, groups) : add_all(tally, point, groups))) {
                    resolve();
                    tally.forget();
                    add_all(tally, point, groups);
                }
                tally.finish();
                counted = &point;
                counted_groups = groups;
                divide(point, t, tally, lit);
            }
        }
        for (const QueryPoint& point : points())
            if (point.neighbours.point_count() == 0)
                note_empty();
    }

    /// All neighbours agree about each light: what one of them sees.
    void give_uniform(const QueryPoint& point, std::size_t tile, std::uint64_t lit) {
        lit = mesh_.sees_uniform(*point.neighbours.entries().front().brick, tile, lit);
        std::array<float, lights_per_tile> values;
        for (std::size_t l = 0; l < lights_per_tile; ++l)
            values[l] = static_cast<float>(lit >> l & 1);
        rows_.give(point, tile, values.data());
    }

    void divide(QueryPoint& point, std::size_t tile, const Tally& tally, std::uint64_t lit) {
        alignas(64) std::array<float, lights_per_tile> values;
        float* const whole = rows_.whole_tile_of(point, tile);
        point.lights_agree &= kernels_.divide(tally.counts(), point.neighbours.point_count(), lit,
                                              whole != nullptr ? whole : values.data());
        if (whole == nullptr && !awaits_rays(point))
            rows_.give(point, tile, values.data());
    }

    /// True where exact short tests come first, since nothing that is blended into a row can be taken back.
    bool awaits_rays(const QueryPoint& point) const {
        return short_test() == ShortTest::exact && point.share != 1.0f && !point.is_tested;
    }

    /// The short test of equation (2) by rays, where it can change the result.
    void test_all_neighbours() {
        for (QueryPoint& point : points()) {
            if (point.neighbours.point_count() == 0)
                continue;
            // If each light is seen by all neighbours or by none, it does not matter which of them P sees.
            const bool is_right =
                point.lights_agree && sees_any_neighbour(filler_.tracer(), mesh_, point, statistics_);
            if (is_right && !awaits_rays(point))
                continue;
            point.is_tested = true;
            if (!is_right)
                test_neighbours(filler_.tracer(), mesh_, point, statistics_);
            if (point.neighbours.point_count() == 0)
                note_empty();
            for (std::size_t t = 0; t < lights().tile_count(); ++t) {
                const std::uint64_t lit = block_.reaching(point, t);
                if (lit == 0)
                    continue;
                if (point.neighbours.point_count() == 0) {
                    trace_shadow_rays(point, t, lit);
                    continue;
                }
                Tally tally(mesh_, kernels_, t);
                add_all(tally, point, 0);
                tally.finish();
                divide(point, t, tally, lit);
            }
        }
    }

    void note_empty() {
        if (statistics_ != nullptr)
            ++statistics_->empty_points;
    }

    /// The case m = 0 of equation (3).
    void trace_shadow_rays(const QueryPoint& point, std::size_t tile, std::uint64_t lit) {
        std::array<float, lights_per_tile> values{};
        for (std::uint64_t rest = lit; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const std::size_t light = lights().order().light_at(tile * lights_per_tile + l);
            values[l] =
                filler_.tracer().occluded(lights().shadow_segment(light, surface_end_of(point, grid())))
                    ? 0.0f
                    : 1.0f;
            if (statistics_ != nullptr)
                ++statistics_->shadow_rays;
        }
        rows_.give(point, tile, values.data());
    }

    const Filler& filler_;
    MeshView mesh_;
    const Kernels& kernels_;
    PointBlock block_;
    ResultRows rows_;
    WindowFlood flood_;
    QueryStatistics* statistics_;
    UnitTable* listed_ = nullptr;  ///< null: what is missing is found
    MissingList missing_;
};

}  // namespace lightmesh::detail
