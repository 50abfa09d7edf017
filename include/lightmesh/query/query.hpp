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
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/kernels/kernel_types.hpp>
#include <lightmesh/query/kernels/kernels.hpp>
#include <lightmesh/query/neighbours.hpp>
#include <lightmesh/query/query_point.hpp>
#include <lightmesh/query/reaching.hpp>
#include <lightmesh/query/short_test.hpp>
#include <lightmesh/query/tally.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/atomics.hpp>
#include <lightmesh/support/popcount.hpp>
#include <lightmesh/support/room_for.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
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
        : filler_(filler), mesh_(filler.data().view()), kernels_(kernels()), window_(grid()),
          statistics_(statistics) {}

    /// As `LightMesh::visibility` for many points; `all` holds all their rows.
    void run(const PointBatch& batch, std::span<float> all) {
        all_ = all;
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

    /// Lists the links that are missing where floods of the seeds before these points can lead, but for those
    /// behind the surface, one bit a cell.
    void list_links(const PointBatch& batch, UnitTable& cells) {
        for (std::size_t done = 0; done < batch.size() && short_test() == ShortTest::linked;) {
            done += start_block(batch, done);
            find_uniform_points();
            for (const QueryPoint& point : points())
                if (!point.is_uniform)
                    list_links_before(point, cells);
        }
    }

private:
    static constexpr std::size_t most_points = most_segments;
    static constexpr std::size_t most_entries = 2048;
    static constexpr std::size_t most_cached_tiles = 16;
    static constexpr std::size_t most_changes_of_point = 24;

    const LightTable& lights() const { return *mesh_.lights; }
    const Grid& grid() const { return *mesh_.grid; }
    ShortTest short_test() const { return mesh_.settings->short_test; }
    std::span<QueryPoint> points() { return {points_.data(), point_count_}; }

    std::span<float> row(const QueryPoint& point) const {
        return all_.subspan(point.row * lights().size(), lights().size());
    }

    void fill_row(const QueryPoint& point, float value) const {
        if (!all_.empty())
            std::ranges::fill(row(point), value);
    }

    std::uint64_t reaching(const QueryPoint& point, std::size_t tile) const {
        if (tile < most_cached_tiles)
            return reaching_[static_cast<std::size_t>(&point - points_.data())][tile];
        return find_reaching(lights(), kernels_, tile, point.position, point.normal);
    }

    /// Takes a block of points as `start_block` does, and finds all that counting them needs but long tests.
    std::size_t prepare_block(const PointBatch& batch, std::size_t first) {
        const std::size_t taken = start_block(batch, first);
        if (short_test() == ShortTest::linked) {
            find_uniform_points();
            find_linked_neighbours();
        }
        find_all_changes();
        return taken;
    }

    /// Takes as many points as there is room for, from `first` on, and finds their hemispheres. Returns how
    /// many; those whose result needs no neighbours are done: it is the same on all levels.
    std::size_t start_block(const PointBatch& batch, std::size_t first) {
        const std::size_t room = Hemisphere::largest_box(grid().quality());
        std::size_t entry_count = 0;
        std::size_t next = first;
        point_count_ = 0;
        for (; next < batch.size() && point_count_ < most_points; ++next) {
            if (entry_count + room > most_entries)
                break;
            QueryPoint& point = points_.make(point_count_, batch.positions[next], batch.normals[next]);
            point.row = batch.rows.empty() ? next : batch.rows[next];
            point.share = batch.shares.empty() ? 1.0f : batch.shares[next];
            if (!is_finite(batch.positions[next]) || !is_finite(batch.normals[next])) {
                fill_row(point, std::numeric_limits<float>::quiet_NaN());
                continue;
            }
            point.grid_pos = grid().locate(point.position);
            if (!find_reaching_lights(point)) {
                fill_row(point, 0.0f);
                continue;
            }
            entry_count += find_neighbours(point, &entries_[entry_count]);
            if (short_test() == ShortTest::linked)
                point.seeds = {grid(), point.grid_pos, point.position, point.normal};
            ++point_count_;
        }
        return next - first;
    }

    /// True if any light reaches the point.
    bool find_reaching_lights(const QueryPoint& point) {
        std::uint64_t any = 0;
        auto& cached = reaching_[static_cast<std::size_t>(&point - points_.data())];
        for (std::size_t t = 0; t < lights().tile_count(); ++t) {
            const std::uint64_t lit = find_reaching(lights(), kernels_, t, point.position, point.normal);
            if (t < most_cached_tiles)
                cached[t] = lit;
            any |= lit;
            if (t >= most_cached_tiles && any != 0)
                break;
        }
        return any != 0;
    }

    std::size_t find_neighbours(QueryPoint& point, BrickPoints* entries) {
        const Hemisphere hemisphere(grid(), point.grid_pos, point.position, point.normal);
        BrickMask masks[hemisphere_capacity];
        const std::size_t size = kernels_.find_masks(hemisphere, masks);
        if (!window_.cover(hemisphere.first_brick, hemisphere.bricks))
            ++window_count_;
        point.window = window_count_;
        const std::uint32_t first_slot = window_.slot_of(hemisphere.first_brick);
        int point_count = 0;
        for (std::size_t i = 0; i < size; ++i) {
            const std::uint32_t slot = first_slot + window_.slots_to(masks[i]);
            const Brick*& brick = window_.brick_in(slot);
            if (brick == nullptr) [[unlikely]]
                brick = filler_.use_brick(mesh_, hemisphere.first_brick +
                                                     glm::ivec3(masks[i].x, masks[i].y, masks[i].z));
            entries[i] = {brick, masks[i].points, slot, 0};
            point_count += popcount(masks[i].points);
        }
        point.neighbours = Neighbours(entries, size, point_count);
        return size;
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
                point.is_uniform = bricks_agree(mesh_, point.neighbours.entries(), t, reaching(point, t));
        }
    }

    /// The linked short test: seeds by rays in batches, the next one of each point that did not see its last.
    void find_linked_neighbours() {
        mesh_ = filler_.data().view();
        std::array<std::uint8_t, most_points> waiting;
        std::size_t waiting_count = 0;
        for (std::size_t i = 0; i < point_count_; ++i)
            waiting[waiting_count++] = static_cast<std::uint8_t>(i);
        while (waiting_count != 0) {
            std::array<Segment, most_points> segments;
            std::array<std::uint8_t, most_points> hit;
            std::size_t size = 0;
            for (std::size_t k = 0; k < waiting_count; ++k) {
                QueryPoint& point = points_[waiting[k]];
                if (point.next_seed()) {
                    segments[size] = {surface_end_of(point, grid()), grid().position(point.seed)};
                    waiting[size++] = waiting[k];
                }
            }
            trace(filler_.tracer(), std::span<const Segment>(segments).first(size),
                  std::span(hit).first(size));
            if (statistics_ != nullptr)
                statistics_->short_rays += size;
            waiting_count = 0;
            for (std::size_t k = 0; k < size; ++k) {
                QueryPoint& point = points_[waiting[k]];
                if (hit[k] != 0 || !(point.is_uniform || link_to_seed(point)))
                    waiting[waiting_count++] = waiting[k];
            }
        }
    }

    /// As `link_reached`.
    bool link_to_seed(QueryPoint& point) {
        // What was looked up in other windows is gone.
        if (point.window != window_count_)
            return detail::link_to_seed(filler_, mesh_, point);
        if (!flood_.is_of(point.seed, point.window)) {
            const std::uint32_t flood = filler_.flood_of(mesh_, *point.seed_entry->brick, point.seed);
            flood_.unpack(FloodView(&mesh_.words[flood - 1]), point.seed, grid().quality(), window_,
                          point.window);
        }
        return link_reached(point, [this](const BrickPoints& entry) { return flood_.in_slot(entry.slot); });
    }

    /// For each point how its set differs from that of the point before, if that is little.
    void find_all_changes() {
        std::size_t size = 0;
        for (std::size_t i = 1; i < point_count_; ++i) {
            QueryPoint& point = points_[i];
            const QueryPoint& before = points_[i - 1];
            const std::span<const BrickPoints> old_set = before.neighbours.entries();
            const std::span<const BrickPoints> new_set = point.neighbours.entries();
            if (point.is_uniform || before.is_uniform || point.window != before.window || old_set.empty() ||
                new_set.empty() || old_set.size() + new_set.size() > 4 * most_changes_of_point)
                continue;
            const std::size_t found = find_changes(old_set, new_set, &changes_[size]);
            int changed_points = 0;
            for (std::size_t c = 0; c < found; ++c)
                changed_points += popcount(changes_[size + c].added) + popcount(changes_[size + c].removed);
            if (found > most_changes_of_point || 2 * changed_points > point.neighbours.point_count())
                continue;
            point.differs_little = true;
            point.first_change = static_cast<std::uint32_t>(size);
            point.change_count = static_cast<std::uint32_t>(found);
            size += found;
        }
    }

    std::span<const BrickChange> changes_of(const QueryPoint& point) const {
        return std::span(changes_).subspan(point.first_change, point.change_count);
    }

    /// Lists the units that the block lacks, finds and stores them.
    void resolve() {
        missing_.clear();
        for (std::size_t t = 0; t < lights().tile_count(); ++t) {
            std::uint32_t groups_before = 0;
            for (const QueryPoint& point : points()) {
                const std::uint32_t groups = point.is_uniform ? 0 : cell_bits(reaching(point, t));
                const bool is_checked = point.differs_little && (groups & ~groups_before) == 0;
                groups_before = groups;
                if (groups == 0)
                    continue;
                if (is_checked) {
                    for (const BrickChange& change : changes_of(point))
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

    void list_links_before(const QueryPoint& point, UnitTable& cells) const {
        // A cell's middle is half a step from its light points along each axis, a seed within a step of P, or
        // little more.
        const double reach = static_cast<double>(FloodBox::radius(grid().quality())) + 2.0;
        const glm::dvec3 normal(point.normal);
        const auto side_of = [](double coordinate) {
            return floor_to_int(coordinate / brick_side);
        };
        const glm::dvec3 low = point.grid_pos - reach;
        const glm::dvec3 high = point.grid_pos + reach;
        for (int z = side_of(low.z); z <= side_of(high.z); ++z)
            for (int y = side_of(low.y); y <= side_of(high.y); ++y)
                for (int x = side_of(low.x); x <= side_of(high.x); ++x) {
                    const glm::ivec3 coord(x, y, z);
                    std::uint32_t before = 0;
                    for (int cell = 0; cell < cells_per_brick; ++cell) {
                        const glm::dvec3 way =
                            glm::dvec3(grid_pos_of(coord, 8 * cell)) + 0.5 - point.grid_pos;
                        if (glm::dot(way, way) < reach * reach && glm::dot(normal, way) > -1.5)
                            before |= 1u << cell;
                    }
                    if (const Brick* brick = before != 0 ? mesh_.find_brick(coord) : nullptr)
                        before &= ~std::uint32_t{load_acquire(brick->links_known)};
                    if (before != 0)
                        cells.add({coord, 0}, before);
                }
    }

    /// Adds up what differs from the point before. Returns whether all of it is known.
    bool add_changes(Tally& tally, const QueryPoint& point, std::uint32_t groups) const {
        for (const BrickChange& change : changes_of(point)) {
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
            if (begins_with_zeros(point))
                fill_row(point, 0.0f);
        for (std::size_t t = 0; t < lights().tile_count(); ++t) {
            Tally tally(mesh_, kernels_, t);
            std::uint32_t counted_groups = 0;
            const QueryPoint* counted = nullptr;
            for (QueryPoint& point : points()) {
                const std::uint64_t lit = reaching(point, t);
                const std::uint32_t groups = cell_bits(lit);
                if (groups == 0) {
                    give(point, t, nullptr);
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
        give(point, tile, values.data());
    }

    void divide(QueryPoint& point, std::size_t tile, const Tally& tally, std::uint64_t lit) {
        alignas(64) std::array<float, lights_per_tile> values;
        float* const place = whole_tile_of(point, tile);
        point.lights_agree &= kernels_.divide(tally.counts(), point.neighbours.point_count(), lit,
                                              place != nullptr ? place : values.data());
        if (place == nullptr && !awaits_rays(point))
            give(point, tile, values.data());
    }

    /// The place where the values of a tile's 64 slots stand side by side in the point's row; null if they do
    /// not.
    float* whole_tile_of(const QueryPoint& point, std::size_t tile) const {
        const bool is_whole = point.share == 1.0f && lights().order().is_given() &&
                              (tile + 1) * lights_per_tile <= lights().size();
        return is_whole ? row(point).data() + tile * lights_per_tile : nullptr;
    }

    /// True where exact short tests come first, since nothing that is blended into a row can be taken back.
    bool awaits_rays(const QueryPoint& point) const {
        return short_test() == ShortTest::exact && point.share != 1.0f && !point.is_tested;
    }

    /// Whether all of a point's row is set to 0 at once, before its tiles are given: where the values of a
    /// tile stand apart in it, one by one would take longer, and of thousands of lights with ranges few tiles
    /// reach.
    bool begins_with_zeros(const QueryPoint& point) const {
        return point.share == 1.0f && !lights().order().is_given();
    }

    /// Writes the values of a tile to the point's row; null: all 0.
    void give(const QueryPoint& point, std::size_t tile, const float* values) {
        const std::span<float> result = row(point);
        const std::size_t first = tile * lights_per_tile;
        const auto size = static_cast<std::size_t>(lights().tile_size(tile));
        if (point.share != 1.0f) {
            for (std::size_t l = 0; l < size; ++l) {
                float& value = result[lights().order().light_at(first + l)];
                value = blended(value, values != nullptr ? values[l] : 0.0f, point.share);
            }
            return;
        }
        if (lights().order().is_given()) {
            if (values != nullptr)
                std::copy_n(values, size, result.data() + first);
            else
                std::fill_n(result.data() + first, size, 0.0f);
            return;
        }
        if (values == nullptr)
            return;
        for (std::size_t l = 0; l < size; ++l)
            result[lights().order().light_at(first + l)] = values[l];
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
                const std::uint64_t lit = reaching(point, t);
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
        give(point, tile, values.data());
    }

    static constexpr std::size_t hemisphere_capacity =
        Hemisphere::max_bricks_per_axis * Hemisphere::max_bricks_per_axis * Hemisphere::max_bricks_per_axis;

    const Filler& filler_;
    MeshView mesh_;
    const Kernels& kernels_;
    BrickWindow window_;
    WindowFlood flood_;
    QueryStatistics* statistics_;
    UnitTable* listed_ = nullptr;  ///< null: what is missing is found
    std::span<float> all_;
    std::size_t point_count_ = 0;
    std::uint32_t window_count_ = 0;  ///< of all blocks, so that `flood_` is of one window only
    MissingList missing_;
    RoomFor<QueryPoint, most_points> points_;
    std::array<std::array<std::uint64_t, most_cached_tiles>, most_points> reaching_;
    std::array<BrickPoints, most_entries> entries_;
    std::array<BrickChange, (most_points + 4) * most_changes_of_point> changes_;
};

/// S of one light at one point, as `LightMesh::visibility`.
template <class Filler>
float query_one(const Filler& filler, const glm::vec3& position, const glm::vec3& normal, std::size_t light,
                QueryStatistics* statistics) {
    if (!is_finite(position) || !is_finite(normal))
        return std::numeric_limits<float>::quiet_NaN();
    MeshView mesh = filler.data().view();
    QueryPoint point(position, normal);
    point.grid_pos = mesh.grid->locate(position);
    if (!mesh.lights->can_light(light, position, point.normal))
        return 0.0f;

    const Hemisphere hemisphere(*mesh.grid, point.grid_pos, point.position, point.normal);
    constexpr std::size_t capacity =
        Hemisphere::max_bricks_per_axis * Hemisphere::max_bricks_per_axis * Hemisphere::max_bricks_per_axis;
    BrickMask masks[capacity];
    BrickPoints entries[capacity];
    const std::size_t size = kernels().find_masks(hemisphere, masks);
    for (std::size_t i = 0; i < size; ++i) {
        const glm::ivec3 coord = hemisphere.first_brick + glm::ivec3(masks[i].x, masks[i].y, masks[i].z);
        entries[i] = {filler.use_brick(mesh, coord), masks[i].points, 0, 0};
    }
    point.neighbours = Neighbours(entries, size);
    mesh = filler.data().view();
    const ShortTest short_test = mesh.settings->short_test;
    const std::size_t slot = mesh.lights->order().slot_of(light);
    const std::size_t tile = slot / lights_per_tile;
    const std::uint64_t bit = std::uint64_t{1} << (slot % lights_per_tile);
    const std::uint64_t group = every_byte << (slot % lights_per_tile / lights_per_group);
    if (short_test == ShortTest::linked) {
        point.is_uniform = bricks_agree(mesh, point.neighbours.entries(), tile, bit);
        point.seeds = {*mesh.grid, point.grid_pos, point.position, point.normal};
        while (point.next_seed()) {
            if (statistics != nullptr)
                ++statistics->short_rays;
            const Segment ray{surface_end_of(point, *mesh.grid), mesh.grid->position(point.seed)};
            if (!filler.tracer().occluded(ray) && (point.is_uniform || link_to_seed(filler, mesh, point)))
                break;
        }
    }

    if (point.is_uniform && point.neighbours.point_count() != 0)
        return mesh.sees_uniform(*point.neighbours.entries().front().brick, tile, bit) ? 1.0f : 0.0f;
    MissingList missing;
    for (const BrickPoints& entry : point.neighbours.entries()) {
        const std::uint64_t units = mesh.missing(*entry.brick, tile, cells_in(entry.points) & group);
        if (units != 0 && !missing.add(*entry.brick, tile, units)) {
            filler.fill(missing);
            missing.clear();
            missing.add(*entry.brick, tile, units);
        }
    }
    if (!missing.entries().empty()) {
        filler.fill(missing);
        mesh = filler.data().view();
    }
    const auto lit = [&] {
        return count_lit(mesh, point.neighbours.entries(), tile, slot % lights_per_tile);
    };
    if (short_test == ShortTest::exact && point.neighbours.point_count() != 0) {
        const int seen = lit();
        if ((seen == 0 || seen == point.neighbours.point_count()) &&
            sees_any_neighbour(filler.tracer(), mesh, point, statistics))
            return seen == 0 ? 0.0f : 1.0f;
        test_neighbours(filler.tracer(), mesh, point, statistics);
    }
    if (point.neighbours.point_count() != 0)
        return static_cast<float>(lit()) / static_cast<float>(point.neighbours.point_count());
    if (statistics != nullptr) {
        ++statistics->empty_points;
        ++statistics->shadow_rays;
    }
    const Segment ray = mesh.lights->shadow_segment(light, surface_end_of(point, *mesh.grid));
    return filler.tracer().occluded(ray) ? 0.0f : 1.0f;
}

}  // namespace lightmesh::detail
