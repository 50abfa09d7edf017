// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/depth_view.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/segment.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// The contract between the library and its user's program: all that the program supplies, and what it may
/// count on.
///
/// * `Intersector`: occluded(segment). Always; asked by all threads that query, at once.
/// * `BatchIntersector`: occluded(segments, hit). May be added; so too.
/// * `ClosestHitIntersector`: closest_hit(segment). May be added, for a `VisibilityCache`; so too.
/// * `DepthRenderer`: render_depth(view, distance). In place of long rays: shadow maps; by one thread at a
/// time.
/// * `BatchDepthRenderer`: render_depth(views, distances). May be added; so too.
/// * `BoundedDepthRenderer`: bounds(). May be added, maps of directional lights need bounds; for each map
/// that is made, and at `scene_changed`.
/// * `Occluders`: triangle_count(), triangle(i). In place of long rays: shadow volumes; when a mesh is made,
/// and at `scene_changed`; on the thread that calls these.
/// * `LongTestTracer` (fill/long_test_list.hpp), `LinkTracer` (fill/link_list.hpp), `SegmentTracer`
/// (fill/segment_tracer.hpp) and `ShareFinder` (fill/share_finder.hpp): callables, no adapters. Where the
/// program fills meshes and caches by rays that are traced very many at once, say on a GPU.
///
/// Members that may be added are found by themselves. One that is there but does not fit is an error at
/// compile time, with one sentence (see `diagnostics.hpp`); `check_tracer` tests at run time what no compiler
/// can.
///
/// All of them:
/// * Adapters are copied into the mesh or the cache, or moved if they are handed over so, and live as long as
///   it does: make them handles to the scene, not the scene. That holds for `Occluders`, too.
/// * What they lead to outlives the mesh. While a query, a fill or an update runs it does not change. Between
///   them it may, if the mesh or the cache is told before anything else is asked: `scene_changed`, on the
///   thread of the one who calls it, reads triangles and bounds anew, and asks for no rays and no pictures.
/// * All lengths are in world units, in the program's own coordinates.
/// * The library makes no threads of its own. What it calls runs on the thread that queries or fills.
/// * What an adapter throws leaves the query, and nothing half-made is kept: the next query asks again.

