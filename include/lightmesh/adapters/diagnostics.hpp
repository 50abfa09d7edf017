// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/depth_view.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/segment.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

/// Each way in which an adapter can fail to fit the concepts of `concepts.hpp`, with its sentence: who writes
/// an adapter need not read this.

namespace lightmesh {

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

namespace detail {

template <class T, class View, class Distances>
concept RenderDepthCallable = requires(T& renderer, View view, Distances distances) {
    renderer.render_depth(view, distances);
};

template <class T>
concept RendersFloats = RenderDepthCallable<T, const DepthView&, std::span<float>>;

/// Ways to get the second parameter wrong.
template <class T>
concept RendersOtherNumbers = RenderDepthCallable<T, const DepthView&, std::span<double>> ||
                              RenderDepthCallable<T, const DepthView&, float*> || RenderDepthCallable < T,
        const DepthView&, std::vector<float>
& > || RenderDepthCallable<T, const DepthView&, std::span<const float>>;

template <class T>
concept RendersChangedView = RenderDepthCallable<T, DepthView&, std::span<float>>;

template <class T>
concept RendersBatches =
    RenderDepthCallable<T, std::span<const DepthView>, std::span<const std::span<float>>>;

/// A `render_depth` for many views that is there but does not fit would be left out unseen.
template <class T>
concept MisspeltRenderBatch =
    !RendersBatches<T> && (RenderDepthCallable<T, std::span<DepthView>, std::span<std::span<float>>> ||
                           RenderDepthCallable<T, std::span<const DepthView>, std::span<std::span<float>>> ||
                           RenderDepthCallable<T, std::span<DepthView>, std::span<const std::span<float>>> ||
                           RenderDepthCallable<T, std::span<const DepthView>, std::span<float>>);

template <class T>
concept BoundsCallable = requires(T& renderer) {
    renderer.bounds();
};

template <class T>
concept BoundsFitting = requires(const T& renderer) {
    { renderer.bounds() } -> std::convertible_to<Bounds>;
};

}  // namespace detail

/// Says in one sentence what is wrong with an adapter:
/// `static_assert(lightmesh::check_depth_renderer<MyRasteriser>());`. Whatever takes a `DepthRenderer` calls
/// it for its own. Does not compile, or returns true.
template <class T>
consteval bool check_depth_renderer() {
    static_assert(
        std::is_class_v<T>,
        "lightmesh: the DepthRenderer must be a class with a member `void render_depth(const DepthView&, "
        "std::span<float>)`");
    if constexpr (std::is_class_v<T>) {
        constexpr bool callable = detail::RendersFloats<T>;
        constexpr bool changes_view = !callable && detail::RendersChangedView<T>;
        constexpr bool other_numbers = !callable && !changes_view && detail::RendersOtherNumbers<T>;
        static_assert(std::move_constructible<T>,
                      "lightmesh: the DepthRenderer must be movable or copyable: the library keeps it");
        static_assert(!changes_view,
                      "lightmesh: the DepthRenderer's render_depth must take its view as `const DepthView&`");
        static_assert(
            !other_numbers,
            "lightmesh: the DepthRenderer's render_depth must take its distances as `std::span<float>`");
        static_assert(callable || changes_view || other_numbers,
                      "lightmesh: the DepthRenderer lacks the member `void render_depth(const DepthView&, "
                      "std::span<float>)`");
        if constexpr (callable) {
            static_assert(
                std::is_void_v<decltype(std::declval<T&>().render_depth(std::declval<const DepthView&>(),
                                                                        std::declval<std::span<float>>()))>,
                "lightmesh: the DepthRenderer's render_depth must return void: it reports failure by an "
                "exception");
        }
        static_assert(!detail::MisspeltRenderBatch<T>,
                      "lightmesh: the DepthRenderer's render_depth for many views must be `void render_depth("
                      "std::span<const DepthView>, std::span<const std::span<float>>)`");
        static_assert(!detail::BoundsCallable<T> || detail::BoundsFitting<T>,
                      "lightmesh: the DepthRenderer's bounds must be `lightmesh::Bounds bounds() const`");
    }
    return true;
}

namespace detail {

template <class T>
concept CountCallable = requires(T& source) {
    source.triangle_count();
};
template <class T>
concept CountFitting = requires(const T& source) {
    { source.triangle_count() } -> std::convertible_to<std::size_t>;
};
template <class T>
concept TriangleCallable = requires(T& source, std::size_t i) {
    source.triangle(i);
};
template <class T>
concept TriangleConst = requires(const T& source, std::size_t i) {
    source.triangle(i);
};
template <class T>
concept TriangleFitting = requires(T& source, std::size_t i) {
    { source.triangle(i) } -> std::convertible_to<std::array<glm::vec3, 3>>;
};

}  // namespace detail

/// Says in one sentence what is wrong with an adapter:
/// `static_assert(lightmesh::check_occluders<MyTriangles>());`. Whatever takes `Occluders` calls it for its
/// own. Does not compile, or returns true.
template <class T>
consteval bool check_occluders() {
    static_assert(
        std::is_class_v<T>,
        "lightmesh: the Occluders must be a class with the members `std::size_t triangle_count() const` and "
        "`std::array<glm::vec3, 3> triangle(std::size_t) const`");
    if constexpr (std::is_class_v<T>) {
        static_assert(detail::CountCallable<T>,
                      "lightmesh: the Occluders lack the member `std::size_t triangle_count() const`");
        static_assert(!detail::CountCallable<T> || detail::CountFitting<T>,
                      "lightmesh: the Occluders' triangle_count must be const and return std::size_t");
        static_assert(detail::TriangleCallable<T>, "lightmesh: the Occluders lack the member "
                                                   "`std::array<glm::vec3, 3> triangle(std::size_t) const`");
        static_assert(!detail::TriangleCallable<T> || detail::TriangleConst<T>,
                      "lightmesh: the Occluders' triangle must be const");
        static_assert(!detail::TriangleCallable<T> || detail::TriangleFitting<T>,
                      "lightmesh: the Occluders' triangle must return std::array<glm::vec3, 3>");
    }
    return true;
}

}  // namespace lightmesh
