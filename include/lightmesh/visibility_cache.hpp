// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/diagnostics.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/cache/cache_change.hpp>
#include <lightmesh/cache/lamp_ray_list.hpp>
#include <lightmesh/cache/merge.hpp>
#include <lightmesh/cache/query.hpp>
#include <lightmesh/cache/row_list_fill.hpp>
#include <lightmesh/cache/share_list_fill.hpp>
#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/cache/snapshot_reader.hpp>
#include <lightmesh/cache/snapshot_writer.hpp>
#include <lightmesh/cache/store.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/fill/segment_tracer.hpp>
#include <lightmesh/fill/share_finder.hpp>
#include <lightmesh/fill/source.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/scene_change.hpp>
#include <lightmesh/segment.hpp>
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
#include <type_traits>
#include <utility>
#include <vector>

namespace lightmesh {

template <class Tracer, class Source>
class LightMesh;

/// Penumbrae of lamps with sizes. Keeps, for places on surfaces, which share of each lamp is open, in bytes,
/// and blends four such records for a point between them. Where records differ, finer ones are made: along
/// penumbrae, down to `CacheSettings::spacing` / 2^`detail`. After Ward, Rubinstein and Clear, "A Ray Tracing
/// Solution for Diffuse Interreflection" (SIGGRAPH 1988), and Popov et al., "Adaptive Quantization Visibility
/// Caching" (Eurographics 2013).
///
///     lightmesh::VisibilityCache cache{MyTracer{scene}, lights, lightmesh::CacheSettings{.spacing = 0.1f}};
///     cache.visibility(P, normal, shares);  // a float for each light
///
/// Lamps are those of `lights.hpp`: spheres by `radius`, discs of the sky by `angular_radius`, rectangles. Of
/// a lamp of size 0 the cache keeps whether it is visible: an edge as sharp as `detail` allows. Rays end 1.15
/// radii short of a sphere's centre, at most 70 % of the way, so that a fixture does not hide its own lamp.
///
/// A cache starts empty and fills itself as it is queried, light by light. All queries are const and may be
/// called from any number of threads at once; their results depend neither on the number of threads, nor on
/// the order of queries, nor on other lights. A query for what is known allocates nothing; one that is the
/// first to touch some part of a surface may add memory (and throw std::bad_alloc). An exception of the
/// adapter leaves through the query, and nothing of the interrupted work is kept.
///
/// Lights and the scene behind the adapter may change between queries, if the cache is told: `set_light`,
/// `add_light`, `remove_light`, `scene_changed`. These are exclusive calls: nothing else may use the cache
/// meanwhile. They trace nothing; afterwards queries give what a new cache would, and trace again only what
/// they touch of what was forgotten.
///
/// In a query, a point is a surface point in world units, a normal the geometric normal there on the side
/// that is shaded; its length does not matter. A point or normal that is not finite gives NaN. A zero normal
/// gives rays from the point itself, with no chi. A finite point beyond 2^25 of the finest steps throws
/// std::out_of_range. As in equation (3), S = 0 where a light's centre is below the tangent plane, out of
/// range, or where the point is outside its cone or behind a rectangle. `SurfacePoint::shading_normal` puts
/// the smooth surface in the place of that plane.
///
/// Thousands of lights with ranges are passed 64 at a time, in the order in which they are given: those that
/// lie beside each other should stand beside each other.
template <class Tracer, class Rows = LampRows>
class VisibilityCache {
    static_assert(check_intersector<Tracer>());

public:
    /// Copies adapter and lights. Any number of lights up to 2^22, also none. Throws std::invalid_argument
    /// that names the value for settings out of range and lights that are not finite.
    VisibilityCache(Tracer tracer, std::span<const Light> lights,
                    const CacheSettings& settings) requires std::same_as<Rows, LampRows>
        : store_(std::make_unique<Store>(std::move(tracer), LampRows{}, lights, settings)) {}

    /// S of equation (3) at records on surfaces, from a light mesh, which the cache owns: the published blur
    /// without steps. `Mesh` is a `LightMesh`. Where no record serves, where `exact_edges` asks for it and
    /// where facets bend away from a lamp, rays go from the point to all of the lamp, as with lamp rows: hard
    /// where it has no size, not equation (3).
    template <class Mesh>
    VisibilityCache(Mesh mesh, const CacheSettings& settings) requires std::same_as<Rows, MeshRows<Mesh>>
        : store_(make_store(std::move(mesh), settings)) {}

