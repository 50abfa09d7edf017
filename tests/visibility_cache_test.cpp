// SPDX-License-Identifier: MIT
#include "hit_tracer.hpp"
#include "plain.hpp"
#include "plain_lamps.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <latch>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

namespace visibility_cache_test {

namespace {

using lightmesh::CacheSettings;
using lightmesh::Light;
using lightmesh::Segment;
using lightmesh::VisibilityCache;
using test::errors_of;
using test::HitTracer;
using test::share_of;
using test::Vec;

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

/// A direction at a right angle to another one.
Vec across_of(const Vec& direction) {
    return glm::normalize(glm::cross(direction, std::abs(direction.z) < 0.7 ? Vec(0, 0, 1) : Vec(1, 0, 0)));
}

struct Work {
    std::vector<test::Triangle> scene;
    std::vector<Light> lights;
    std::vector<test::SurfacePoint> points;
};

/// Boxes on a floor under three sphere lamps, a sun and a pane.
Work boxes(std::uint64_t seed, int points) {
    test::Random random(seed);
    Work work;
    work.scene = test::boxes_on_floor(random, 5);
    for (int i = 0; i < 3; ++i)
        work.lights.push_back(lightmesh::PointLight{
            .position = glm::vec3(random.in_box({-4.0, -4.0, 2.0}, {4.0, 4.0, 4.5})), .radius = 0.4f});
    work.lights.push_back(lightmesh::DirectionalLight{{0.3f, 0.5f, -1.0f}, 0.05f});
    work.lights.push_back(lightmesh::RectLight{
        .position = {0.0f, 0.0f, 4.0f}, .half_u = {0.0f, 1.0f, 0.0f}, .half_v = {0.6f, 0.0f, 0.1f}});
    work.points = test::surface_points(random, work.scene, points);
    return work;
}

std::vector<float> values_of(const auto& cache, const std::vector<test::SurfacePoint>& points) {
    std::vector<glm::vec3> positions, normals;
    for (const test::SurfacePoint& point : points) {
        positions.push_back(point.position);
        normals.push_back(point.normal);
    }
    std::vector<float> all(points.size() * cache.light_count());
    cache.visibility(positions, normals, all);
    return all;
}

/// A floor of 20 x 20 at z = 0.
std::vector<test::Triangle> floor_scene() {
    std::vector<test::Triangle> scene;
    test::add_quad(scene, {-10, -10, 0}, {20, 0, 0}, {0, 20, 0});
    return scene;
}

}  // namespace

TEST_CASE("visibility cache: without closest_hit records are found by bisection") {
    const Work work = boxes(24, 100);
    const CacheSettings settings{.spacing = 0.25f};
    const VisibilityCache cache{test::PlainTracer{&work.scene}, work.lights, settings};
    const test::LampErrors errors = errors_of(cache, work.scene, work.lights, work.points, 1024);
    CHECK(errors.mean < 0.0037);  // 1.3 times what was measured
    CHECK(errors.misses == 0.0);
    CHECK(cache.statistics().drop_rays > 10 * cache.statistics().records);

    // A place that is bisected is a little off, which hardly any ray to a lamp tells.
    const VisibilityCache exact{HitTracer{&work.scene}, work.lights, settings};
    const std::vector<float> bisected = values_of(cache, work.points);
    const std::vector<float> hit = values_of(exact, work.points);
    double difference = 0.0;
    for (std::size_t i = 0; i < hit.size(); ++i)
        difference += std::abs(static_cast<double>(bisected[i] - hit[i]));
    CHECK(difference / static_cast<double>(hit.size()) < 1e-5);
}

TEST_CASE(
    "visibility cache: the same bits in any order, on any number of threads, whatever the other lights") {
    Work work = boxes(5, 60);
    const CacheSettings settings{.spacing = 0.3f};
    const VisibilityCache one{HitTracer{&work.scene}, work.lights, settings};
    const std::vector<float> expected = values_of(one, work.points);
    const std::size_t lights = work.lights.size();

    const VisibilityCache many{HitTracer{&work.scene}, work.lights, settings};
    std::atomic<int> wrong{0};
    {
        std::latch start(4);
        std::vector<std::jthread> threads;
        for (std::uint64_t t = 0; t < 4; ++t)
            threads.emplace_back([&, t] {
                std::vector<std::size_t> order;
                for (std::size_t i = 0; i < work.points.size(); ++i)
                    order.push_back(i);
                test::Random random(t);
                random.shuffle(order);
                start.arrive_and_wait();
                std::vector<float> all(lights);
                for (const std::size_t i : order) {
                    many.visibility(work.points[i].position, work.points[i].normal, all);
                    if (!std::equal(all.begin(), all.end(),
                                    expected.begin() + static_cast<std::ptrdiff_t>(i * lights)))
                        ++wrong;
                }
            });
    }
    CHECK(wrong == 0);

    std::vector<Light> others;
    for (int i = 0; i < 70; ++i)
        others.push_back(lightmesh::PointLight{.position = {0.1f * static_cast<float>(i), 0.0f, 3.0f}});
    others.insert(others.end(), work.lights.begin(), work.lights.end());
    const VisibilityCache more{HitTracer{&work.scene}, others, settings};
    for (std::size_t i = work.points.size(); i-- > 0;)
        for (std::size_t l = 0; l < lights; ++l)
            CHECK(more.visibility(work.points[i].position, work.points[i].normal, 70 + l) ==
                  expected[i * lights + l]);

    const VisibilityCache forgetful{HitTracer{&work.scene}, work.lights,
                                    CacheSettings{.spacing = 0.3f, .memory_budget = 0}};
    const std::size_t few = 8;
    const std::vector<test::SurfacePoint> first(work.points.begin(), work.points.begin() + few);
    const std::vector<float> again = values_of(forgetful, first);
    CHECK(std::equal(again.begin(), again.end(), expected.begin()));
    CHECK(forgetful.statistics().records == 0);
    CHECK(one.statistics().records > 100);
}

TEST_CASE("visibility cache: more lights than a tile cost points no more rays to lattice points") {
    struct CountingTracer {
        HitTracer tracer;
        std::uint64_t* rays;

        bool occluded(const Segment& segment) const {
            ++*rays;
            return tracer.occluded(segment);
        }
        std::optional<lightmesh::Hit> closest_hit(const Segment& segment) const {
            return tracer.closest_hit(segment);
        }
    };
    Work work = boxes(6, 60);
    // More points than are looked at together.
    std::vector<test::SurfacePoint> points;
    while (points.size() < 300)
        points.insert(points.end(), work.points.begin(), work.points.end());
    const std::size_t few = work.lights.size();
    std::vector<Light> lights;
    while (lights.size() < 130)
        lights.insert(lights.end(), work.lights.begin(), work.lights.end());
    std::uint64_t rays = 0;
    const CacheSettings settings{.spacing = 0.3f};
    const VisibilityCache one{CountingTracer{{&work.scene}, &rays}, work.lights, settings};
    const VisibilityCache many{CountingTracer{{&work.scene}, &rays}, lights, settings};
    values_of(one, points);
    values_of(many, points);
    rays = 0;
    const std::vector<float> expected = values_of(one, points);
    const std::uint64_t rays_of_one = rays;
    rays = 0;
    const std::vector<float> all = values_of(many, points);
    CHECK(rays_of_one > 0);
    // Points between two facings have them again for each tile.
    CHECK(rays < 2 * rays_of_one);
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t l = 0; l < lights.size(); ++l)
            REQUIRE(all[i * lights.size() + l] == expected[i * few + l % few]);
}

