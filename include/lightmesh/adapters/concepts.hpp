// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/segment.hpp>

#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>

/// The contract between a light mesh and its user's program.
///
/// An adapter is copied into the mesh, which keeps the copy as long as it lives: make it a handle to your
/// scene, not the scene. The scene must outlive the mesh and must not change under it.

namespace lightmesh {

/// The user's ray tracer: is a segment blocked?
///
///     bool occluded(const Segment& segment) const;
///
/// Called while a query runs, on the thread that runs it: so from as many threads at once as the user queries
/// from, with no lock held. True if anything lies strictly between the two ends: both are exclusive. The ends
/// are off all surfaces already, so no epsilon is needed. `target - origin` is not normalised: with it as the
/// direction, blockers count at 0 < t < 1. Links between light points are exactly axis-parallel: two
/// components of the direction are 0, and a box test must not lose them to 0 * infinity. Surfaces block from
/// both sides: a segment that leads out of a solid is blocked as well as one that leads into it, since light
/// points may lie anywhere. A segment of length 0 is not blocked. The answer must depend on nothing but the
/// segment. An exception leaves the query through `visibility`; nothing of the interrupted work is kept.
/// `check_tracer` tests all of this at run time.
///
/// How often: for long tests by rays, at most once for each light and light point that queries touch, and
/// about three times for each light point to link it; what threads find at the same moment may be traced by
/// each. Then for each query one short ray or some more, at most 8 (`ShortTest::linked`), none (`none`), or
/// about one for each of some (2/3) pi q^3 neighbours, unless the first few decide (`exact`); and one for
/// each light that reaches a point with m = 0. Segments to a `DirectionalLight` are 2^24 steps of the grid
/// long: their target is far, but finite.
template <class T>
concept Intersector = std::copy_constructible<T> && requires(const T& tracer, const Segment& segment) {
    { tracer.occluded(segment) } -> std::same_as<bool>;
};

/// Optional, and found by itself: many segments at once, for tracers that are faster with packets or streams.
///
///     void occluded(std::span<const Segment> segments, std::span<std::uint8_t> hit) const;
///
/// Sets hit[i] to 1 if segments[i] is blocked, else to 0; both spans have the same size, 1 to 64. hit[i] must
/// depend on nothing but segments[i], as for one segment.
///
/// A call's segments belong together, so that packets of rays pay. Long tests: all segments are of one light,
/// from within one end's offset of each other (see `fill/ray_ends.hpp`), or nearly parallel to a sun or a far
/// lamp; their other ends are the light points of one brick of 4x4x4 that are asked for, cell by cell of
/// 2x2x2, with refined shadow maps those of them that no map decides. Links come in calls of 24, of one cell;
/// exact short tests in calls that share an origin; linked ones from as many points, if they are queried
/// together; a cache's from one record to some lamps. The member for one segment is still called: for shadow
/// rays, and where a query needs one answer before it can ask on.
template <class T>
concept BatchIntersector = Intersector<T> &&
    requires(const T& tracer, std::span<const Segment> segments, std::span<std::uint8_t> hit) {
    tracer.occluded(segments, hit);
};

/// Optional, and found by itself: the first surface on a segment, for a `VisibilityCache`.
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

namespace detail {

template <class T>
concept OccludedCallable = requires(T& tracer, const Segment& segment) {
    tracer.occluded(segment);
};

template <class T>
concept OccludedCallableOnLvalueSegment = requires(T& tracer, Segment& segment) {
    tracer.occluded(segment);
};

template <class T, class Segments, class Hits>
concept BatchCallable = requires(T& tracer, Segments segments, Hits hit) {
    tracer.occluded(segments, hit);
};

/// A two-argument `occluded` that is there but does not fit is a mistake, not a choice: it would be left out
/// unseen.
template <class T>
concept MisspeltBatch =
    !BatchCallable<const T, std::span<const Segment>, std::span<std::uint8_t>> &&
    (BatchCallable<T, std::span<const Segment>, std::span<std::uint8_t>> ||
     BatchCallable<T, std::span<Segment>, std::span<std::uint8_t>> ||
     BatchCallable<T, std::span<const Segment>, std::span<bool>> ||
     BatchCallable<T, std::span<const Segment>, std::span<int>> ||
     BatchCallable<T, const Segment*, std::uint8_t*> || BatchCallable<T, const Segment*, bool*>);

template <class T, class SegmentArgument>
concept ClosestHitCallable = requires(T& tracer, SegmentArgument segment) {
    tracer.closest_hit(segment);
};

/// A `closest_hit` that is there but does not fit, as above.
template <class T>
concept MisspeltClosestHit =
    !ClosestHitIntersector<T> && (ClosestHitCallable<T, const Segment&> || ClosestHitCallable<T, Segment&>);

}  // namespace detail

/// Says in one sentence what is wrong with an adapter:
/// `static_assert(lightmesh::check_intersector<MyTracer>());`. `LightMesh` calls it for its own adapter. Does
/// not compile, or returns true.
template <class T>
consteval bool check_intersector() {
    static_assert(
        std::is_class_v<T>,
        "lightmesh: the Intersector must be a class with a member `bool occluded(const Segment&) const`");
    if constexpr (std::is_class_v<T>) {
        static_assert(std::copy_constructible<T>,
                      "lightmesh: the Intersector must be copyable: the mesh keeps a copy");
        static_assert(detail::OccludedCallable<T> || !detail::OccludedCallableOnLvalueSegment<T>,
                      "lightmesh: the Intersector's occluded must take its segment as `const Segment&`");
        static_assert(detail::OccludedCallable<T> || detail::OccludedCallableOnLvalueSegment<T>,
                      "lightmesh: the Intersector lacks the member `bool occluded(const Segment&) const`");
        if constexpr (detail::OccludedCallable<T>) {
            static_assert(
                detail::OccludedCallable<const T>,
                "lightmesh: the Intersector's occluded must be const: many threads call it at once");
            static_assert(
                std::same_as<decltype(std::declval<T&>().occluded(std::declval<const Segment&>())), bool>,
                "lightmesh: the Intersector's occluded must return bool: true if the segment is blocked");
        }
        static_assert(!detail::MisspeltBatch<T>,
                      "lightmesh: the Intersector's occluded for many segments must be `void "
                      "occluded(std::span<const Segment>, std::span<std::uint8_t>) const`");
        static_assert(!detail::OccludedCallable<const T> || !detail::MisspeltClosestHit<T>,
                      "lightmesh: the Intersector's closest_hit must be `std::optional<Hit> "
                      "closest_hit(const Segment&) const`");
    }
    return true;
}

}  // namespace lightmesh