    /// What does not fit the above says so in one sentence.
    template <class Lights>
    VisibilityCache(Tracer, const Lights&, const CacheSettings&) requires(!detail::LightRange<Lights>) {
        detail::check_light_range<Lights>();
    }

    /// Number of lights: the columns of a query's result.
    std::size_t light_count() const { return store_->lamps().size(); }
    /// As they were passed in; one that was removed is a `PointLight` of range 0.
    std::span<const Light> lights() const { return store_->user_lights(); }
    /// The cache's copy of the adapter.
    const Tracer& tracer() const { return store_->tracer(); }
    /// As they were passed in.
    const CacheSettings& settings() const { return store_->settings(); }
    /// The light mesh of blur rows.
    const auto& mesh() const requires(!std::same_as<Rows, LampRows>) {
        return std::as_const(*store_).rows().mesh;
    }

    /// S_i(P) for one light: the share of it that is visible, 0 to 1. Throws std::out_of_range for a light
    /// that is not there.
    float visibility(const SurfacePoint& point, std::size_t light) const {
        check_light_exists(light);
        return Query(*store_).one(point, light);
    }
    /// The same for a point of which no more is known.
    float visibility(const glm::vec3& point, const glm::vec3& normal, std::size_t light) const {
        return visibility(SurfacePoint{.position = point, .normal = normal}, light);
    }

    /// S_i(P) of every light. Throws std::invalid_argument if `all` does not have exactly `light_count()`
    /// places.
    void visibility(const SurfacePoint& point, std::span<float> all) const {
        detail::require_size("visibilities", all.size(), light_count());
        Query(*store_).all(point, all);
    }
    /// The same for a point of which no more is known.
    void visibility(const glm::vec3& point, const glm::vec3& normal, std::span<float> all) const {
        visibility(SurfacePoint{.position = point, .normal = normal}, all);
    }

    /// S_i(P) of every light for many points, which share what they find if they are near to each other (a
    /// tile of pixels): the same values, faster. `all` is row-major, a row of `light_count()` for each point.
    /// Throws std::invalid_argument unless there are as many rows, and normals, as points.
    void visibility(std::span<const SurfacePoint> points, std::span<float> all) const {
        detail::require_size("visibilities", all.size(), points.size() * light_count());
        Query(*store_).all(
            points.size(), [&](std::size_t i) { return points[i]; }, all);
    }
    /// The same for points of which no more is known.
    void visibility(std::span<const glm::vec3> points, std::span<const glm::vec3> normals,
                    std::span<float> all) const {
        detail::require_size("normals", normals.size(), points.size());
        detail::require_size("visibilities", all.size(), points.size() * light_count());
        Query(*store_).all(
            points.size(),
            [&](std::size_t i) { return SurfacePoint{.position = points[i], .normal = normals[i]}; }, all);
    }

    /// Finds and keeps ahead of queries what they will need at these points: then they are as fast as on a
    /// filled cache. From time to time progress(done, total), in points, is called; if it returns false,
    /// filling ends there. Returns whether it went to the end. May be called from any number of threads, for
    /// parts of the points each.
    template <class Progress>
    bool fill(std::span<const SurfacePoint> points, Progress&& progress) const {
        constexpr std::size_t at_once = 64;
        constexpr std::size_t block = 256;
        std::vector<float> unused(at_once * light_count());
        Query query(*store_);
        for (std::size_t done = 0; done < points.size();) {
            const std::size_t first = done;
            done = (std::min)(first + at_once, points.size());
            query.all(
                done - first, [&](std::size_t i) { return points[first + i]; }, std::span<float>(unused));
            const bool ends_block = done % block == 0 || done == points.size();
            if (ends_block && !static_cast<bool>(progress(done, points.size())))
                return false;
        }
        return true;
    }
    /// The same without progress.
    void fill(std::span<const SurfacePoint> points) const {
        fill(points, [](std::size_t, std::size_t) { return true; });
    }