TEST_CASE("visibility cache: shaft rows find the contact shadows of thin legs, in any order, on any thread") {
    std::vector<test::Triangle> scene = floor_scene();
    std::vector<test::SurfacePoint> feet;
    test::Random random(23);
    const std::vector<Light> lights{lightmesh::PointLight{.position = {0.5f, -0.3f, 4.0f}, .radius = 0.2f},
                                    lightmesh::DirectionalLight{{0.6f, 0.3f, -1.0f}, 0.02f}};
    for (int leg = 0; leg < 40; ++leg) {
        const Vec low(random.in_box({-4.0, -4.0, 0.0}, {4.0, 4.0, 0.0}));
        test::add_box(scene, low, low + Vec(0.06, 0.06, 0.7));
        // Beside it, all around.
        for (int i = 0; i < 12; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / 12.0;
            feet.push_back({.position = glm::vec3(low + Vec(0.03, 0.03, 0.0) +
                                                  0.06 * Vec(std::cos(angle), std::sin(angle), 0.0)),
                            .normal = {0.0f, 0.0f, 1.0f}});
        }
    }
    const VisibilityCache without{HitTracer{&scene}, lights,
                                  CacheSettings{.spacing = 0.25f, .shaft_rows = false}};
    const CacheSettings settings{.spacing = 0.25f};
    const VisibilityCache with{HitTracer{&scene}, lights, settings};
    int dark = 0;
    int found_without = 0;
    int found_with = 0;
    for (const test::SurfacePoint& foot : feet)
        for (std::size_t l = 0; l < lights.size(); ++l) {
            if (share_of(scene, lights[l], Vec(foot.position), Vec(foot.normal), 64, random) >= 0.2)
                continue;
            ++dark;
            found_without += without.visibility(foot.position, foot.normal, l) < 0.4f ? 1 : 0;
            found_with += with.visibility(foot.position, foot.normal, l) < 0.4f ? 1 : 0;
        }
    CAPTURE(dark);
    CAPTURE(found_without);
    CAPTURE(found_with);
    CHECK(dark > 100);
    CHECK(found_with > dark * 9 / 10);
    CHECK(found_with > found_without);
    CHECK(with.statistics().lamp_rays > without.statistics().lamp_rays);

    const VisibilityCache backwards{HitTracer{&scene}, lights, settings};
    std::atomic<int> wrong{0};
    {
        std::latch start(3);
        std::vector<std::jthread> threads;
        for (std::size_t t = 0; t < 3; ++t)
            threads.emplace_back([&, t] {
                start.arrive_and_wait();
                for (std::size_t i = feet.size(); i-- > 0;) {
                    const test::SurfacePoint& foot = feet[(i + 100 * t) % feet.size()];
                    for (std::size_t l = 0; l < lights.size(); ++l)
                        wrong += backwards.visibility(foot.position, foot.normal, l) !=
                                         with.visibility(foot.position, foot.normal, l)
                                     ? 1
                                     : 0;
                }
            });
    }
    CHECK(wrong == 0);
}

TEST_CASE("visibility cache: shaft rows take few rays to find surfaces without closest_hit") {
    std::vector<test::Triangle> scene = floor_scene();
    test::add_box(scene, {-1.0, -1.0, 0.0}, {1.0, 1.0, 1.0});
    const std::vector<Light> lights{lightmesh::PointLight{.position = {1.5f, 1.2f, 3.0f}, .radius = 0.3f}};
    const auto drops = [&](bool shaft_rows) {
        const VisibilityCache cache{test::PlainTracer{&scene}, lights,
                                    CacheSettings{.spacing = 0.25f, .detail = 1, .shaft_rows = shaft_rows}};
        test::Random random(31);
        for (int i = 0; i < 1000; ++i)
            (void)cache.visibility(glm::vec3(random.in_box({-3.0, -3.0, 0.0}, {3.0, 3.0, 0.0})),
                                   {0.0f, 0.0f, 1.0f}, 0);
        return cache.statistics().drop_rays;
    };
    const auto without = static_cast<double>(drops(false));
    const auto with = static_cast<double>(drops(true));
    CAPTURE(without);
    CAPTURE(with);
    // By bisection alone the 16 places around a record take ten times as many.
    CHECK(with < without);
}

