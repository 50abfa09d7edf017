// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>

#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

// What the library says it has spent is what its adapter was asked for.

namespace statistics_test {

namespace {

using lightmesh::QueryStatistics;
using lightmesh::ShortTest;

struct Count {
    std::uint64_t rays = 0;
    std::map<std::array<std::uint32_t, 6>, int> segments;
};

/// Keeps count of all segments, in a place that the copies share.
struct CountingTracer {
    const std::vector<test::Triangle>* triangles;
    Count* count;

    bool occluded(const lightmesh::Segment& s) const {
        ++count->rays;
        std::array<std::uint32_t, 6> key;
        for (int i = 0; i < 3; ++i) {
            key[static_cast<std::size_t>(i)] = std::bit_cast<std::uint32_t>(s.origin[i]);
            key[static_cast<std::size_t>(i) + 3] = std::bit_cast<std::uint32_t>(s.target[i]);
        }
        ++count->segments[key];
        return test::PlainTracer{triangles}.occluded(s);
    }
};

lightmesh::Settings settings_of(float radius, float quality, ShortTest short_test) {
    lightmesh::Settings settings;
    settings.radius = radius;
    settings.adaptive_long_tests = false;
    settings.quality = quality;
    settings.short_test = short_test;
    return settings;
}

}  // namespace

TEST_CASE("every ray is accounted for, and none changes a value") {
    test::Random random(41);
    const auto scene = test::thin_walls(random);
    const auto lights = test::random_lights(random, 12);
    const auto points = test::surface_points(random, scene, 80);
    for (const ShortTest short_test : test::all_short_tests) {
        Count count;
        const auto settings = settings_of(0.8f, 2.0f, short_test);
        const lightmesh::LightMesh mesh{CountingTracer{&scene, &count}, lights, settings};
        const lightmesh::LightMesh unasked{test::PlainTracer{&scene}, lights, settings};
        QueryStatistics statistics;
        std::vector<float> all(lights.size());
        std::vector<float> expected(lights.size());
        for (const test::SurfacePoint& p : points) {
            mesh.visibility(p.position, p.normal, std::span<float>{all}, &statistics);
            unasked.visibility(p.position, p.normal, std::span<float>{expected});
            CHECK(all == expected);
            CHECK(mesh.visibility(p.position, p.normal, std::size_t{3}, &statistics) == expected[3]);
        }
        const lightmesh::MeshStatistics held = mesh.statistics();
        CHECK(statistics.points == 2 * points.size());
        CHECK(count.rays == statistics.short_rays + statistics.shadow_rays + held.kept_rays());
        CHECK(held.kept_rays() == held.long_rays + held.link_rays);
        CHECK((statistics.short_rays > 0) == (short_test != ShortTest::none));
        CHECK(held.long_rays > 0);
        CHECK((held.link_rays > 0) == (short_test == ShortTest::linked));
        // One ray to the nearest light point that is seen, of the eight around.
        if (short_test == ShortTest::linked)
            CHECK(statistics.short_rays < 4 * statistics.points);
    }
}

TEST_CASE("each light is traced to each light point at most once") {
    test::Random random(42);
    const auto scene = test::boxes_on_floor(random, 3);
    const auto points = test::surface_points(random, scene, 80);
    std::vector<lightmesh::Light> lights;
    for (int i = 0; i < 11; ++i)
        lights.push_back(lightmesh::PointLight{glm::vec3(random.in_box({-4, -4, 0}, {4, 4, 5}))});
    Count count;
    const lightmesh::LightMesh mesh{CountingTracer{&scene, &count}, lights,
                                    settings_of(0.8f, 3.0f, ShortTest::none)};
    std::vector<float> all(lights.size());
    QueryStatistics cold;
    for (const test::SurfacePoint& p : points) {
        CHECK(mesh.visibility(p.position, p.normal, 4) >= 0.0f);
        mesh.visibility(p.position, p.normal, std::span<float>{all}, &cold);
    }
    REQUIRE(cold.shadow_rays == 0);
    for (const auto& [segment, times] : count.segments)
        CHECK(times == 1);
    const lightmesh::MeshStatistics held = mesh.statistics();
    CHECK(held.long_rays == count.rays);
    CHECK(held.long_tests <= held.light_points * lights.size());

    for (const test::SurfacePoint& p : points)
        mesh.visibility(p.position, p.normal, std::span<float>{all});
    CHECK(mesh.statistics().long_rays == held.long_rays);
    CHECK(mesh.statistics().light_points == held.light_points);
    CHECK(mesh.statistics().bytes == held.bytes);
    CHECK(count.rays == held.long_rays);
}

TEST_CASE("light points, bricks and bytes are those of the space that was touched") {
    const std::vector<test::Triangle> scene;
    const std::vector<lightmesh::Light> lights{lightmesh::PointLight{{0, 0, 9}}};
    const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights,
                                    settings_of(1.0f, 4.0f, ShortTest::none)};
    const lightmesh::MeshStatistics empty = mesh.statistics();
    CHECK(empty.light_points == 0);
    CHECK(empty.bricks == 0);
    CHECK(empty.long_tests == 0);
    CHECK(empty.bytes > 0);