    /// Lists shares of lamps that queries at these points will need and that the cache lacks, for a tracer
    /// that takes very many rays at once, such as one on a GPU: of each light those of the coarsest records
    /// that lack it. Which finer ones will be needed is known when they are there:
    ///
    ///     for (;;) {
    ///         LampRayList missing;
    ///         cache.list_lamp_rays(points, missing);
    ///         if (missing.is_empty())
    ///             break;
    ///         cache.fill(missing, [&](std::span<const Segment> segments, std::span<std::uint8_t> hit) { ...
    ///         });
    ///     }
    ///
    /// The places of records and links between them are found by the cache's own tracer and kept. What has
    /// no room in `CacheSettings::memory_budget` is not listed, nor is what takes rays from the points
    /// themselves, which no cache keeps. May be called from any number of threads, for parts of the points
    /// each, with a list each. Throws std::out_of_range as queries do.
    void list_lamp_rays(std::span<const SurfacePoint> points,
                        LampRayList& list) const requires std::same_as<Rows, LampRows> {
        Query(*store_).list(
            points.size(), [&](std::size_t i) { return points[i]; }, list.rows_);
    }
    /// Finds and keeps what is listed by the caller's tracer, some thousands of records at once: first a few
    /// rays for each share, then more of those whose rays disagree. The values are those that the cache's own
    /// tracer would have found. May be called beside queries, and from any number of threads. Throws what the
    /// tracers throw, and std::bad_alloc; of the records that are not finished nothing is kept then.
    template <SegmentTracer Trace>
    void fill(const LampRayList& list, Trace&& trace) const requires std::same_as<Rows, LampRows> {
        detail::RowListFill<Store, std::remove_reference_t<Trace>>(*store_, trace).run(list.rows_.entries());
    }

    /// The same by the caller's shaders, which make the rays, trace them and count: lamp_shares.glsl, with a
    /// tracer of the caller's. What takes rays on the CPU is only to see where records stand and what lies
    /// around them. May be called as `fill` is. Throws what the shaders and the cache's tracer throw, and
    /// std::bad_alloc; of what the shaders were at work on nothing is kept then.
    ///
    ///     cache.fill_shares(missing, [&](std::span<const std::byte> work, std::span<std::uint32_t> found) {
    ///         // write `work` to a buffer, dispatch (found.size() + 3) / 4 workgroups, read `found` back
    ///     });
    template <ShareFinder Find>
    void fill_shares(const LampRayList& list, Find&& find) const requires std::same_as<Rows, LampRows> {
        detail::ShareListFill<Store, std::remove_reference_t<Find>>(*store_, find).run(list.rows_.entries());
    }

    /// All that the cache knows, as one block of bytes that can be saved, sent, merged into another cache,
    /// and read in place by a `SnapshotView`. Caches that know the same have the same bytes. The mesh of blur
    /// rows is not part of it. May be taken while other threads query. Throws std::bad_alloc.
    std::vector<std::byte> snapshot() const {
        return detail::CacheSnapshotWriter(store_->table())
            .write(settings(), lights(), detail::hit_kind<Tracer>(), row_source());
    }

    /// Adds what a snapshot knows and this cache lacks: of a cache with the same spacing, origin,
    /// lamp_rays and shaft_rows, of the same scene; of blur rows, also with the same radius, quality, origin
    /// and short test of the mesh. Places that `closest_hit` found and places found by bisection are not
    /// mixed. Lights belong together by their numbers; those that differ contribute nothing, nor does
    /// anything that may have to do with the boxes in `changed`, where the scene is another one than it was
    /// for the snapshot. `bytes` must begin at a multiple of 16. What `CacheSettings::memory_budget` has no
    /// room for is left out.
    ///
    /// Everything is checked before the cache is touched: throws std::invalid_argument that says what is
    /// wrong with the bytes, or that more than 1 in 1,000 values that both know differ. Where fewer differ,
    /// the cache keeps its own. An exclusive call: nothing else may use the cache meanwhile.
    void merge(std::span<const std::byte> bytes, std::span<const Bounds> changed = {}) {
        const detail::CacheReader from(bytes);
        detail::CacheMerge(*store_, from, detail::hit_kind<Tracer>(), row_source(), changed).run();
    }