TEST_CASE("visibility cache: shaft rows find each place around a record by one ray where nothing hides it") {
    const std::vector<test::Triangle> scene = floor_scene();
    const std::vector<Light> lights{lightmesh::PointLight{.position = {0.0f, 0.0f, 3.0f}, .radius = 0.3f}};
    const VisibilityCache cache{HitTracer{&scene}, lights, CacheSettings{.spacing = 0.5f, .detail = 0}};
    CHECK(cache.visibility({0.1f, 0.2f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0) == 1.0f);
    REQUIRE(cache.statistics().records == 4);
    CHECK(cache.statistics().drop_rays <= 16 * cache.statistics().records);
}

TEST_CASE("visibility cache: records in the air are made only where others serve less than three quarters") {
    // The columns at x = 0 meet the floor, those at x = 1 meet nothing.
    std::vector<test::Triangle> scene;
    test::add_quad(scene, {-10, -10, 0}, {10.6, 0, 0}, {0, 20, 0});
    const std::vector<Light> lights{lightmesh::PointLight{.position = {0.0f, 0.0f, 3.0f}, .radius = 0.3f}};
    const auto records_for = [&](float x) {
        const CacheSettings settings{.spacing = 1.0f, .detail = 0, .origin = glm::vec3(0.0f)};
        const VisibilityCache cache{HitTracer{&scene}, lights, settings};
        CHECK(cache.visibility({x, 0.4f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0) == 1.0f);
        return cache.statistics().records;
    };
    CHECK(records_for(0.2f) == 4);
    CHECK(records_for(0.24f) == 4);
    CHECK(records_for(0.58f) == 6);
}

TEST_CASE("visibility cache: no light leaves a closed box") {
    for (const float spacing : {0.2f, 1.0f}) {
        std::vector<test::Triangle> scene = floor_scene();
        test::add_box(scene, {-1.0, -1.2, 0.0}, {1.3, 1.1, 1.7});
        // A tilted pyramid of its own, walls without thickness.
        const Vec a(3.0, 0.2, 0.0), b(5.0, 0.3, 0.1), c(4.0, 2.1, 0.05), d(4.1, 0.9, 2.0);
        for (const auto& [p, q, r] :
             {std::array{a, b, c}, std::array{a, b, d}, std::array{b, c, d}, std::array{c, a, d}})
            scene.push_back(test::rounded(p, q, r));
        const std::vector<Light> lights{
            lightmesh::PointLight{.position = {0.1f, 0.0f, 0.8f}, .radius = 0.3f},
            lightmesh::PointLight{.position = {4.0f, 0.8f, 0.6f}, .radius = 0.1f}};
        const VisibilityCache cache{HitTracer{&scene}, lights, CacheSettings{.spacing = spacing}};
        test::Random random(3);
        const Vec outer(0.1, -0.1, 0.8);
        for (const test::SurfacePoint& point : test::surface_points(random, scene, 3000)) {
            const glm::dvec3 p(point.position);
            const bool in_box = p.x > -1.001 && p.x < 1.301 && p.y > -1.201 && p.y < 1.101 && p.z > -0.1;
            const bool on_floor = std::abs(p.z) < 1e-6;
            if (on_floor && point.normal.z < 0.0f)
                continue;
            // Outer sides of the box look away from its middle.
            const bool outside =
                !in_box || (!on_floor && glm::dot(glm::dvec3(point.normal), p - outer) > 0.0);
            if (outside)
                CHECK(cache.visibility(point.position, point.normal, 0) == 0.0f);
        }
        CHECK(cache.visibility(glm::vec3(0.5f, 0.5f, 0.0f), glm::vec3(0, 0, 1), 0) == 1.0f);
        // On the floor about the pyramid.
        for (int i = 0; i < 500; ++i) {
            const double angle = 0.0125 * i;
            const glm::vec3 point(4.0 + 2.1 * std::cos(angle), 1.0 + 2.1 * std::sin(angle), 0.0);
            CHECK(cache.visibility(point, glm::vec3(0, 0, 1), 1) == 0.0f);
        }
    }
}

TEST_CASE("visibility cache: a sheet close over a floor keeps its light to itself") {
    for (const double height : {0.01, 0.03, 0.1, 0.24, 0.35}) {
        std::vector<test::Triangle> scene = floor_scene();
        test::add_quad(scene, {-4.0, -4.0, height}, {8.0, 0.0, 0.0}, {0.0, 8.0, 0.0});
        const std::vector<Light> lights{
            lightmesh::PointLight{.position = {0.3f, 0.1f, 5.0f}, .radius = 0.5f}};
        const VisibilityCache cache{HitTracer{&scene}, lights, CacheSettings{.spacing = 1.0f}};
        test::Random random(9);
        CAPTURE(height);
        for (int i = 0; i < 300; ++i) {
            const glm::vec3 below(random.in_box({-3.0, -3.0, 0.0}, {3.0, 3.0, 0.0}));
            const glm::vec3 above = below + glm::vec3(0.0f, 0.0f, static_cast<float>(height));
            CHECK(cache.visibility(below, glm::vec3(0, 0, 1), 0) == 0.0f);
            CHECK(cache.visibility(above, glm::vec3(0, 0, 1), 0) == 1.0f);
        }
    }
}

TEST_CASE("visibility cache: sheets close to walls of any orientation keep their light to themselves") {
    // A sheet before a wall, both turned; lamps on the sheet's far side.
    test::Random random(41);
    for (int turn = 0; turn < 12; ++turn) {
        const Vec up = turn < 3 ? Vec(turn == 0, turn == 1, turn == 2) : random.direction();
        const Vec right = across_of(up);
        const Vec forward = glm::cross(up, right);
        for (const double height : {0.01, 0.05, 0.2, 0.35}) {
            const auto place = [&](double x, double y, double z) {
                return x * right + y * forward + z * up;
            };
            std::vector<test::Triangle> scene;
            test::add_quad(scene, place(-6, -6, 0), 12.0 * right, 12.0 * forward);
            test::add_quad(scene, place(-4, -4, height), 8.0 * right, 8.0 * forward);
            const std::vector<Light> lights{
                lightmesh::PointLight{.position = glm::vec3(place(0.3, 0.1, 5.0)), .radius = 0.5f},
                lightmesh::DirectionalLight{glm::vec3(-up + 0.1 * right), 0.02f}};
            const VisibilityCache cache{HitTracer{&scene}, lights, CacheSettings{.spacing = 1.0f}};
            CAPTURE(turn);
            CAPTURE(height);
            for (int i = 0; i < 40; ++i) {
                // Not where lattice points are seen past the sheet's edge, up to 2.4 steps away.
                const double x = random.uniform(-1.5, 1.5);
                const double y = random.uniform(-1.5, 1.5);
                for (std::size_t l = 0; l < lights.size(); ++l) {
                    CHECK(cache.visibility(glm::vec3(place(x, y, 0.0)), glm::vec3(up), l) == 0.0f);
                    CHECK(cache.visibility(glm::vec3(place(x, y, height)), glm::vec3(up), l) == 1.0f);
                    CHECK(cache.visibility(glm::vec3(place(x, y, height)), glm::vec3(-up), l) == 0.0f);
                }
            }
        }
    }
}

TEST_CASE("visibility cache: no light comes under the edge of a sheet that lies just over a floor") {
    test::Random random(47);
    for (int turn = 0; turn < 6; ++turn) {
        const Vec up = turn < 3 ? Vec(turn == 0, turn == 1, turn == 2) : random.direction();
        const Vec right = across_of(up);
        const Vec forward = glm::cross(up, right);
        const double edge = random.uniform(3.5, 4.5);
        for (const double height : {0.01, 0.04, 0.1, 0.2, 0.35}) {
            std::vector<test::Triangle> scene;
            test::add_quad(scene, -9.0 * right - 9.0 * forward, 18.0 * right, 18.0 * forward);
            test::add_quad(scene, -4.0 * right - 4.0 * forward + height * up, (4.0 + edge) * right,
                           8.0 * forward);
            // From within, so that its rays slant outwards, and straight from above.
            const std::vector<Light> lights{
                lightmesh::PointLight{.position = glm::vec3(0.3 * right + 5.0 * up), .radius = 0.05f},
                lightmesh::DirectionalLight{glm::vec3(-up)}};
            const VisibilityCache cache{HitTracer{&scene}, lights, CacheSettings{.spacing = 1.0f}};
            CAPTURE(turn);
            CAPTURE(height);
            // Where records lie between floor and sheet, those beside the sheet are blended in as far as the
            // diagonal of a finest cell. A lower sheet covers the floor up to its edge.
            const double least = height < 0.05 ? 0.05 : 0.18;
            for (int i = 0; i < 200; ++i) {
                const double inside = random.uniform(least, 0.6);
                CAPTURE(inside);
                const Vec point = (edge - inside) * right + random.uniform(-2.0, 2.0) * forward;
                for (std::size_t l = 0; l < lights.size(); ++l)
                    CHECK(cache.visibility(glm::vec3(point), glm::vec3(up), l) < 0.1f);
            }
        }
    }
}

TEST_CASE("visibility cache: rays in place of records are as many as the finest of these take") {
    std::vector<test::Triangle> scene = floor_scene();
    test::add_quad(scene, {-4.0, -4.0, 0.04}, {8.0, 0.0, 0.0}, {0.0, 8.0, 0.0});
    // Its penumbra reaches as far under the sheet as beyond.
    const std::vector<Light> lights{lightmesh::PointLight{.position = {4.0f, 0.0f, 2.0f}, .radius = 1.0f}};
    for (const int lamp_rays : {64, 256}) {
        CAPTURE(lamp_rays);
        const VisibilityCache cache{HitTracer{&scene}, lights,
                                    CacheSettings{.spacing = 1.0f, .lamp_rays = lamp_rays}};
        test::Random random(48);
        std::uint64_t most = 0;
        for (int i = 0; i < 400; ++i) {
            const glm::vec3 point(random.uniform(3.9, 4.0), random.uniform(-2.0, 2.0), 0.0);
            cache.visibility(point, glm::vec3(0.0f, 0.0f, 1.0f), 0);
            const std::uint64_t before = cache.statistics().point_rays;
            cache.visibility(point, glm::vec3(0.0f, 0.0f, 1.0f), 0);
            most = (std::max)(most, cache.statistics().point_rays - before);
        }
        // Besides those to four lattice points of four levels.
        const auto finest = static_cast<std::uint64_t>(lamp_rays / 4);
        CHECK(most >= finest);
        CHECK(most <= finest + 16);
    }
}

TEST_CASE("visibility cache: among leaves few rays go past what looks another way than the point does") {
    test::Random random(51);
    std::vector<test::Triangle> leaves;
    for (int i = 0; i < 1500; ++i) {
        const Vec middle = random.in_box(Vec(-0.6), Vec(0.6));
        leaves.push_back(test::rounded(middle + 0.06 * random.direction(), middle + 0.06 * random.direction(),
                                       middle + 0.06 * random.direction()));
    }
    const std::vector<test::SurfacePoint> points = test::surface_points(random, leaves, 400);
    const std::vector<Light> lights{lightmesh::PointLight{.position = {1.0f, 0.5f, 5.0f}, .radius = 0.4f}};
    const VisibilityCache cache{HitTracer{&leaves}, lights, CacheSettings{.spacing = 0.25f}};
    values_of(cache, points);
    const std::uint64_t cold = cache.statistics().point_rays;
    values_of(cache, points);
    // 981, besides those to the lamp nearly all to lattice points; 1,077 where all that covers a point
    // counts.
    CHECK(cache.statistics().point_rays - cold < 1030);
    CHECK(errors_of(cache, leaves, lights, points, 256).mean < 0.15);
}

TEST_CASE("visibility cache: nothing pops beside and under a sheet while footprints shrink") {
    test::Random random(53);
    for (const double height : {0.02, 0.06, 0.1, 0.2, 0.35}) {
        const double edge = random.uniform(3.5, 4.5);
        std::vector<test::Triangle> scene;
        test::add_quad(scene, {-9.0, -9.0, 0.0}, {18.0, 0.0, 0.0}, {0.0, 18.0, 0.0});
        test::add_quad(scene, {-4.0, -4.0, height}, {4.0 + edge, 0.0, 0.0}, {0.0, 8.0, 0.0});
        const std::vector<Light> lights{lightmesh::PointLight{.position = {0.3f, 0.1f, 5.0f}, .radius = 0.2f},
                                        lightmesh::DirectionalLight{{0.0f, 0.0f, -1.0f}}};
        const VisibilityCache cache{HitTracer{&scene}, lights, CacheSettings{.spacing = 1.0f}};
        CAPTURE(height);
        for (int i = 0; i < 12; ++i) {
            lightmesh::SurfacePoint point{.position =
                                              glm::vec3(static_cast<float>(edge + random.uniform(-0.4, 0.4)),
                                                        static_cast<float>(random.uniform(-2.0, 2.0)), 0.0f),
                                          .normal = {0.0f, 0.0f, 1.0f},
                                          .footprint = 2.0f};
            std::vector<float> before(2);
            std::vector<float> lit(2);
            cache.visibility(point, std::span<float>(before));
            while (point.footprint > 0.1f) {
                point.footprint *= 0.999f;
                cache.visibility(point, std::span<float>(lit));
                CAPTURE(point.footprint);
                for (std::size_t l = 0; l < 2; ++l)
                    CHECK(std::abs(lit[l] - before[l]) < 0.03f);
                before = lit;
            }
        }
    }
}

TEST_CASE("visibility cache: no light comes through a double wall, nor through a single thin one") {
    test::Random random(43);
    for (const double gap : {0.0, 1e-5, 0.02, 0.3, 0.7}) {
        for (int turn = 0; turn < 6; ++turn) {
            const Vec across = turn < 2 ? Vec(turn == 0, turn == 1, 0.0) : random.direction();
            const Vec right = across_of(across);
            const Vec up = glm::cross(across, right);
            // A wall, or two, from edge to edge of a floor that meets them.
            std::vector<test::Triangle> scene;
            test::add_quad(scene, -8.0 * right - 8.0 * up, 16.0 * right, 16.0 * up);
            if (gap > 0.0)
                test::add_quad(scene, -8.0 * right - 8.0 * up + gap * across, 16.0 * right, 16.0 * up);
            test::add_quad(scene, -8.0 * right - 6.0 * across, 16.0 * right, 12.0 * across);
            const std::vector<Light> lights{lightmesh::PointLight{
                .position = glm::vec3(2.0 * across + 0.5 * right + 1.0 * up), .radius = 0.4f}};
            const VisibilityCache cache{HitTracer{&scene}, lights, CacheSettings{.spacing = 1.0f}};
            CAPTURE(gap);
            CAPTURE(turn);
            for (int i = 0; i < 60; ++i) {
                const double x = random.uniform(-4.0, 4.0);
                const double far = std::pow(10.0, random.uniform(-5.0, 0.5));
                // On the floor behind the wall, and on the wall's back.
                const Vec floor = x * right - far * across;
                CHECK(cache.visibility(glm::vec3(floor), glm::vec3(up), 0) == 0.0f);
                CHECK(cache.visibility(glm::vec3(x * right + far * up), glm::vec3(-across), 0) == 0.0f);
                if (gap > 1e-4)
                    CHECK(cache.visibility(glm::vec3(x * right + 0.5 * gap * across), glm::vec3(up), 0) ==
                          0.0f);
                CHECK(cache.visibility(glm::vec3(x * right + (gap + 1.0 + far) * across), glm::vec3(up), 0) ==
                      1.0f);
            }
        }
    }
}

TEST_CASE("visibility cache: no light falls into narrow slits, whatever all that lies around them says") {
    // Closed slits between two walls with a lid, and lamps that shine straight down on both sides.
    test::Random random(47);
    for (int slit = 0; slit < 60; ++slit) {
        const double width = random.uniform(0.02, 0.3);
        const double x = random.uniform(-1.0, 1.0);
        std::vector<test::Triangle> scene = floor_scene();
        test::add_box(scene, {x, -6.0, -0.01}, {x + width, 6.0, random.uniform(1.4, 3.0)});
        const std::vector<Light> lights{
            lightmesh::DirectionalLight{{0.03f, 0.05f, -1.0f}, 0.02f},
            lightmesh::PointLight{.position = {static_cast<float>(x), 0.0f, 15.0f}}};
        const VisibilityCache cache{HitTracer{&scene}, lights,
                                    CacheSettings{.spacing = 1.0f, .detail = slit % 4}};
        CAPTURE(width);
        for (int i = 0; i < 20; ++i) {
            const glm::vec3 floor(x + random.uniform(0.02, 0.98) * width, random.uniform(-3.0, 3.0), 0.0);
            for (std::size_t l = 0; l < lights.size(); ++l)
                CHECK(cache.visibility(floor, glm::vec3(0, 0, 1), l) == 0.0f);
        }
    }
}

TEST_CASE("visibility cache: no light comes through a sheet on a ridge from a lamp at the horizon") {
    // Behind the sheet records turn away from the lamp, and places before it do not.
    test::Random random(53);
    for (int turn = 0; turn < 100; ++turn) {
        const double radius = random.uniform(1.5, 6.0);
        const auto ridge = [&](int i) {
            return radius * Vec(std::sin(0.02 * i), 0.0, std::cos(0.02 * i) - 1.0) - Vec(0.0, 6.0, 0.0);
        };
        std::vector<test::Triangle> scene;
        for (int i = -40; i < 40; ++i)
            test::add_quad(scene, ridge(i), ridge(i + 1) - ridge(i), {0, 12, 0});
        const double sheet = random.uniform(-0.3, 0.3);
        test::add_quad(scene, {sheet, -6.0, -0.3}, {0, 12, 0}, {0, 0, 3});
        const double angle = sheet / radius + random.uniform(-0.06, 0.06);
        const std::vector<Light> lights{
            lightmesh::DirectionalLight{glm::vec3(-std::cos(angle), 0.0, std::sin(angle))}};
        const VisibilityCache cache{HitTracer{&scene}, lights,
                                    CacheSettings{.spacing = 0.5f, .detail = turn % 4}};
        for (int i = 0; i < 60; ++i) {
            const double at = (sheet / radius - random.uniform(0.0005, 0.1)) / 0.02;
            const int facet = static_cast<int>(std::floor(at));
            const Vec along = ridge(facet + 1) - ridge(facet);
            Vec point = ridge(facet) + (at - facet) * along;
            point.y = random.uniform(-2.0, 2.0);
            if (point.x < sheet - 1e-4)
                CHECK(cache.visibility(glm::vec3(point),
                                       glm::vec3(glm::normalize(Vec(-along.z, 0.0, along.x))), 0) == 0.0f);
        }
    }
}

TEST_CASE("visibility cache: far from the origin, and at tiny and huge scales, as near to lamps as at home") {
    struct Place {
        double scale, shift;
    };
    for (const Place& place : {Place{1.0, 0.0}, Place{1.0, 250000.0}, Place{1e-7, 0.0}, Place{3e9, 0.0}}) {
        Work work = boxes(9, 60);
        const Vec shift(place.shift, -0.6 * place.shift, 0.3 * place.shift);
        const auto move = [&](const Vec& p) {
            return Vec(glm::vec3(place.scale * p + shift));
        };
        for (test::Triangle& t : work.scene)
            t = {move(t.a), move(t.b), move(t.c)};
        const auto scale = static_cast<float>(place.scale);
        for (Light& light : work.lights) {
            if (auto* lamp = std::get_if<lightmesh::PointLight>(&light)) {
                lamp->position = glm::vec3(move(Vec(lamp->position)));
                lamp->radius *= scale;
            } else if (auto* pane = std::get_if<lightmesh::RectLight>(&light)) {
                pane->position = glm::vec3(move(Vec(pane->position)));
                pane->half_u *= scale;
                pane->half_v *= scale;
            }
        }
        // Points on the moved triangles, whose coordinates are rounded.
        test::Random random(10);
        work.points = test::surface_points(random, work.scene, 60);
        // 250,000 is 1e6 steps.
        const VisibilityCache cache{HitTracer{&work.scene}, work.lights,
                                    CacheSettings{.spacing = 0.25f * scale}};
        std::vector<float> all(work.lights.size());
        double error = 0.0;
        double pairs = 0.0;
        for (const test::SurfacePoint& point : work.points) {
            cache.visibility(point.position, point.normal, all);
            for (std::size_t l = 0; l < 3; ++l) {
                const auto& lamp = std::get<lightmesh::PointLight>(work.lights[l]);
                if (glm::dot(Vec(lamp.position) - Vec(point.position), Vec(point.normal)) < 0.0) {
                    CHECK(all[l] == 0.0f);
                    continue;
                }
                // Off the surface by more than the rounding of the coordinates.
                const Vec from =
                    Vec(point.position) + (1e-5 * place.scale + 2e-7 * std::abs(shift.x)) * Vec(point.normal);
                const Vec way = Vec(lamp.position) - from;
                const auto radius = static_cast<double>(lamp.radius);
                const Vec axis = glm::normalize(way);
                const Vec right =
                    glm::normalize(glm::cross(axis, std::abs(axis.z) < 0.9 ? Vec(0, 0, 1) : Vec(1, 0, 0)));
                int open = 0;
                for (int i = 0; i < 128; ++i) {
                    const double ring = std::sqrt((i + random.uniform(0.0, 1.0)) / 128.0);
                    const double turn = 2.0 * std::numbers::pi * random.uniform(0.0, 1.0);
                    const Vec to =
                        way +
                        radius * ring * (std::cos(turn) * right + std::sin(turn) * glm::cross(right, axis));
                    const double share = std::max(0.3, 1.0 - 1.15 * radius / glm::length(way));
                    open += test::blocked(from, from + share * to, work.scene) ? 0 : 1;
                }
                error += std::abs(static_cast<double>(all[l]) - open / 128.0);
                pairs += 1.0;
            }
        }
        CAPTURE(place.scale);
        CAPTURE(place.shift);
        CHECK(error / pairs < 0.03);
    }
}

TEST_CASE("visibility cache: a slow walk meets no step") {
    std::vector<test::Triangle> scene = floor_scene();
    test::add_box(scene, {-1.0, -0.7, 0.8}, {1.0, 0.9, 0.9});
    const std::vector<Light> lights{lightmesh::PointLight{.position = {0.5f, 0.2f, 4.0f}, .radius = 0.5f}};
    // One on the floor, one on a slope between two axes.
    for (const double slope : {0.0, 1.0}) {
        const glm::vec3 normal(glm::normalize(Vec(-slope, 0.0, 1.0)));
        std::vector<test::Triangle> tilted = scene;
        if (slope > 0.0)
            test::add_quad(tilted, {-8.0, -8.0, -8.0 * slope - 1.0}, {16.0, 0.0, 16.0 * slope},
                           {0.0, 16.0, 0.0});
        const VisibilityCache cache{HitTracer{&tilted}, lights, CacheSettings{.spacing = 0.25f}};
        float before = not_a_number;
        float largest = 0.0f;
        for (int i = 0; i < 12000; ++i) {
            const double x = -1.8 + 0.25e-3 * i * 1.1;
            if (slope > 0.0 && slope * x - 1.0 > -0.02)
                break;
            const glm::vec3 point(x, -0.9 + 0.3 * x, slope > 0.0 ? slope * x - 1.0 : 0.0);
            const float now = cache.visibility(point, normal, 0);
            if (i > 0)
                largest = std::max(largest, std::abs(now - before));
            before = now;
        }
        CAPTURE(slope);
        CHECK(largest < 0.01f);
    }
}

namespace {

/// A ball of radius 1 of so many segments around and half as many from pole to pole, shaded smoothly.
class SmoothBall {
public:
    explicit SmoothBall(int segments) {
        const auto corner = [segments](int i, int j) {
            const double around = 2.0 * std::numbers::pi * i / segments;
            const double down = 2.0 * std::numbers::pi * j / segments;
            return Vec(std::sin(down) * std::cos(around), std::sin(down) * std::sin(around), std::cos(down));
        };
        for (int i = 0; i < segments; ++i) {
            for (int j = 0; j < segments / 2; ++j) {
                if (j > 0)
                    triangles.push_back(test::rounded(corner(i, j), corner(i, j + 1), corner(i + 1, j)));
                if (j + 1 < segments / 2)
                    triangles.push_back(
                        test::rounded(corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)));
            }
        }
    }

    /// Where a way from the middle leaves the ball.
    lightmesh::SurfacePoint at(const Vec& direction) const {
        for (const test::Triangle& t : triangles) {
            const Vec n = glm::cross(t.b - t.a, t.c - t.a);
            const double share = glm::dot(t.a, n) / glm::dot(direction, n);
            const Vec p = share * direction;
            const double a = glm::dot(n, glm::cross(t.c - t.b, p - t.b)) / glm::dot(n, n);
            const double b = glm::dot(n, glm::cross(t.a - t.c, p - t.c)) / glm::dot(n, n);
            if (share <= 0.0 || a < 0.0 || b < 0.0 || a + b > 1.0)
                continue;
            // Corners lie on the ball, so they are their own normals.
            return {.position = glm::vec3(p),
                    .normal = glm::vec3(glm::normalize(n)),
                    .shading_normal = glm::vec3(glm::normalize(a * t.a + b * t.b + (1.0 - a - b) * t.c))};
        }
        return {};
    }

    std::vector<test::Triangle> triangles;
};

}  // namespace

TEST_CASE("visibility cache: on smooth-shaded balls of few segments the light fades out without facets") {
    const std::vector<Light> lights{lightmesh::DirectionalLight{{-1.0f, 0.3f, -0.4f}},
                                    lightmesh::DirectionalLight{{0.2f, 1.0f, 0.3f}, 0.05f},
                                    lightmesh::PointLight{.position = {3.0f, 1.0f, 2.0f}},
                                    lightmesh::PointLight{.position = {-2.0f, 2.0f, 1.0f}, .radius = 0.4f}};
    for (const int segments : {8, 12}) {
        const SmoothBall ball(segments);
        for (const float spacing : {0.05f, 0.3f, 1.0f}) {
            const VisibilityCache cache{HitTracer{&ball.triangles}, lights,
                                        CacheSettings{.spacing = spacing}};
            std::vector<float> all(lights.size());
            std::vector<double> largest(lights.size()), largest_flat(lights.size());
            for (const double tilt : {0.1, 0.8, 1.4}) {
                std::vector<double> before(lights.size(), NAN);
                for (int i = 0; i < 1440; ++i) {
                    const double turn = 2.0 * std::numbers::pi * i / 1440.0;
                    const lightmesh::SurfacePoint point = ball.at(
                        {std::cos(turn), std::sin(turn) * std::cos(tilt), std::sin(turn) * std::sin(tilt)});
                    cache.visibility(point, all);
                    for (std::size_t l = 0; l < lights.size(); ++l) {
                        const auto* sun = std::get_if<lightmesh::DirectionalLight>(&lights[l]);
                        const auto* lamp = std::get_if<lightmesh::PointLight>(&lights[l]);
                        const Vec way =
                            sun != nullptr ? -Vec(sun->direction) : Vec(lamp->position - point.position);
                        const double cosine = glm::dot(Vec(point.shading_normal), glm::normalize(way));
                        const double now = static_cast<double>(all[l]) * std::max(0.0, cosine);
                        // Nothing shadows the ball but itself.
                        if (cosine > 0.25)
                            CHECK(all[l] > 0.85f);
                        if (!std::isnan(before[l]))
                            largest[l] = std::max(largest[l], std::abs(now - before[l]));
                        before[l] = now;
                    }
                }
            }
            CAPTURE(segments);
            CAPTURE(spacing);
            for (std::size_t l = 0; l < lights.size(); ++l) {
                CAPTURE(l);
                CHECK(largest[l] < 0.05);
            }
        }
    }
}

TEST_CASE("visibility cache: shading normals let no light into a closed room") {
    // Walls with and without thickness, whose normals lean towards the middle, as rounded corners have them.
    for (const double thickness : {0.0, 0.2, 5.0}) {
        std::vector<test::Triangle> scene;
        test::add_box(scene, Vec(-1.0), Vec(1.0));
        if (thickness > 0.0)
            test::add_box(scene, Vec(-1.0 - thickness), Vec(1.0 + thickness));
        const std::vector<Light> lights{
            lightmesh::DirectionalLight{{-1.0f, 0.3f, -0.2f}, 0.05f},
            lightmesh::PointLight{.position = {1.1f, -9.0f, 0.4f}, .radius = 0.3f}};
        const VisibilityCache cache{HitTracer{&scene}, lights, CacheSettings{.spacing = 0.2f}};
        const VisibilityCache bisected{test::PlainTracer{&scene}, lights, CacheSettings{.spacing = 0.2f}};
        test::Random random(5);
        for (int i = 0; i < 200; ++i) {
            Vec point = random.in_box(Vec(-1.0), Vec(1.0));
            const int axis = i % 3;
            point[axis] = i % 2 == 0 ? 1.0 : -1.0;
            Vec normal(0.0);
            normal[axis] = -point[axis];
            const lightmesh::SurfacePoint asked{.position = glm::vec3(point),
                                                .normal = glm::vec3(normal),
                                                .shading_normal =
                                                    glm::vec3(glm::normalize(normal - 0.9 * point))};
            for (std::size_t l = 0; l < lights.size(); ++l) {
                CHECK(cache.visibility(asked, l) == 0.0f);
                if (i < 30)
                    CHECK(bisected.visibility(asked, l) == 0.0f);
            }
        }
    }
}

TEST_CASE("visibility cache: footprints choose levels, and nothing pops") {
    const Work work = boxes(6, 40);
    const VisibilityCache cache{HitTracer{&work.scene}, work.lights, CacheSettings{.spacing = 0.25f}};
    for (const test::SurfacePoint& point : work.points) {
        float before = not_a_number;
        float largest = 0.0f;
        for (float footprint = 0.01f; footprint < 2.0f; footprint *= 1.002f) {
            const float now = cache.visibility(lightmesh::SurfacePoint{.position = point.position,
                                                                       .normal = point.normal,
                                                                       .footprint = footprint},
                                               0);
            if (!std::isnan(before))
                largest = std::max(largest, std::abs(now - before));
            before = now;
        }
        CHECK(largest < 0.03f);
        CHECK(cache.visibility(lightmesh::SurfacePoint{point.position, point.normal, not_a_number}, 1) ==
              cache.visibility(point.position, point.normal, 1));
    }
    const lightmesh::CacheStatistics held = cache.statistics();
    CHECK(held.records_of_level[8] > 0);
    CHECK(held.records_of_level[9] > 0);
}

TEST_CASE("visibility cache: no record is finer than the footprints that were asked for") {
    const Work work = boxes(6, 200);
    const VisibilityCache cache{HitTracer{&work.scene}, work.lights, CacheSettings{.spacing = 0.25f}};
    const auto records_from = [&](std::size_t level) {
        std::size_t sum = 0;
        for (const lightmesh::CacheStatistics held = cache.statistics(); level < held.records_of_level.size();
             ++level)
            sum += held.records_of_level[level];
        return sum;
    };
    std::vector<float> all(work.lights.size());
    // Level 9 is that of g.
    struct Finest {
        float footprint;
        std::size_t level;
    };
    for (const Finest& finest :
         {Finest{0.26f, 8}, Finest{0.13f, 9}, Finest{0.065f, 10}, Finest{0.033f, 11}, Finest{0.0f, 12}}) {
        CAPTURE(finest.footprint);
        for (const test::SurfacePoint& point : work.points)
            cache.visibility(lightmesh::SurfacePoint{.position = point.position,
                                                     .normal = point.normal,
                                                     .footprint = finest.footprint},
                             all);
        CHECK(records_from(finest.level) > 0);
        CHECK(records_from(finest.level + 1) == 0);
    }
}

TEST_CASE("visibility cache: rays go only to lights that are asked for, and refine for those that need it") {
    Work work = boxes(9, 60);
    const CacheSettings settings{.spacing = 0.25f};
    const auto rays_for_first = [&](const std::vector<Light>& lights) {
        const VisibilityCache cache{HitTracer{&work.scene}, lights, settings};
        for (const test::SurfacePoint& point : work.points)
            (void)cache.visibility(point.position, point.normal, 0);
        return cache.statistics().lamp_rays;
    };
    const std::uint64_t alone = rays_for_first({work.lights[0]});
    CHECK(alone > 1000);
    CHECK(rays_for_first(work.lights) == alone);

    // A light whose shadows no penumbra makes steep does not pay for one beside it.
    const Light high = lightmesh::PointLight{.position = {0.0f, 0.0f, 90.0f}, .radius = 0.0f};
    const auto rays_for_both = [&](const std::vector<Light>& lights) {
        const VisibilityCache cache{HitTracer{&work.scene}, lights, settings};
        values_of(cache, work.points);
        return cache.statistics().lamp_rays;
    };
    CHECK(rays_for_both({work.lights[0], high}) == rays_for_both({work.lights[0]}) + rays_for_both({high}));
}

TEST_CASE("visibility cache: a spot's penumbrae are those of a sphere, within its cone") {
    std::vector<test::Triangle> scene = floor_scene();
    test::add_box(scene, {-1.0, -1.0, 1.0}, {1.0, 1.0, 1.1});
    const lightmesh::PointLight sphere{.position = {0.3f, 0.2f, 4.0f}, .radius = 0.5f};
    const lightmesh::SpotLight spot{
        .position = sphere.position, .axis = {0.1f, 0.2f, -1.0f}, .cone = 0.4f, .radius = sphere.radius};
    const VisibilityCache cache{HitTracer{&scene}, std::vector<Light>{sphere, spot},
                                CacheSettings{.spacing = 0.25f}};
    test::Random random(10);
    int partly_inside = 0;
    int lit_outside = 0;
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 point(random.in_box({-2.5, -2.5, 0.0}, {2.5, 2.5, 0.0}));
        const glm::vec3 way = glm::normalize(point - spot.position);
        const float beyond = glm::dot(way, glm::normalize(spot.axis)) - std::cos(spot.cone);
        if (std::abs(beyond) < 1e-4f)
            continue;
        // Rays to both go to the same places.
        const float of_sphere = cache.visibility(point, glm::vec3(0.0f, 0.0f, 1.0f), 0);
        CHECK(cache.visibility(point, glm::vec3(0.0f, 0.0f, 1.0f), 1) == (beyond > 0.0f ? of_sphere : 0.0f));
        partly_inside += beyond > 0.0f && of_sphere > 0.0f && of_sphere < 1.0f ? 1 : 0;
        lit_outside += beyond < 0.0f && of_sphere > 0.0f ? 1 : 0;
    }
    CHECK(partly_inside > 20);
    CHECK(lit_outside > 20);
}