    CHECK(mesh.visibility({0, 0, 0}, {0, 0, 1}, 0) == 1.0f);
    const lightmesh::MeshStatistics once = mesh.statistics();
    const test::PlainMesh plain(scene, lights, mesh.grid().origin(), mesh.grid().step(), 4.0,
                                ShortTest::none);
    const std::size_t m = plain.neighbours({0, 0, 0}, {0, 0, 1}).size();
    CHECK(once.light_points >= m);
    CHECK(once.light_points <= 5 * m);  // Cells of 2x2x2 are filled as a whole.
    CHECK(once.light_points <= 64 * once.bricks);
    CHECK(once.bricks >= 2);
    CHECK(once.bytes >= empty.bytes);

    for (int i = 1; i < 100; ++i)
        CHECK(mesh.visibility({5.0f * static_cast<float>(i), 0, 0}, {0, 0, 1}, 0) == 1.0f);
    const lightmesh::MeshStatistics far_apart = mesh.statistics();
    CHECK(far_apart.light_points > 50 * once.light_points);
    CHECK(far_apart.light_points < 200 * once.light_points);
    CHECK(far_apart.bytes > once.bytes + far_apart.light_points / 8);
}

TEST_CASE("a point without neighbours costs one shadow ray for each light that reaches it") {
    std::vector<test::Triangle> lid;  // A flat box around the origin, so low that no light point is inside.
    test::add_box(lid, {-1, -1, -0.001}, {1, 1, 0.002});
    const std::vector<lightmesh::Light> lights{
        lightmesh::PointLight{{0, 0, 5}}, lightmesh::PointLight{{0, 0, -5}}, lightmesh::PointLight{{3, 0, 5}},
        lightmesh::PointLight{{0, 0, 5}, 2.0f}, lightmesh::PointLight{{0.5f, 0, 0.0019f}}};
    Count count;
    lightmesh::Settings settings = settings_of(0.5f, 2.0f, ShortTest::exact);
    settings.origin = glm::vec3(0.125f);
    const lightmesh::LightMesh mesh{CountingTracer{&lid, &count}, lights, settings};
    const std::vector<float> expected{0.0f, 0.0f, 0.0f, 0.0f, 1.0f};

    QueryStatistics statistics;
    std::vector<float> all(lights.size());
    mesh.visibility({0, 0, 0}, {0, 0, 1}, std::span<float>{all}, &statistics);
    CHECK(all == expected);
    CHECK(statistics.empty_points == 1);
    CHECK(statistics.shadow_rays == 3);

    for (std::size_t light = 0; light < lights.size(); ++light) {
        QueryStatistics one;
        CAPTURE(light);
        CHECK(mesh.visibility({0, 0, 0}, {0, 0, 1}, light, &one) == expected[light]);
        const bool reaches = light != 1 && light != 3;
        CHECK(one.empty_points == (reaches ? 1 : 0));
        CHECK(one.shadow_rays == (reaches ? 1 : 0));
    }

    // Without a hemisphere there is nothing to test either.
    QueryStatistics bare;
    const std::uint64_t before = count.rays;
    mesh.visibility({0, 0, 2.5f}, {0, 0, 0}, std::span<float>{all}, &bare);
    CHECK(bare.empty_points == 1);
    CHECK(bare.short_rays == 0);
    CHECK(bare.shadow_rays == 4);
    CHECK(count.rays - before == 4);
}

}  // namespace statistics_test
