// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/diagnostics.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/fill/link_fill.hpp>
#include <lightmesh/fill/link_list.hpp>
#include <lightmesh/fill/long_test_list.hpp>
#include <lightmesh/fill/mesh_levels.hpp>
#include <lightmesh/fill/source.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/free_slots.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/merge.hpp>
#include <lightmesh/mesh/scene_change.hpp>
#include <lightmesh/mesh/snapshot_reader.hpp>
#include <lightmesh/mesh/snapshot_writer.hpp>
#include <lightmesh/query/block_query.hpp>
#include <lightmesh/query/level_query.hpp>
#include <lightmesh/query/point_query.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/check_light.hpp>
#include <lightmesh/surface_point.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace lightmesh {

/// Soft shadows from many lights: equations (1) to (3) of the light mesh method (Debelov, Sevastyanov,
/// Novikov, Vasilyeva, "Ray Tracing Based on Interpolation of Visibility of Point Light Sources", Springer
/// SCI 441, 2013).
///
/// A mesh starts empty and fills itself as it is queried. All queries are const and may be called from any
/// number of threads at once; their results do not depend on the number of threads or on the order of
/// queries. A query on a filled mesh allocates nothing; one that is the first to touch some part of space may
/// add memory to the mesh (and throw std::bad_alloc).
///
/// Lights and the scene behind the adapters may change between queries, if the mesh is told: `set_light`,
/// `add_light`, `remove_light`, `scene_changed`. These are exclusive calls: nothing else may use the mesh
/// meanwhile. They trace nothing; afterwards queries give what a new mesh would, and trace again only what
/// they touch of what was forgotten.
///
/// In a query, `point` is a surface point P in world units, and `normal` the geometric normal there, on the
/// side that is shaded; its length does not matter. A point or normal that is not finite gives NaN. A zero
/// normal has no hemisphere: the result is the exact shadow ray of the case m = 0, with chi = 1. A finite
/// point whose light points have no index (farther than 2^24 steps of the level that serves it from the
/// origin) throws std::out_of_range.
///
/// Where pixels are wide, a fine grid would need many light points for each. So a `SurfacePoint` is served by
/// the finest of the grids of radius 2^k r, and as many light points per radius, whose step is wider than
/// `Settings::footprint_scale` of its footprints. In the last fifth of an octave of footprints the values of
/// two such levels are blended, so that nothing jumps where they change. There are 25 levels, or as many as
/// have a radius up to 1e18; wider footprints, also infinite ones, are served by the last. What is asked
/// without a footprint (or with one that is 0, negative or NaN) is served by level 0, the grid of radius r.
/// Shadow maps and volumes are shared by all levels: what hides a light must be as far from it as level 0
/// asks.
template <class Tracer, class Source = Rays>
class LightMesh {
    static_assert(check_intersector<Tracer>());

public:
    /// Copies adapter and lights. Any number of lights, also none. Throws std::invalid_argument that names
    /// the value for settings out of range and lights that are not finite.
    LightMesh(Tracer tracer, std::span<const Light> lights,
              const Settings& settings) requires std::same_as<Source, Rays>
        : levels_(std::make_unique<Levels>(std::move(tracer), lights, settings)) {}

    /// The same with long tests by something else than rays. `source` is either a `DepthRenderer`, for shadow
    /// maps (LMM+ATK): nothing is rendered before a query needs it. Throws std::invalid_argument also for a
    /// map size out of range, and for a directional light if nobody knows the scene's bounds. Or `source` is
    /// `Occluders`, for shadow volumes (LMM+ATO): S as with rays but within rounding of a shadow's edge;
    /// settings and bounds of shadow maps play no part; it is kept, and read anew by `scene_changed`. Throws
    /// what `OccluderTriangles` throws, which names a triangle that is not finite.
    LightMesh(Tracer tracer, Source source, std::span<const Light> lights,
              const Settings& settings) requires(!std::same_as<Source, Rays>)
        : levels_(std::make_unique<Levels>(std::move(tracer), lights, settings, std::move(source), lights,
                                           settings)) {}

    /// What does not fit the above says so in one sentence.
    template <class Lights>
    LightMesh(Tracer, const Lights&, const Settings&) requires(!detail::LightRange<Lights>) {
        detail::check_light_range<Lights>();
    }
    /// As above.
    template <class Other, class Lights>
    LightMesh(Tracer, Other, const Lights&, const Settings&) requires std::same_as<Source, Rays> {
        static_assert(
            !std::same_as<Source, Rays>,
            "lightmesh: `LightMesh<Tracer>` finds long tests by rays, and with an adapter for them write "
            "`LightMesh<Tracer, Source>`, or no arguments of the template at all");
    }