TEST_CASE("visibility cache: a scene of another size, by a power of two, gives the same bits") {
    const Work work = boxes(7, 40);
    const VisibilityCache cache{HitTracer{&work.scene}, work.lights, CacheSettings{.spacing = 0.25f}};
    const std::vector<float> expected = values_of(cache, work.points);
    for (const float scale : {0x1p-14f, 0x1p20f}) {
        Work scaled = work;
        for (test::Triangle& t : scaled.scene)
            for (Vec* corner : {&t.a, &t.b, &t.c})
                *corner *= static_cast<double>(scale);
        for (test::SurfacePoint& point : scaled.points)
            point.position *= scale;
        for (Light& light : scaled.lights) {
            if (auto* lamp = std::get_if<lightmesh::PointLight>(&light)) {
                lamp->position *= scale;
                lamp->radius *= scale;
            } else if (auto* pane = std::get_if<lightmesh::RectLight>(&light)) {
                pane->position *= scale;
                pane->half_u *= scale;
                pane->half_v *= scale;
            }
        }
        const VisibilityCache other{HitTracer{&scaled.scene}, scaled.lights,
                                    CacheSettings{.spacing = 0.25f * scale}};
        const std::vector<float> found = values_of(other, scaled.points);
        double difference = 0.0;
        for (std::size_t i = 0; i < found.size(); ++i)
            difference += std::abs(static_cast<double>(found[i] - expected[i]));
        // Patterns are turned by the lamps' coordinates: not the same turns.
        CHECK(difference / static_cast<double>(found.size()) < 0.005);
    }
}

