// SPDX-License-Identifier: MIT
#include "hit_tracer.hpp"
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/bounds.hpp>
#include <lightmesh/cache/lamp_ray_list.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/surface_point.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <doctest/doctest.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <span>
#include <utility>
#include <vector>

// A query on a filled mesh allocates nothing. This file replaces the global operator new of its program,
// which clang's ThreadSanitizer does not allow.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define LIGHTMESH_TEST_CANNOT_REPLACE_NEW
#endif
#endif
#if !defined(LIGHTMESH_TEST_CANNOT_REPLACE_NEW)

namespace {

std::atomic<std::size_t> allocations{0};
/// The number of the allocation that fails.
std::atomic<std::size_t> failing{0};

bool next_one_fails() noexcept {
    return allocations.fetch_add(1, std::memory_order_relaxed) + 1 == failing.load(std::memory_order_relaxed);
}

void* counted(std::size_t size) noexcept {
    if (next_one_fails())
        return nullptr;
    return std::malloc(size > 0 ? size : 1);
}

void* counted(std::size_t size, std::align_val_t alignment) noexcept {
    if (next_one_fails())
        return nullptr;
    const auto line = static_cast<std::size_t>(alignment);
    return std::aligned_alloc(line, (size + line - 1) / line * line);
}

void* or_throw(void* memory) {
    if (memory == nullptr)
        throw std::bad_alloc();
    return memory;
}

}  // namespace

// All forms, so that none of a sanitizer's own comes in beside them.
#if defined(__GNUC__) && !defined(__clang__)
// Where it inlines some of these and not others, g++ takes their pairs for a mistake.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
#endif
// clang-format off
void* operator new(std::size_t size) { return or_throw(counted(size)); }
void* operator new[](std::size_t size) { return or_throw(counted(size)); }
void* operator new(std::size_t size, std::align_val_t line) { return or_throw(counted(size, line)); }
void* operator new[](std::size_t size, std::align_val_t line) { return or_throw(counted(size, line)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return counted(size); }
void* operator new(std::size_t size, std::align_val_t line, const std::nothrow_t&) noexcept { return counted(size, line); }
void* operator new[](std::size_t size, std::align_val_t line, const std::nothrow_t&) noexcept { return counted(size, line); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t, const std::nothrow_t&) noexcept { std::free(memory); }
// clang-format on

namespace {

/// How many allocations `try_once` makes: each of them fails once.
std::size_t failures_of(auto&& try_once) {
    std::size_t failures = 0;
    for (bool has_failed = true; has_failed; failures += has_failed ? 1 : 0) {
        has_failed = false;
        failing = allocations.load() + failures + 1;
        try {
            try_once();
        } catch (const std::bad_alloc&) {
            has_failed = true;
        }
        failing = 0;
    }
    return failures;
}

std::size_t allocations_of_a_pass(const auto& mesh, const std::vector<test::SurfacePoint>& points,
                                  std::vector<float>& all) {
    const std::size_t before = allocations.load();
    float sum = 0.0f;
    for (const test::SurfacePoint& p : points) {
        mesh.visibility(p.position, p.normal, std::span<float>{all});
        sum += mesh.visibility(p.position, p.normal, std::size_t{0});
        lightmesh::QueryStatistics statistics;
        mesh.visibility(p.position, p.normal, std::span<float>{all}, &statistics);
    }
    const std::size_t made = allocations.load() - before;
    CHECK(sum >= 0.0f);
    return made;
}

}  // namespace

TEST_CASE("a warm query allocates nothing") {
    test::Random random(31);
    const auto scene = test::boxes_on_floor(random, 3);
    const auto lights = test::random_lights(random, 80);
    auto points = test::surface_points(random, scene, 20);
    points.push_back({{0, 0, 0}, {0, 0, 0}});  // m = 0
    std::vector<float> all(lights.size());
    for (const lightmesh::ShortTest short_test : test::all_short_tests) {
        for (const float quality : {2.0f, 7.0f}) {
            lightmesh::Settings settings;
            settings.radius = 0.7f;
            settings.quality = quality;
            settings.short_test = short_test;
            const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights, settings};
            CHECK(allocations_of_a_pass(mesh, points, all) > 0);  // Cold: the counter works.
            CHECK(allocations_of_a_pass(mesh, points, all) == 0);
        }
    }
}