    /// Puts another light in the place of light i: what was found of that is forgotten, and nothing else. One
    /// that is the same costs nothing. An exclusive call. Throws std::out_of_range for a light that is not
    /// there, and std::invalid_argument that names the value for one that is not finite; nothing has changed
    /// then.
    void set_light(std::size_t i, const Light& light) {
        check_light_exists(i);
        store_->set_light(i, light);
    }
    /// Adds a light and returns its number: the lowest that a removed light has left, else one more than the
    /// last. An exclusive call. Throws as above.
    std::size_t add_light(Light light) { return store_->add_light(light); }
    /// Light i is out: S = 0 from now on. The other lights keep their numbers. An exclusive call. Throws
    /// std::out_of_range for a light that is not there, or was removed before.
    void remove_light(std::size_t i) {
        check_light_exists(i);
        store_->remove_light(i);
    }

    /// Says that the scene behind the adapter has changed, but nowhere outside of these boxes: where surfaces
    /// were and where they are now. All that may have to do with them is forgotten: records that lie there,
    /// or fell through; what others see of lamps behind them; links. An exclusive call. Throws
    /// std::invalid_argument that names a box whose corners are not finite or in the wrong order; nothing has
    /// changed then.
    /// Of blur rows also what the mesh's `scene_changed` throws.
    void scene_changed(std::span<const Bounds> boxes) {
        detail::check_changed(boxes);
        if constexpr (!std::same_as<Rows, LampRows>)
            store_->rows().mesh.scene_changed(boxes);
        store_->forget(detail::CacheChange(store_->lattice(), store_->lamps(), row_source(), boxes));
    }
    /// As above.
    void scene_changed(const Bounds& box) { scene_changed({&box, 1}); }

    /// Says that a new frame begins: what queries use from now on is newer than what they used before. If
    /// `CacheSettings::memory_budget` is taken, what has gone unused for the longest time is forgotten, so
    /// much that three quarters of it are left, but nothing that the frame before has used; what is asked for
    /// again is found again. Of blur rows the mesh does the same with its own budget. An exclusive call.
    /// Throws std::bad_alloc; nothing is lost then.
    void begin_frame() {
        if constexpr (!std::same_as<Rows, LampRows>)
            store_->rows().mesh.begin_frame();
        store_->begin_frame();
    }

    /// Copies all that the cache knows to memory without gaps, and gives back what updates have left behind:
    /// both are there for a moment. Of blur rows also what the mesh knows. An exclusive call. Throws
    /// std::bad_alloc; nothing is lost then.
    void compact() {
        if constexpr (!std::same_as<Rows, LampRows>)
            store_->rows().mesh.compact();
        store_->compact();
    }

    /// The contents of the cache by now, without its mesh.
    CacheStatistics statistics() const { return store_->statistics(); }

private:
    using Store = detail::CacheStore<Tracer, Rows>;
    using Query = detail::CacheQuery<Store>;

    detail::RowSource row_source() const {
        if constexpr (std::same_as<Rows, LampRows>)
            return {};
        else
            return {mesh().settings(), mesh().long_test()};
    }

    void check_light_exists(std::size_t light) const {
        if (light >= light_count())
            throw std::out_of_range("lightmesh: there is no light " + std::to_string(light) +
                                    "; the cache has " + std::to_string(light_count()));
    }

    template <class Mesh>
    static std::unique_ptr<Store> make_store(Mesh mesh, const CacheSettings& settings) {
        Tracer tracer = mesh.tracer();
        const std::vector<Light> lights(mesh.lights().begin(), mesh.lights().end());
        return std::make_unique<Store>(std::move(tracer), Rows{std::move(mesh)}, lights, settings);
    }

    std::unique_ptr<Store> store_;
};

/// Lamps, from any contiguous range.
template <class Tracer, class Lights>
VisibilityCache(Tracer, const Lights&, CacheSettings) -> VisibilityCache<Tracer>;

/// The blur of a light mesh.
template <class Mesh>
VisibilityCache(Mesh, CacheSettings)
    -> VisibilityCache<std::remove_cvref_t<decltype(std::declval<const Mesh&>().tracer())>, MeshRows<Mesh>>;

}  // namespace lightmesh