TEST_CASE("visibility cache: what fails leaves nothing half-made") {
    const Work work = boxes(8, 40);
    struct Unreliable : HitTracer {
        std::atomic<int>* calls;
        int every;
        void fail() const {
            if (++*calls % every == 0)
                throw std::runtime_error("the tracer fails");
        }
        bool occluded(const Segment& segment) const {
            fail();
            return HitTracer::occluded(segment);
        }
        std::optional<lightmesh::Hit> closest_hit(const Segment& segment) const {
            fail();
            return HitTracer::closest_hit(segment);
        }
    };
    const CacheSettings settings{.spacing = 0.3f};
    const VisibilityCache calm{HitTracer{&work.scene}, work.lights, settings};
    const std::vector<float> expected = values_of(calm, work.points);
    std::atomic<int> calls{0};
    const VisibilityCache cache{Unreliable{{&work.scene}, &calls, 503}, work.lights, settings};
    int failures = 0;
    std::vector<float> all(work.lights.size());
    for (std::size_t i = 0; i < work.points.size(); ++i) {
        for (;;) {
            try {
                cache.visibility(work.points[i].position, work.points[i].normal, all);
                break;
            } catch (const std::runtime_error&) {
                ++failures;
            }
        }
        CHECK(std::equal(all.begin(), all.end(),
                         expected.begin() + static_cast<std::ptrdiff_t>(i * work.lights.size())));
    }
    CHECK(failures > 5);
}