TEST_CASE("a warm query of points with mixed footprints allocates nothing") {
    test::Random random(33);
    const auto scene = test::boxes_on_floor(random, 3);
    const auto lights = test::random_lights(random, 80);
    std::vector<lightmesh::SurfacePoint> points;
    for (const test::SurfacePoint& p : test::surface_points(random, scene, 60))
        points.push_back({.position = p.position,
                          .normal = p.normal,
                          .footprint = static_cast<float>(random.uniform(0.0, 2.0))});
    std::vector<float> all(points.size() * lights.size());
    for (const lightmesh::ShortTest short_test : test::all_short_tests) {
        const lightmesh::LightMesh mesh{
            test::PlainTracer{&scene}, lights,
            lightmesh::Settings{.radius = 0.7f, .quality = 2.0f, .short_test = short_test}};
        const auto allocations_of_a_pass = [&] {
            const std::size_t before = allocations.load();
            mesh.visibility(points, all);
            mesh.visibility(points[0], std::span(all).first(lights.size()));
            mesh.visibility(points[1], std::size_t{1});
            mesh.fill(points);
            return allocations.load() - before;
        };
        CHECK(allocations_of_a_pass() > 0);
        CHECK(allocations_of_a_pass() == 0);
    }
}

TEST_CASE("an allocation that fails while a level is made loses and changes nothing") {
    test::Random random(34);
    const auto scene = test::boxes_on_floor(random, 2);
    const auto lights = test::random_lights(random, 9);
    const lightmesh::Settings settings{.radius = 0.4f, .quality = 2.0f};
    const lightmesh::SurfacePoint point{
        .position = {0.3f, 0.2f, -3.0f}, .normal = {0.0f, 0.0f, 1.0f}, .footprint = 1.5f};
    std::vector<float> expected(lights.size());
    lightmesh::LightMesh{test::PlainTracer{&scene}, lights, settings}.visibility(point, expected);
    std::size_t failures = 0;
    for (bool has_failed = true; has_failed; failures += has_failed ? 1 : 0) {
        const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights, settings};
        std::vector<float> all(lights.size());
        has_failed = false;
        failing = allocations.load() + failures + 1;
        try {
            mesh.visibility(point, all);
        } catch (const std::bad_alloc&) {
            has_failed = true;
        }
        failing = 0;
        if (has_failed)
            mesh.visibility(point, all);
        CHECK(all == expected);
    }
    CHECK(failures > 5);
}

TEST_CASE("an allocation that fails while a snapshot is taken or merged loses and changes nothing") {
    test::Random random(35);
    const auto scene = test::boxes_on_floor(random, 2);
    const auto lights = test::random_lights(random, 70);
    const lightmesh::Settings settings{.radius = 0.7f, .quality = 2.0f};
    std::vector<float> all(lights.size());
    const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights, settings};
    const auto points = test::surface_points(random, scene, 5);
    for (const test::SurfacePoint& p : points)
        mesh.visibility(p.position, p.normal, all);
    const std::vector<std::byte> expected = mesh.snapshot();
    /// Lets one allocation fail, if `try_once` makes so many.
    const auto fails_at = [](std::size_t allocation, auto&& try_once) {
        failing = allocations.load() + allocation;
        try {
            try_once();
        } catch (const std::bad_alloc&) {
        }
        failing = 0;
    };
    std::vector<std::byte> taken;
    CHECK(failures_of([&] { taken = mesh.snapshot(); }) > 1);
    CHECK(taken == expected);
    // One mesh meets all failures, one after the other.
    lightmesh::LightMesh restored{test::PlainTracer{&scene}, lights, settings};
    const std::vector<std::byte> nothing = restored.snapshot();
    const std::size_t failures = failures_of([&] {
        try {
            restored.merge(expected);
        } catch (const std::bad_alloc&) {
            failing = 0;
            CHECK(restored.snapshot() == nothing);
            throw;
        }
    });
    CHECK(failures > 5);
    CHECK(restored.snapshot() == expected);
    // So does one whose first query ran out of memory before.
    const lightmesh::LightMesh fresh{test::PlainTracer{&scene}, lights, settings};
    const glm::vec3 point = points.front().position;
    const glm::vec3 normal = points.front().normal;
    fresh.visibility(point, normal, all);
    std::vector<float> found(lights.size());
    for (std::size_t of_query = 1; of_query < 12; ++of_query)
        for (std::size_t of_merge = 1; of_merge < 14; ++of_merge) {
            lightmesh::LightMesh touched{test::PlainTracer{&scene}, lights, settings};
            fails_at(of_query, [&] { touched.visibility(point, normal, found); });
            fails_at(of_merge, [&] { touched.merge(expected); });
            CHECK(touched.snapshot().size() >= nothing.size());
            touched.visibility(point, normal, found);
            CHECK(found == all);
        }
}

namespace {

/// Boxes under lamps of all kinds, and points of all kinds on them.
struct CacheWork {
    std::vector<test::Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<lightmesh::SurfacePoint> points;