    /// Number of lights: the columns of a query's result.
    std::size_t light_count() const { return data().lights().size(); }
    /// As they were passed in; one that was removed is a `PointLight` of range 0.
    std::span<const Light> lights() const { return data().user_lights(); }
    /// The mesh's copy of the adapter.
    const Tracer& tracer() const { return levels_->tracer(); }
    /// The grid of the light points of level 0.
    const Grid& grid() const { return data().grid(); }
    /// As they were passed in.
    const Settings& settings() const { return data().settings(); }
    /// The source of V(L, x).
    LongTest long_test() const {
        constexpr LongTest kind = Levels::LongTestsType::kind;
        return kind == LongTest::shadow_maps && settings().refine_shadow_maps ? LongTest::refined_shadow_maps
                                                                              : kind;
    }

    /// S_i(P) of equation (3) for one light: how lit the point is, 0 in shadow to 1 lit. Throws
    /// std::out_of_range for a light that is not there. `statistics`, if given, has this query's cost added.
    float visibility(const glm::vec3& point, const glm::vec3& normal, std::size_t light,
                     QueryStatistics* statistics = nullptr) const {
        check_light_exists(light);
        count_points(statistics, 1);
        return detail::query_one(levels_->finest(), point, normal, light, statistics);
    }

    /// S_i(P) of every light, in one pass over the neighbours: much cheaper than light by light, and the same
    /// values. Throws std::invalid_argument if `all` does not have exactly `light_count()` places.
    void visibility(const glm::vec3& point, const glm::vec3& normal, std::span<float> all,
                    QueryStatistics* statistics = nullptr) const {
        visibility({&point, 1}, {&normal, 1}, all, statistics);
    }

    /// S_i(P) of every light for many points, which share the rays' batches: the same values, faster for
    /// points near to each other (a tile of pixels). `all` is row-major, a row of `light_count()` for each
    /// point. Throws std::invalid_argument unless there are as many normals and rows as points.
    void visibility(std::span<const glm::vec3> points, std::span<const glm::vec3> normals,
                    std::span<float> all, QueryStatistics* statistics = nullptr) const {
        detail::require_size("normals", normals.size(), points.size());
        detail::require_size("visibilities", all.size(), points.size() * light_count());
        count_points(statistics, points.size());
        detail::BlockQuery(levels_->finest(), statistics).run({points, normals}, all);
    }

    /// The same for a point that carries more than P and n: of that a light mesh uses the footprint.
    float visibility(const SurfacePoint& point, std::size_t light,
                     QueryStatistics* statistics = nullptr) const {
        check_light_exists(light);
        count_points(statistics, 1);
        return detail::query_one(*levels_, point, light, statistics);
    }
    /// As above.
    void visibility(const SurfacePoint& point, std::span<float> all,
                    QueryStatistics* statistics = nullptr) const {
        visibility({&point, 1}, all, statistics);
    }
    /// As above. Points of one level share what neighbours share, whatever lies between them in the list.
    void visibility(std::span<const SurfacePoint> points, std::span<float> all,
                    QueryStatistics* statistics = nullptr) const {
        detail::require_size("visibilities", all.size(), points.size() * light_count());
        count_points(statistics, points.size());
        Query query(*levels_, statistics);
        for (std::size_t first = 0; first < points.size(); first += Query::most_points) {
            const std::span<const SurfacePoint> block = block_of(points, first);
            query.run(block, all.subspan(first * light_count(), block.size() * light_count()));
        }
    }

    /// Finds and stores ahead of queries what they will need at these points: then they are as fast as on a
    /// filled mesh. From time to time progress(done, total), in points, is called; if it returns false,
    /// filling ends there. Returns whether it went to the end. May be called from any number of threads, for
    /// parts of the points each.
    template <class Progress>
    bool fill(std::span<const SurfacePoint> points, Progress&& progress) const {
        Query query(*levels_, nullptr);
        for (std::size_t first = 0; first < points.size(); first += Query::most_points) {
            const std::span<const SurfacePoint> block = block_of(points, first);
            query.fill(block);
            if (!static_cast<bool>(progress(first + block.size(), points.size())))
                return false;
        }
        return true;
    }
    /// The same without progress.
    void fill(std::span<const SurfacePoint> points) const {
        fill(points, [](std::size_t, std::size_t) { return true; });
    }