TEST_CASE("visibility cache: points at the border of what is allowed") {
    const std::vector<test::Triangle> scene = floor_scene();
    const std::vector<Light> lights{
        lightmesh::PointLight{.position = {0.0f, 0.0f, 3.0f}, .range = 5.0f, .radius = 0.2f},
        lightmesh::SpotLight{.position = {0.0f, 0.0f, 3.0f}, .cone = 0.3f, .radius = 0.2f}};
    const VisibilityCache cache{HitTracer{&scene}, lights, CacheSettings{}};
    const glm::vec3 up(0.0f, 0.0f, 1.0f);
    CHECK(std::isnan(cache.visibility(glm::vec3(not_a_number, 0.0f, 0.0f), up, 0)));
    CHECK(std::isnan(cache.visibility(glm::vec3(0.0f), glm::vec3(0.0f, not_a_number, 0.0f), 0)));
    CHECK_THROWS_AS((void)cache.visibility(glm::vec3(1e9f, 0.0f, 0.0f), up, 0), std::out_of_range);
    CHECK_THROWS_AS((void)cache.visibility(glm::vec3(0.0f), up, 2), std::out_of_range);
    std::vector<float> wrong(3);
    CHECK_THROWS_AS(cache.visibility(glm::vec3(0.0f), up, wrong), std::invalid_argument);
    CHECK(cache.visibility(glm::vec3(0.0f), up, 0) == 1.0f);
    CHECK(cache.visibility(glm::vec3(0.0f), 1e-3f * up, 0) == 1.0f);
    CHECK(cache.visibility(glm::vec3(0.0f), -up, 0) == 0.0f);
    CHECK(cache.visibility(glm::vec3(0.0f, 0.0f, 1.0f), glm::vec3(0.0f), 0) == 1.0f);
    CHECK(cache.visibility(glm::vec3(4.5f, 0.0f, 0.0f), up, 0) == 0.0f);  // out of range
    CHECK(cache.visibility(glm::vec3(3.0f, 0.0f, 0.0f), up, 0) == 1.0f);
    CHECK(cache.visibility(glm::vec3(0.5f, 0.0f, 0.0f), up, 1) == 1.0f);
    CHECK(cache.visibility(glm::vec3(1.5f, 0.0f, 0.0f), up, 1) == 0.0f);  // outside the cone
    for (const CacheSettings& settings :
         {CacheSettings{.spacing = 0.0f}, CacheSettings{.spacing = not_a_number}, CacheSettings{.detail = 7},
          CacheSettings{.detail = -1}, CacheSettings{.lamp_rays = 0}, CacheSettings{.lamp_rays = 257},
          CacheSettings{.origin = {not_a_number, 0.0f, 0.0f}}})
        CHECK_THROWS_AS((VisibilityCache{HitTracer{&scene}, lights, settings}), std::invalid_argument);
    const VisibilityCache dark{HitTracer{&scene}, std::vector<Light>{}, CacheSettings{}};
    CHECK(dark.light_count() == 0);
    dark.visibility(glm::vec3(0.0f), up, std::span<float>());
    CHECK_THROWS_AS(dark.visibility(glm::vec3(1e9f, 0.0f, 0.0f), up, std::span<float>()), std::out_of_range);
}

