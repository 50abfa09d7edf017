// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <doctest/doctest.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>
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
    /// How many allocations `try_once` makes: each of them fails once.
    const auto failures_of = [](auto&& try_once) {
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
    };
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

TEST_CASE("a warm query of a visibility cache allocates nothing") {
    test::Random random(32);
    const auto scene = test::boxes_on_floor(random, 3);
    const auto lights = test::random_lights(random, 80);
    auto points = test::surface_points(random, scene, 20);
    points.push_back({{0, 0, 0}, {0, 0, 0}});
    std::vector<float> all(lights.size());
    const lightmesh::VisibilityCache cache{test::PlainTracer{&scene}, lights,
                                           lightmesh::CacheSettings{.spacing = 0.3f, .detail = 2}};
    const auto allocations_of_a_pass = [&] {
        const std::size_t before = allocations.load();
        for (const test::SurfacePoint& p : points)
            cache.visibility(p.position, p.normal, std::span<float>{all});
        return allocations.load() - before;
    };
    CHECK(allocations_of_a_pass() > 0);
    CHECK(allocations_of_a_pass() == 0);
}

#endif
