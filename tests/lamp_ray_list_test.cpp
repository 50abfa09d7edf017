// SPDX-License-Identifier: MIT
#include "hit_tracer.hpp"
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

// Rays to lamps that are listed, and traced by the caller.

namespace lamp_ray_list_test {

namespace {

using lightmesh::LampRayList;
using lightmesh::Segment;
using Cache = lightmesh::VisibilityCache<test::HitTracer>;

struct Work {
    std::vector<test::Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<lightmesh::SurfacePoint> points;
    lightmesh::CacheSettings settings{.spacing = 0.5f, .detail = 2, .lamp_rays = 32};

    /// Boxes on a floor under sphere lamps, a point, a sun and a pane; some normals are smooth, some pixels
    /// wide.
    explicit Work(std::uint64_t seed, int spheres = 3) {
        test::Random random(seed);
        scene = test::boxes_on_floor(random, 5);
        for (int i = 0; i < spheres; ++i)
            lights.push_back(lightmesh::PointLight{
                .position = glm::vec3(random.in_box({-4.0, -4.0, 2.0}, {4.0, 4.0, 4.5})),
                .radius = i == 0 ? 0.0f : 0.4f});
        lights.push_back(lightmesh::DirectionalLight{{0.3f, 0.5f, -1.0f}, 0.05f});
        lights.push_back(lightmesh::RectLight{
            .position = {0.0f, 0.0f, 4.0f}, .half_u = {0.0f, 1.0f, 0.0f}, .half_v = {0.6f, 0.0f, 0.1f}});
        for (const test::SurfacePoint& p : test::surface_points(random, scene, 60)) {
            points.push_back({.position = p.position, .normal = p.normal});
            if (points.size() % 5 == 0)
                points.back().footprint = 0.3f;
            if (points.size() % 7 == 0)
                points.back().shading_normal = p.normal + glm::vec3(0.2f, 0.1f, 0.0f);
        }
    }

    Cache cache() const { return Cache{test::HitTracer{&scene}, lights, settings}; }
};

/// The caller's tracer: plain rays.
struct PlainSegments {
    const Work& work;
    std::size_t calls = 0;
    std::uint64_t rays = 0;
    std::size_t throws_in_call = (std::numeric_limits<std::size_t>::max)();