TEST_CASE("visibility cache: exact edges decide by rays where records disagree") {
    std::vector<test::Triangle> scene = floor_scene();
    test::add_box(scene, {-1.0, -1.0, 1.0}, {1.0, 1.0, 1.1});
    const std::vector<Light> lights{lightmesh::PointLight{.position = {0.3f, 0.2f, 4.0f}}};
    const VisibilityCache blurred{HitTracer{&scene}, lights, CacheSettings{.spacing = 0.5f, .detail = 1}};
    const VisibilityCache sharp{HitTracer{&scene}, lights,
                                CacheSettings{.spacing = 0.5f, .detail = 1, .exact_edges = true}};
    int wrong_blurred = 0;
    int wrong_sharp = 0;
    for (int i = 0; i < 2000; ++i) {
        const glm::vec3 point(-2.5f + 0.0025f * static_cast<float>(i), 0.1f, 0.0f);
        const bool open = !test::blocked(Vec(point) + Vec(0, 0, 1e-4), Vec(0.3f, 0.2f, 4.0f), scene);
        const float expected = open ? 1.0f : 0.0f;
        wrong_blurred +=
            std::abs(blurred.visibility(point, glm::vec3(0, 0, 1), 0) - expected) > 0.45f ? 1 : 0;
        wrong_sharp += std::abs(sharp.visibility(point, glm::vec3(0, 0, 1), 0) - expected) > 0.45f ? 1 : 0;
    }
    CHECK(wrong_blurred > 5);
    CHECK(wrong_sharp == 0);
}