    /// Lists the long tests that queries at these points will need and that the mesh lacks, for a tracer that
    /// takes very many of them at once, such as one on a GPU:
    ///
    ///     LongTestList missing;
    ///     mesh.list_long_tests(points, missing);
    ///     mesh.fill(missing, [&](std::span<const LongTestWord> words, std::span<std::uint64_t> seen) {
    ///         ...
    ///     });
    ///
    /// What else they will need, links that are not there yet, is found by the mesh's own tracer and stored.
    /// May be called from any number of threads, for parts of the points each, with a list each. Throws
    /// std::out_of_range as queries do.
    void list_long_tests(std::span<const SurfacePoint> points,
                         LongTestList& list) const requires std::same_as<Source, Rays> {
        Query query(*levels_, nullptr);
        for (std::size_t first = 0; first < points.size(); first += Query::most_points)
            query.list(block_of(points, first), list.units_.levels);
    }
    /// Finds and stores what is listed by the caller's tracer, in calls as large as `LongTestTracer` says:
    /// with adaptive long tests first all samples, then what these have not told. The mesh then holds what
    /// `fill` by its own tracer would have found. May be called beside queries. Throws what the tracer
    /// throws; of the bricks that it was asked about nothing is stored then.
    template <LongTestTracer Trace>
    void fill(const LongTestList& list, Trace&& trace) const requires std::same_as<Source, Rays> {
        for (std::size_t k = 0; k < list.units_.levels.size(); ++k)
            if (!list.units_.levels[k].entries().empty())
                levels_->level(static_cast<int>(k))
                    .fill(list.units_.levels[k].entries(), static_cast<std::uint32_t>(k), trace);
    }
    /// Lists the links between light points that queries at these points may need and that the mesh lacks,
    /// for a tracer that takes very many at once: nearly all that they will need, and some that they will
    /// not. To be filled before `list_long_tests`. Nothing unless the short test is `ShortTest::linked`.
    /// Threads and errors as there.
    void list_links(std::span<const SurfacePoint> points, LinkList& list) const {
        Query query(*levels_, nullptr);
        for (std::size_t first = 0; first < points.size(); first += Query::most_points)
            query.list_links(block_of(points, first), list.units_.levels);
    }
    /// Finds and stores what is listed by the caller's tracer, in calls as large as `LinkTracer` says; it
    /// changes no value of a query. May be called beside queries. Throws what the tracer throws.
    template <LinkTracer Trace>
    void fill_links(const LinkList& list, Trace&& trace) const {
        for (std::size_t k = 0; k < list.units_.levels.size(); ++k)
            if (!list.units_.levels[k].entries().empty())
                levels_->level(static_cast<int>(k))
                    .fill_links(list.units_.levels[k].entries(), static_cast<std::uint32_t>(k), trace);
    }
    /// The segment of a link: from light point p of a word's brick one step up along axis 0, 1 or 2, world
    /// units.
    Segment link_segment(const LinkWord& word, int p, int axis) const {
        return detail::link_segment(levels_->level(word.level).data().grid(),
                                    {word.brick[0], word.brick[1], word.brick[2]}, p, axis);
    }
    /// The segment of a long test: from light point p of a word to its light, or from there to the point
    /// (see `Intersector`), world units.
    Segment long_segment(const LongTestWord& word, int p) const {
        const detail::MeshData& of_level = levels_->level(static_cast<int>(word.level)).data();
        const glm::ivec3 brick(word.brick[0], word.brick[1], word.brick[2]);
        return of_level.lights().long_segment(word.light,
                                              of_level.grid().position(detail::grid_pos_of(brick, p)));
    }

    /// All that the mesh knows, as one block of bytes that can be saved, sent, merged into another mesh, and
    /// read in place by a `SnapshotView`. Meshes that know the same have the same bytes. Lights stand there
    /// in groups of eight: where one of a group was forgotten by an update and is not found again yet, the
    /// bytes lack the others with it. May be taken while other threads query. Throws std::bad_alloc.
    std::vector<std::byte> snapshot() const { return detail::write_snapshot(*levels_, long_test()); }

    /// Adds what a snapshot knows and this mesh lacks, level by level: of a mesh with the same radius,
    /// quality, origin and kind of long tests, adaptive or not, of the same scene. Its
    /// `Settings::footprint_scale` may be another one. Lights belong together by their numbers; those
    /// that differ contribute nothing, nor does anything that may have to do with the boxes in `changed`,
    /// where the scene is another one than it was for the snapshot. `bytes` must begin at a multiple of 16.
    ///
    /// Everything is checked before the mesh is touched: throws std::invalid_argument that says what is wrong
    /// with the bytes, or that more than 1 in 1,000 bits that both know differ. Where fewer differ, as with
    /// another processor's tracer, the mesh keeps its own. An exclusive call: nothing else may use the mesh
    /// meanwhile.
    void merge(std::span<const std::byte> bytes, std::span<const Bounds> changed = {}) {
        const detail::SnapshotReader from(bytes);
        detail::Merge(*levels_, from, long_test(), changed).run();
    }