    void operator()(std::span<const Segment> segments, std::span<std::uint8_t> hit) {
        REQUIRE(segments.size() == hit.size());
        REQUIRE(!segments.empty());
        REQUIRE(segments.size() <= lightmesh::most_listed_segments);
        if (calls++ == throws_in_call)
            throw std::runtime_error("the device was lost");
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = test::PlainTracer{&work.scene}.occluded(segments[i]) ? 1 : 0;
        rays += segments.size();
    }
};

/// As threads would do it: a list for each part, put together.
LampRayList list_in_parts(const Cache& cache, std::span<const lightmesh::SurfacePoint> points) {
    LampRayList all;
    for (std::size_t first = 0; first < points.size(); first += 25) {
        LampRayList part;
        cache.list_lamp_rays(points.subspan(first, (std::min)(points.size() - first, std::size_t{25})), part);
        all.add(part);
    }
    return all;
}

/// Returns how many lists it took.
int fill_by_lists(const Cache& cache, std::span<const lightmesh::SurfacePoint> points, PlainSegments& trace) {
    for (int lists = 0;; ++lists) {
        REQUIRE(lists < 30);
        const LampRayList list = list_in_parts(cache, points);
        if (list.is_empty())
            return lists;
        cache.fill(list, trace);
    }
}

std::vector<float> ask(const Cache& cache, std::span<const lightmesh::SurfacePoint> points) {
    std::vector<float> all(points.size() * cache.light_count());
    cache.visibility(points, all);
    return all;
}

}  // namespace

TEST_CASE("lamp ray lists: what the caller traces is what the cache would have found, to the bit") {
    for (const int spheres : {3, 66}) {
        const Work work(901, spheres);
        const Cache expected = work.cache();
        expected.fill(work.points);
        const Cache cache = work.cache();
        PlainSegments trace{work};
        const int lists = fill_by_lists(cache, work.points, trace);
        CHECK(lists >= 3);
        CHECK(cache.snapshot() == expected.snapshot());
        const lightmesh::CacheStatistics held = cache.statistics();
        CHECK(held.lamp_rays == 0);
        CHECK(held.listed_rays == trace.rays);
        CHECK(held.records == expected.statistics().records);
        // The others are of points that no record serves.
        CHECK(trace.rays <= expected.statistics().lamp_rays);
        CHECK(2 * trace.rays > expected.statistics().lamp_rays);
        CHECK(static_cast<double>(trace.rays) > 500.0 * static_cast<double>(trace.calls));
        CHECK(ask(cache, work.points) == ask(expected, work.points));
    }
}

TEST_CASE("lamp ray lists: few rays a lamp, exact edges, and no closest hits") {
    Work work(902);
    work.settings.lamp_rays = 4;
    work.settings.exact_edges = true;
    const Cache expected = work.cache();
    const std::vector<float> values = ask(expected, work.points);
    const Cache cache = work.cache();
    PlainSegments trace{work};
    fill_by_lists(cache, work.points, trace);
    CHECK(ask(cache, work.points) == values);

    const lightmesh::VisibilityCache plain{test::PlainTracer{&work.scene}, work.lights, work.settings};
    const lightmesh::VisibilityCache by_lists{test::PlainTracer{&work.scene}, work.lights, work.settings};
    const std::span<const lightmesh::SurfacePoint> some = std::span(work.points).first(10);
    plain.fill(some);
    for (int lists = 0; lists < 30; ++lists) {
        LampRayList list;
        by_lists.list_lamp_rays(some, list);
        by_lists.fill(list, trace);
    }
    CHECK(by_lists.snapshot() == plain.snapshot());
}

TEST_CASE("lamp ray lists: probes are listed where there are no shaft rows") {
    Work work(906);
    work.settings.shaft_rows = false;
    const Cache expected = work.cache();
    expected.fill(work.points);
    const Cache cache = work.cache();
    PlainSegments trace{work};
    fill_by_lists(cache, work.points, trace);
    CHECK(cache.snapshot() == expected.snapshot());
    CHECK(cache.statistics().lamp_rays == 0);
    CHECK(ask(cache, work.points) == ask(expected, work.points));
}

TEST_CASE("lamp ray lists: after updates, and lists from before them") {
    const Work work(903);
    Cache cache = work.cache();
    PlainSegments trace{work};
    const LampRayList old = list_in_parts(cache, work.points);
    fill_by_lists(cache, work.points, trace);
    const std::uint64_t before = trace.rays;
    Work other = work;
    other.lights[1] = lightmesh::PointLight{.position = {0.5f, -1.0f, 3.0f}, .radius = 0.3f};
    cache.set_light(1, other.lights[1]);
    cache.fill(old, trace);
    fill_by_lists(cache, work.points, trace);
    CHECK(trace.rays - before < before / 2);
    const Cache expected = other.cache();
    CHECK(ask(cache, work.points) == ask(expected, work.points));
    cache.scene_changed({glm::vec3(-100.0f), glm::vec3(100.0f)});
    cache.fill(old, trace);
    CHECK(cache.statistics().rows == 0);
}

TEST_CASE("lamp ray lists: a tracer that throws keeps nothing half, and may go on") {
    const Work work(904);
    const Cache expected = work.cache();
    expected.fill(work.points);
    const Cache cache = work.cache();
    for (const std::size_t call : {0u, 1u, 2u, 5u}) {
        PlainSegments trace{work};
        trace.throws_in_call = call;
        CHECK_THROWS_AS(fill_by_lists(cache, work.points, trace), std::runtime_error);
    }
    PlainSegments trace{work};
    fill_by_lists(cache, work.points, trace);
    CHECK(cache.snapshot() == expected.snapshot());
}

TEST_CASE("lamp ray lists: what has no room is not listed") {
    Work work(905);
    PlainSegments trace{work};
    const Cache whole = work.cache();
    fill_by_lists(whole, work.points, trace);
    const Cache empty = work.cache();
    work.settings.memory_budget = (whole.statistics().bytes + empty.statistics().bytes) / 2;
    const Cache cache = work.cache();
    PlainSegments fewer{work};
    fill_by_lists(cache, work.points, fewer);
    CHECK(fewer.rays < trace.rays);
    CHECK(cache.statistics().listed_rays == fewer.rays);
    CHECK(ask(cache, work.points) == ask(whole, work.points));
    work.settings.memory_budget = 0;
    CHECK(list_in_parts(work.cache(), work.points).is_empty());
    work.lights.clear();
    CHECK(list_in_parts(work.cache(), work.points).is_empty());
}

}  // namespace lamp_ray_list_test
