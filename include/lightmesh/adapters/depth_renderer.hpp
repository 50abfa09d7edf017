// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/depth_view.hpp>
#include <lightmesh/bounds.hpp>

#include <concepts>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

/// The second, optional part of the contract between a light mesh and its user's program: pictures from the
/// lights.

namespace lightmesh {

/// The user's rasteriser: how far does a light see?
///
///     void render_depth(const DepthView& view, std::span<float> distance);
///
/// Sets distance[row * view.resolution + column], row 0 on top, for all view.resolution^2 texels: the
/// distance in world units from view.eye to the first surface that is seen through the middle of the texel,
/// along the ray and not along the view's axis; for an orthographic view the distance from the plane through
/// view.eye, along view.forward. +infinity where nothing is hit. `DepthView` says how a rasteriser or a ray
/// tracer gets there.
///
/// Called when a light point first needs the picture, on the thread of that query, and by one thread at a
/// time, under a lock: it need not be const. All else waits meanwhile, so it may use threads of its own; but
/// it must not query a mesh that uses it, nor may its thread do so while it waits for others: a task that it
/// takes over could be such a query, and would wait for itself (with oneTBB: `this_task_arena::isolate`).
/// Each picture is asked for once. An exception leaves the query; NaN or a negative distance becomes one
/// (std::runtime_error) that names the texel. Nothing of a failed picture is kept: the next query that needs
/// it asks again.
///
/// The renderer is moved into the mesh, or copied if that is how it is handed over. The scene must outlive
/// the mesh and must not change under it.
template <class T>
concept DepthRenderer = std::move_constructible<T> &&
    requires(T& renderer, const DepthView& view, std::span<float> distance) {
    { renderer.render_depth(view, distance) } -> std::same_as<void>;
};

/// Optional, and found by itself: several pictures at once, all of the same resolution, for renderers that
/// gain by it.
///
///     void render_depth(std::span<const DepthView> views, std::span<const std::span<float>> distances);
///
/// Both spans have the same size, at least 1; distances[i] belongs to views[i].
template <class T>
concept BatchDepthRenderer = DepthRenderer<T> &&
    requires(T& renderer, std::span<const DepthView> views, std::span<const std::span<float>> distances) {
    renderer.render_depth(views, distances);
};

/// Optional, and found by itself: the box around everything that throws shadows.
///
///     Bounds bounds() const;
///
/// Maps of directional lights need it, unless the box is given by settings. Asked for once, when the map is
/// made.
template <class T>
concept BoundedDepthRenderer = DepthRenderer<T> && requires(const T& renderer) {
    { renderer.bounds() } -> std::convertible_to<Bounds>;
};

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

}  // namespace lightmesh