TEST_CASE("visibility cache: blur rows are the light mesh, continuous") {
    std::vector<test::Triangle> scene = floor_scene();
    test::add_box(scene, {-1.0, -1.0, 0.8}, {1.0, 1.0, 0.9});
    const std::vector<Light> lights{lightmesh::PointLight{.position = {0.3f, 0.2f, 4.0f}}};
    const auto mesh_of = [&](float quality) {
        return lightmesh::LightMesh{HitTracer{&scene}, lights,
                                    lightmesh::Settings{.radius = 0.5f, .quality = quality}};
    };
    const CacheSettings settings{.spacing = 0.125f};
    const glm::vec3 up(0.0f, 0.0f, 1.0f);
    const VisibilityCache blur{mesh_of(4.0f), settings};
    const auto mesh = mesh_of(4.0f);
    double difference = 0.0;
    for (int i = 0; i < 300; ++i) {
        const glm::vec3 point(-2.0f + 0.0133f * static_cast<float>(i), 0.1f, 0.0f);
        difference +=
            static_cast<double>(std::abs(blur.visibility(point, up, 0) - mesh.visibility(point, up, 0)));
    }
    CHECK(difference / 300.0 < 0.02);
    CHECK(blur.mesh().statistics().light_points > 0);

    // Few light points make large steps; over the soft edge, by g / 1000 at a time.
    const auto largest_step = [&](const auto& kept) {
        float before = 0.0f;
        float largest = 0.0f;
        for (int i = 0; i < 16000; ++i) {
            const float now =
                kept.visibility(glm::vec3(-2.0f + 0.125e-3f * static_cast<float>(i), 0.1f, 0.0f), up, 0);
            if (i > 0)
                largest = std::max(largest, std::abs(now - before));
            before = now;
        }
        return largest;
    };
    CHECK(largest_step(VisibilityCache{mesh_of(2.0f), settings}) < 0.01f);
    CHECK(largest_step(mesh_of(2.0f)) > 0.03f);
}

}  // namespace visibility_cache_test