    CacheWork(std::uint64_t seed, int light_count, int point_count) {
        test::Random random(seed);
        scene = test::boxes_on_floor(random, 3);
        lights = test::random_lights(random, light_count);
        lights.push_back(lightmesh::PointLight{.position = {0.0f, 0.0f, 4.0f}, .radius = 0.4f});
        lights.push_back(lightmesh::RectLight{
            .position = {1.0f, 0.0f, 4.0f}, .half_u = {0.0f, 1.0f, 0.0f}, .half_v = {0.6f, 0.0f, 0.1f}});
        for (const test::SurfacePoint& p : test::surface_points(random, scene, point_count)) {
            lightmesh::SurfacePoint point{.position = p.position, .normal = p.normal};
            if (points.size() % 3 == 1)
                point.footprint = static_cast<float>(random.uniform(0.0, 2.0));
            if (points.size() % 3 == 2)
                point.shading_normal = p.normal + 0.7f * glm::vec3(random.direction());
            points.push_back(point);
        }
        points.push_back({.position = {0.0f, 0.0f, 0.0f}, .normal = {0.0f, 0.0f, 0.0f}});
    }

    std::vector<float> ask(const auto& cache) const {
        std::vector<float> all(points.size() * cache.light_count());
        cache.visibility(points, all);
        return all;
    }
    /// What a new cache says.
    std::vector<float> expected(const lightmesh::CacheSettings& settings) const {
        return ask(lightmesh::VisibilityCache{test::HitTracer{&scene}, lights, settings});
    }
};

void check_warm_queries(const auto& cache, const CacheWork& work) {
    std::vector<float> all(work.points.size() * cache.light_count());
    std::vector<glm::vec3> positions, normals;
    for (const lightmesh::SurfacePoint& point : work.points) {
        positions.push_back(point.position);
        normals.push_back(point.normal);
    }
    float sum = 0.0f;
    const auto allocations_of_a_pass = [&] {
        const std::size_t before = allocations.load();
        cache.visibility(work.points, all);
        cache.visibility(positions, normals, all);
        for (const lightmesh::SurfacePoint& point : work.points) {
            cache.visibility(point, std::span(all).first(cache.light_count()));
            cache.visibility(point.position, point.normal, std::span(all).first(cache.light_count()));
            sum += cache.visibility(point, cache.light_count() - 1);
            sum += cache.visibility(point.position, point.normal, std::size_t{3});
        }
        return allocations.load() - before;
    };
    CHECK(allocations_of_a_pass() > 0);
    CHECK(allocations_of_a_pass() == 0);
    CHECK(sum >= 0.0f);
}

}  // namespace

TEST_CASE("warm queries of visibility caches allocate nothing, whatever is asked") {
    const CacheWork work(36, 70, 20);
    for (const bool is_exact : {false, true}) {
        const lightmesh::CacheSettings settings{.spacing = 0.4f, .detail = 2, .exact_edges = is_exact};
        CAPTURE(is_exact);
        check_warm_queries(lightmesh::VisibilityCache{test::PlainTracer{&work.scene}, work.lights, settings},
                           work);
        check_warm_queries(lightmesh::VisibilityCache{test::HitTracer{&work.scene}, work.lights, settings},
                           work);
    }
    lightmesh::LightMesh mesh{test::HitTracer{&work.scene}, work.lights,
                              lightmesh::Settings{.radius = 0.7f, .quality = 2.0f}};
    check_warm_queries(
        lightmesh::VisibilityCache{std::move(mesh), lightmesh::CacheSettings{.spacing = 0.4f, .detail = 2}},
        work);
}

TEST_CASE("an allocation that fails in a cold query of a visibility cache loses and changes nothing") {
    const CacheWork work(37, 20, 700);
    const lightmesh::CacheSettings settings{.spacing = 0.1f, .detail = 2, .lamp_rays = 1};
    const lightmesh::VisibilityCache calm{test::HitTracer{&work.scene}, work.lights, settings};
    const std::size_t before = allocations.load();
    const std::vector<float> expected = work.ask(calm);
    const std::size_t made = allocations.load() - before - 1;  // but for the values
    const std::vector<std::byte> known = calm.snapshot();
    std::vector<float> all(expected.size());
    CHECK(made > 2);
    // A new cache for each failure, then one that meets some of them one after the other.
    std::size_t failures = 0;
    for (std::size_t number = 1; number <= made; ++number) {
        const lightmesh::VisibilityCache cache{test::HitTracer{&work.scene}, work.lights, settings};
        failing = allocations.load() + number;
        try {
            cache.visibility(work.points, all);
        } catch (const std::bad_alloc&) {
            ++failures;
        }
        failing = 0;
        CHECK(work.ask(cache) == expected);
        CHECK(cache.snapshot() == known);
    }
    CHECK(failures == made);
    const lightmesh::VisibilityCache cache{test::HitTracer{&work.scene}, work.lights, settings};
    CHECK(failures_of([&] { cache.fill(work.points); }) > 1);
    CHECK(work.ask(cache) == expected);
    CHECK(cache.snapshot() == known);
}

