// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/depth_renderer.hpp>
#include <lightmesh/adapters/occluders.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/scene_change.hpp>
#include <lightmesh/statistics.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightmesh {

/// In place of the second adapter of a light mesh: long tests by rays of the first.
struct Rays {};

namespace detail {

/// Members by which an adapter that does not fit shows what it was meant to be.
template <class T>
concept MeansDepthRenderer = RendersFloats<T> || RendersChangedView<T> || RendersOtherNumbers<T>;
template <class T>
concept MeansOccluders = CountCallable<T> || TriangleCallable<T>;

}  // namespace detail

/// Says in one sentence what is wrong with the second adapter of a light mesh, which is a `DepthRenderer` or
/// `Occluders`, and not both: `static_assert(lightmesh::check_long_test_source<MyAdapter>());`. `LightMesh`
/// calls it for its own. Does not compile, or returns true.
template <class T>
consteval bool check_long_test_source() {
    constexpr bool renders = detail::MeansDepthRenderer<T>;
    constexpr bool occludes = detail::MeansOccluders<T>;
    static_assert(renders || occludes,
                  "lightmesh: the adapter for long tests must be a DepthRenderer, with the member "
                  "`void render_depth(const DepthView&, std::span<float>)`, or Occluders, with the members "
                  "`std::size_t triangle_count() const` and `std::array<glm::vec3, 3> triangle(std::size_t) "
                  "const`");
    static_assert(!(renders && occludes),
                  "lightmesh: the adapter for long tests must be either a DepthRenderer, for shadow maps, or "
                  "Occluders, for shadow volumes: it has render_depth and triangles as well");
    if constexpr (renders && !occludes)
        return check_depth_renderer<T>();
    else if constexpr (occludes && !renders)
        return check_occluders<T>();
    return true;
}

namespace detail {

/// In place of the long tests of an adapter that does not fit, so that the compiler has one complaint only.
struct NoLongTests {
    static constexpr LongTest kind = LongTest::rays;

    template <class... Arguments>
    explicit NoLongTests(Arguments&&...) {}
    template <class Tracer>
    std::uint64_t operator()(const Tracer&, const LightTable&, std::size_t, std::span<const glm::vec3>,
                             LongTestCost&) const {
        return 0;
    }
    std::size_t bytes() const { return 0; }
    void count(MeshStatistics&) const {}
    void set_light(std::size_t, const Light&) {}
    void add_light(const Light&) {}
    void remove_last() {}
    LightSight sight_of(std::size_t) const { return {}; }
    struct Change {
        std::vector<bool> is_new;
    };
    Change prepare_change(std::span<const Light>) const { return {}; }
    void commit(Change&&, std::span<const Bounds>) {}
};

/// The long tests that the second adapter of a light mesh stands for. Those of shadow maps and shadow volumes
/// come with `fill/map_source.hpp` and `fill/volume_source.hpp`.
template <class Source>
struct LongTestsOf {
    static_assert(check_long_test_source<Source>());
    static_assert(
        !(MeansDepthRenderer<Source> || MeansOccluders<Source>) ||
            (MeansDepthRenderer<Source> && MeansOccluders<Source>) ||
            !(DepthRenderer<Source> || Occluders<Source>),
        "lightmesh: a mesh with shadow maps or shadow volumes needs #include <lightmesh/lightmesh.hpp>");
    using Type = NoLongTests;
};
template <>
struct LongTestsOf<Rays> {
    using Type = RayLongTests;
};

}  // namespace detail
}  // namespace lightmesh