    /// Puts another light in the place of light i: what was found of the old one is forgotten, and nothing
    /// else; of one that differs in size only nothing is. An exclusive call. Throws std::out_of_range for a
    /// light that is not there, and what the constructor throws for one that is not right; nothing has
    /// changed then.
    void set_light(std::size_t i, const Light& light) {
        check_light_exists(i);
        levels_->set_light(i, light);
        free_.take(i);
    }
    /// Adds a light and returns its number: the lowest that a removed light has left, else one more than the
    /// last, for which all that is known is copied to memory without gaps: of the other lights nothing is
    /// found again. An exclusive call. Throws as above.
    std::size_t add_light(const Light& light) {
        if (!free_.is_empty()) {
            const std::size_t i = free_.lowest();
            set_light(i, light);
            return i;
        }
        levels_ = levels_->with_light(light);
        return light_count() - 1;
    }
    /// Light i is out: S = 0 from now on. The other lights keep their numbers. An exclusive call. Throws
    /// std::out_of_range for a light that is not there, or was removed before.
    void remove_light(std::size_t i) {
        check_light_exists(i);
        free_.add(i);
        try {
            levels_->set_light(i, detail::no_light());
        } catch (...) {
            free_.take(i);
            throw;
        }
    }

    /// Says that the scene behind the adapters has changed, but nowhere outside of these boxes: where
    /// surfaces were and where they are now. All that may have to do with them is forgotten: visibilities of
    /// lights behind them, links, floods, pictures that show them. `Occluders` are read anew, and a depth
    /// renderer's bounds. An exclusive call. Throws std::invalid_argument that names a box whose corners are
    /// not finite or in the wrong order, and what reading `Occluders` throws; nothing has changed then.
    void scene_changed(std::span<const Bounds> boxes) {
        detail::check_changed(boxes);
        levels_->forget(boxes);
    }
    /// As above.
    void scene_changed(const Bounds& box) { scene_changed({&box, 1}); }

    /// Says that a new frame begins: what queries use from now on is newer than what they used before. If the
    /// mesh holds more than `Settings::memory_budget`, what has gone unused for the longest time is
    /// forgotten, so much that three quarters of that are left, but nothing that the frame before has used;
    /// what is asked for again is found again. An exclusive call. Throws std::bad_alloc; nothing has changed
    /// then.
    void begin_frame() {
        const std::size_t bytes = levels_->bytes();
        if (bytes > settings().memory_budget) {
            const double share =
                0.75 * static_cast<double>(settings().memory_budget) / static_cast<double>(bytes);
            const detail::FrameAges ages = levels_->ages();
            if (const int frames = ages.most_of(share); ages.has_older(frames))
                levels_ = std::make_unique<Levels>(*levels_, lights(), frames);
        }
        levels_->next_frame();
    }

    /// Copies what the mesh knows to memory without gaps, and gives back what updates have left behind: both
    /// are there for a moment. Then the mesh knows what its snapshots know: of eight lights of which one was
    /// forgotten and is not found again yet, the others are found again with it. An exclusive call. Throws
    /// std::bad_alloc; nothing has changed then.
    void compact() { levels_ = std::make_unique<Levels>(*levels_, lights(), 0xffff, false); }

    /// The contents of the mesh by now. Walks over all of it.
    MeshStatistics statistics() const { return levels_->statistics(); }

private:
    using Levels = detail::MeshLevels<Tracer, typename detail::LongTestsOf<Source>::Type>;
    using Query = detail::LevelQuery<Levels>;

    const detail::MeshData& data() const { return levels_->finest().data(); }

    static std::span<const SurfacePoint> block_of(std::span<const SurfacePoint> points, std::size_t first) {
        return points.subspan(first, (std::min)(Query::most_points, points.size() - first));
    }

    static void count_points(QueryStatistics* statistics, std::size_t count) {
        if (statistics != nullptr)
            statistics->points += count;
    }

    void check_light_exists(std::size_t light) const {
        if (light >= light_count())
            throw std::out_of_range("lightmesh: there is no light " + std::to_string(light) +
                                    "; the mesh has " + std::to_string(light_count()));
    }

    std::unique_ptr<Levels> levels_;
    detail::FreeSlots free_;
};

/// Which kernels queries use on this processor, chosen when the first query runs: "AVX-512", "AVX2" or
/// "portable".
inline const char* kernel_name() {
    return detail::kernels().name;
}

/// Long tests by rays, lights from any contiguous range.
template <class Tracer, class Lights>
LightMesh(Tracer, const Lights&, Settings) -> LightMesh<Tracer>;

/// Long tests by a `DepthRenderer` or by `Occluders`, whichever the source is.
template <class Tracer, class Source, class Lights>
LightMesh(Tracer, Source, const Lights&, Settings) -> LightMesh<Tracer, Source>;

}  // namespace lightmesh