namespace lightmesh {

/// The user's ray tracer: is a segment blocked?
///
///     bool occluded(const Segment& segment) const;
///
/// Called while a query runs, on the thread that runs it: so from as many threads at once as the user queries
/// from, with no lock held. The answer depends on nothing but the segment.
///
/// * True if anything lies strictly between the two ends: both are exclusive. They are off all surfaces
///   already, so no epsilon is needed.
/// * `target - origin` is not normalised: with it as the direction, blockers count at 0 < t < 1.
/// * Links between light points are exactly axis-parallel: two components of the direction are 0, and a box
///   test must not lose them to 0 * infinity.
/// * Surfaces block from both sides: a segment that leads out of a solid is blocked as well as one that leads
///   into it, since light points may lie anywhere.
/// * A segment of length 0 is not blocked.
/// * Segments to a `DirectionalLight` are 2^24 steps of the grid long: their target is far, but finite.
///
/// How often: for long tests by rays, at most once for each light and light point that queries touch
/// (adaptive ones: 16 of a brick's 64, and the others where these disagree), and about three times for each
/// light point to link it; what threads find at the same moment may be traced by each. Then for each query
/// one short ray or some more, at most 20, and where the point sees none of some (2/3) pi q^3 neighbours by
/// those, as many more as it takes to find one that it sees (`ShortTest::linked`); none (`none`); or about
/// one for each neighbour, unless the first few decide (`exact`). And one for each light that reaches a point
/// with m = 0.
template <class T>
concept Intersector = std::copy_constructible<T> && requires(const T& tracer, const Segment& segment) {
    { tracer.occluded(segment) } -> std::same_as<bool>;
};

/// Optional: many segments at once, for tracers that are faster with packets or streams.
///
///     void occluded(std::span<const Segment> segments, std::span<std::uint8_t> hit) const;
///     static constexpr std::size_t max_batch = 256;  // optional too
///
/// Sets hit[i] to 1 if segments[i] is blocked, else to 0; both spans have the same size: 1 to 64, or to
/// `max_batch` where the adapter declares that it takes more, or less; never more than 1,024. hit[i] depends
/// on nothing but segments[i], as for one segment.
///
/// A call's segments belong together, so that packets of rays pay. Long tests: all segments are of one light,
/// from within one end's offset of each other (see `fill/ray_ends.hpp`), or nearly parallel to a sun or a far
/// lamp; their other ends are light points of some bricks of 4x4x4 beside each other, brick by brick:
/// samples, or those that are asked for; with refined shadow maps those of them that no map decides. Links
/// come in calls of 24, of one cell; exact short tests in calls that share an origin; linked ones from as
/// many points, if they are queried together; a cache's from one record to some lamps, from places around it
/// down to their surface, and from points that are queried together to lattice points near each of them. The
/// member for one segment is still called: for shadow rays, and where a query needs one answer before it can
/// ask on.
template <class T>
concept BatchIntersector = Intersector<T> &&
    requires(const T& tracer, std::span<const Segment> segments, std::span<std::uint8_t> hit) {
    tracer.occluded(segments, hit);
};

/// Optional: the first surface on a segment, for a `VisibilityCache`.
///
///     std::optional<Hit> closest_hit(const Segment& segment) const;
///
/// The surfaces are those of `occluded`: nothing if the segment is open, else the hit nearest to its origin,
/// with the geometric normal there, to either side. A cache asks once for each of its records, on the thread
/// that queries, along the axes of its lattice and over at most 5 of its steps; and, for points with a
/// `shading_normal`, towards lamps below their facet, from inside the solid. Without this member it finds the
/// place by bisection with `occluded`, to 2^-13 of 2.5 steps, and the normal from two more such places
/// beside it: about 40 segments for a record, and surfaces smaller than an eighth of a step are not told
/// apart. The two do not give the same records.
template <class T>
concept ClosestHitIntersector = Intersector<T> && requires(const T& tracer, const Segment& segment) {
    { tracer.closest_hit(segment) } -> std::same_as<std::optional<Hit>>;
};

/// The user's rasteriser, for shadow maps: how far does a light see?
///
///     void render_depth(const DepthView& view, std::span<float> distance);
///
/// Sets distance[row * view.resolution + column], row 0 on top, for all view.resolution^2 texels: the
/// distance from view.eye to the first surface that is seen through the centre of the texel, along the ray
/// and not along the view's axis; for an orthographic view the distance from the plane through view.eye,
/// along view.forward. +infinity where nothing is hit. `DepthView` says how a rasteriser or a ray tracer gets
/// there.
///
/// Called when a light point first needs the picture, on the thread of that query, and by one thread at a
/// time, under a lock: it need not be const. All else waits meanwhile, so it may use threads of its own; but
/// it must not query a mesh that uses it, nor may its thread do so while it waits for others: a task that it
/// takes over could be such a query, and would wait for itself (with oneTBB: `this_task_arena::isolate`).
/// Each picture is asked for once. NaN or a negative distance becomes an exception (std::runtime_error) that
/// names the texel.
template <class T>
concept DepthRenderer = std::move_constructible<T> &&
    requires(T& renderer, const DepthView& view, std::span<float> distance) {
    { renderer.render_depth(view, distance) } -> std::same_as<void>;
};

/// Optional: several pictures at once, all of the same resolution, for renderers that gain by it.
///
///     void render_depth(std::span<const DepthView> views, std::span<const std::span<float>> distances);
///
/// Both spans have the same size, at least 1; distances[i] belongs to views[i].
template <class T>
concept BatchDepthRenderer = DepthRenderer<T> &&
    requires(T& renderer, std::span<const DepthView> views, std::span<const std::span<float>> distances) {
    renderer.render_depth(views, distances);
};

/// Optional: the box around everything that throws shadows.
///
///     Bounds bounds() const;
///
/// Maps of directional lights need it, unless the box is given by settings. Asked for when
/// a map is made (with the mesh, by `set_light` and `add_light`) and for each map at `scene_changed`, on the
/// thread of that call.
template <class T>
concept BoundedDepthRenderer = DepthRenderer<T> && requires(const T& renderer) {
    { renderer.bounds() } -> std::convertible_to<Bounds>;
};

/// The user's triangles, for shadow volumes.
///
///     std::size_t triangle_count() const;
///     std::array<glm::vec3, 3> triangle(std::size_t i) const;
///
/// `triangle` is called with i < triangle_count(), and returns the corners in any order. A mesh keeps the
/// source, and copies its triangles: each is asked for once when the mesh is made, and once more at each
/// `scene_changed`, where there may be more or fewer; on the thread of that call. So what the source leads to
/// must outlive the mesh. `OccluderTriangles`, which may be used alone, reads them once and keeps no source.
/// A triangle of no area throws no shadow; one that is not finite is an exception that names it.
template <class T>
concept Occluders = requires(const T& source, std::size_t i) {
    { source.triangle_count() } -> std::convertible_to<std::size_t>;
    { source.triangle(i) } -> std::convertible_to<std::array<glm::vec3, 3>>;
};

}  // namespace lightmesh
