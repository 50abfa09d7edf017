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

void* counted(std::size_t size) noexcept {
    allocations.fetch_add(1, std::memory_order_relaxed);
    return std::malloc(size > 0 ? size : 1);
}

void* counted(std::size_t size, std::align_val_t alignment) noexcept {
    allocations.fetch_add(1, std::memory_order_relaxed);
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
        lightmesh::QueryStatistics spent;
        mesh.visibility(p.position, p.normal, std::span<float>{all}, &spent);
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