TEST_CASE(
    "an allocation that fails while a list is made for a visibility cache, or served, changes nothing") {
    const CacheWork work(38, 66, 3);
    const lightmesh::CacheSettings settings{.spacing = 0.5f, .detail = 1, .lamp_rays = 2};
    const std::vector<float> expected = work.expected(settings);
    const test::HitTracer tracer{&work.scene};
    const auto trace = [&](std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) {
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = tracer.occluded(segments[i]) ? 1 : 0;
    };
    const lightmesh::VisibilityCache cache{tracer, work.lights, settings};
    std::size_t failures = 0;
    for (int turn = 0; turn < 20; ++turn) {
        lightmesh::LampRayList list;
        failures += failures_of([&] {
            list = {};
            cache.list_lamp_rays(work.points, list);
        });
        if (list.is_empty())
            break;
        failures += failures_of([&] { cache.fill(list, trace); });
    }
    CHECK(failures > 5);
    CHECK(cache.statistics().listed_rays > 100);
    CHECK(work.ask(cache) == expected);
}

TEST_CASE("an allocation that fails while a visibility cache is saved, restored or moved changes nothing") {
    const CacheWork work(39, 66, 4);
    const lightmesh::CacheSettings settings{.spacing = 0.5f, .detail = 1, .lamp_rays = 2};
    lightmesh::VisibilityCache cache{test::HitTracer{&work.scene}, work.lights, settings};
    const std::vector<float> expected = work.ask(cache);
    const std::vector<std::byte> known = cache.snapshot();
    std::vector<std::byte> taken;
    CHECK(failures_of([&] { taken = cache.snapshot(); }) > 0);
    CHECK(taken == known);
    /// Each failure leaves what was known.
    const auto check_failures = [&](auto&& try_once) {
        const std::size_t failures = failures_of([&] {
            try {
                try_once();
            } catch (const std::bad_alloc&) {
                failing = 0;
                CHECK(cache.snapshot() == known);
                throw;
            }
        });
        CHECK(failures > 0);
        CHECK(cache.snapshot() == known);
        CHECK(work.ask(cache) == expected);
    };
    check_failures([&] { cache.compact(); });

    // A cache that holds nothing, and one that knows a part, meet all failures of a merge one after the
    // other.
    for (const std::size_t asked : {std::size_t{0}, std::size_t{2}}) {
        lightmesh::VisibilityCache restored{test::HitTracer{&work.scene}, work.lights, settings};
        restored.fill(std::span(work.points).first(asked));
        CHECK(failures_of([&] { restored.merge(known); }) > 0);
        CHECK(restored.snapshot() == known);
        CHECK(work.ask(restored) == expected);
    }
}

TEST_CASE("an allocation that fails while lights of a visibility cache change leaves values that are right") {
    CacheWork work(40, 62, 3);
    const lightmesh::CacheSettings settings{.spacing = 0.5f, .detail = 1, .lamp_rays = 2};
    lightmesh::VisibilityCache cache{test::HitTracer{&work.scene}, work.lights, settings};
    work.ask(cache);
    // Lights of the first tile, and the first one of a new tile.
    const auto check = [&](auto&& try_once) {
        failures_of([&] {
            try {
                try_once();
            } catch (const std::bad_alloc&) {
                failing = 0;
                work.lights.assign(cache.lights().begin(), cache.lights().end());
                CHECK(work.ask(cache) == work.expected(settings));
                throw;
            }
        });
        work.lights.assign(cache.lights().begin(), cache.lights().end());
        CHECK(work.ask(cache) == work.expected(settings));
    };
    check([&] { cache.set_light(3, lightmesh::PointLight{.position = {1.0f, 0.5f, 2.0f}, .radius = 0.1f}); });
    const std::size_t count = cache.light_count();
    check([&] { cache.add_light(lightmesh::PointLight{.position = {-1.0f, 0.5f, 3.0f}, .radius = 0.2f}); });
    CHECK(cache.light_count() == count + 1);
    check([&] { cache.remove_light(5); });
    check([&] { cache.add_light(lightmesh::DirectionalLight{{0.3f, 0.5f, -1.0f}, 0.05f}); });
    CHECK(cache.light_count() == count + 1);
    check([&] { cache.scene_changed(lightmesh::Bounds{{-1.0f, -1.0f, -3.0f}, {1.0f, 1.0f, 1.0f}}); });
}

#endif
