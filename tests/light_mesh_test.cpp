// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>

#include <doctest/doctest.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

// The library against equations (2) and (3) written plainly (plain.hpp), on random scenes.

namespace light_mesh_test {

namespace {

using lightmesh::ShortTest;

struct Case {
    std::string name;
    std::vector<test::Triangle> scene;
    float radius;
    float quality;
    int points;
    glm::vec3 origin = lightmesh::Settings{}.origin;
};

/// Boxes on a floor, all sides of which lie on planes of the grid with origin 0 and this step.
std::vector<test::Triangle> boxes_on_grid_planes(test::Random& random, double step) {
    std::vector<test::Triangle> scene = test::boxes_on_floor(random, 4);
    for (test::Triangle& t : scene)
        for (test::Vec* corner : {&t.a, &t.b, &t.c})
            *corner = glm::round(*corner / step) * step;
    return scene;
}

std::vector<Case> cases() {
    test::Random random(2013);
    std::vector<Case> all;
    all.push_back({"soup, q = 1", test::triangle_soup(random, 30), 1.5f, 1.0f, 600});
    all.push_back({"soup, q = 3", test::triangle_soup(random, 30), 1.0f, 3.0f, 300});
    all.push_back({"boxes, q = 2", test::boxes_on_floor(random, 3), 1.2f, 2.0f, 500});
    all.push_back({"boxes, q = 4.5", test::boxes_on_floor(random, 3), 1.3f, 4.5f, 150});
    all.push_back({"walls, q = 2.5", test::thin_walls(random), 0.9f, 2.5f, 400});
    all.push_back({"walls, q = 4", test::thin_walls(random), 2.0f, 4.0f, 150});
    all.push_back({"walls, q = 9", test::thin_walls(random), 0.5f, 9.0f, 20});
    all.push_back(
        {"grid planes, q = 4", boxes_on_grid_planes(random, 0.25), 1.0f, 4.0f, 150, glm::vec3(0.0f)});
    return all;
}

struct Tally {
    int all = 0, sure = 0, between = 0;
};

/// Checks every point and light of a case, one light at a time and all at once.
Tally compare(const Case& c, ShortTest short_test, std::uint64_t seed) {
    test::Random random(seed);
    const std::vector<lightmesh::Light> lights = test::random_lights(random, 6);
    lightmesh::Settings settings;
    settings.radius = c.radius;
    settings.adaptive_long_tests = false;
    settings.quality = c.quality;
    settings.short_test = short_test;
    settings.origin = c.origin;
    const lightmesh::LightMesh mesh{test::PlainTracer{&c.scene}, lights, settings};
    const test::PlainMesh plain(c.scene, lights, mesh.grid().origin(), mesh.grid().step(), c.quality,
                                short_test);
    Tally tally;
    std::vector<float> all(lights.size());
    for (const test::SurfacePoint& p : test::surface_points(random, c.scene, c.points)) {
        const auto neighbours = plain.neighbours(p.position, p.normal);
        mesh.visibility(p.position, p.normal, std::span<float>{all});
        for (std::size_t light = 0; light < lights.size(); ++light) {
            CAPTURE(light);
            CAPTURE(p.position.x);
            CAPTURE(p.position.y);
            CAPTURE(p.position.z);
            const float one = mesh.visibility(p.position, p.normal, light);
            CHECK(std::bit_cast<std::uint32_t>(one) == std::bit_cast<std::uint32_t>(all[light]));
            const test::Interval expected = plain.visibility(p.position, p.normal, neighbours, light);
            CAPTURE(expected.low);
            CAPTURE(expected.high);
            CAPTURE(one);
            CHECK(expected.contains(one));
            ++tally.all;
            if (expected.is_sure())
                ++tally.sure;
            if (expected.is_sure() && one > 0.0f && one < 1.0f)
                ++tally.between;
        }
    }
    return tally;
}

void compare_all(ShortTest short_test) {
    Tally sum;
    std::uint64_t seed = 100;
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const Tally tally = compare(c, short_test, ++seed);
        // The doubts of plain.hpp must not swallow the test.
        CHECK(tally.sure > tally.all / 2);
        sum.all += tally.all;
        sum.sure += tally.sure;
        sum.between += tally.between;
    }
    MESSAGE(sum.all << " visibilities, sure: " << sum.sure << ", of these in penumbra: " << sum.between);
    CHECK(sum.sure > sum.all * 95 / 100);
    CHECK(sum.between > 500);
}

}  // namespace

TEST_CASE("exact short tests equal the equations, one light and all lights") {
    compare_all(ShortTest::exact);
}

TEST_CASE("Express equals the equations without short tests, one light and all lights") {
    compare_all(ShortTest::none);
}

TEST_CASE("linked short tests equal a plain flood, one light and all lights") {
    compare_all(ShortTest::linked);
}

TEST_CASE("the number of lights does not change a light's value") {
    test::Random random(7);
    const std::vector<test::Triangle> scene = test::boxes_on_floor(random, 3);
    const std::vector<lightmesh::Light> lights = test::random_lights(random, 150);
    const std::vector<test::SurfacePoint> points = test::surface_points(random, scene, 20);
    for (const ShortTest short_test : test::all_short_tests) {
        lightmesh::Settings settings;
        settings.radius = 0.8f;
        settings.adaptive_long_tests = false;
        settings.quality = 2.0f;
        settings.short_test = short_test;
        const lightmesh::LightMesh many{test::PlainTracer{&scene}, lights, settings};
        std::vector<float> all(lights.size());
        for (const std::size_t count : {1u, 7u, 8u, 9u, 63u, 64u, 65u, 128u, 150u}) {
            const std::vector<lightmesh::Light> first(lights.begin(),
                                                      lights.begin() + static_cast<long>(count));
            const lightmesh::LightMesh few{test::PlainTracer{&scene}, first, settings};
            CHECK(few.light_count() == count);
            std::vector<float> values(count);
            for (const test::SurfacePoint& p : points) {
                many.visibility(p.position, p.normal, std::span<float>{all});
                few.visibility(p.position, p.normal, std::span<float>{values});
                for (std::size_t i = 0; i < count; ++i) {
                    CAPTURE(count);
                    CAPTURE(i);
                    CHECK(values[i] == all[i]);
                    CHECK(few.visibility(p.position, p.normal, i) == all[i]);
                }
            }
        }
    }
}

TEST_CASE("a mesh without lights answers for all of its lights") {
    const std::vector<test::Triangle> scene;
    const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, std::vector<lightmesh::Light>{},
                                    lightmesh::Settings{}};
    CHECK(mesh.light_count() == 0);
    std::vector<float> all;
    CHECK_NOTHROW(mesh.visibility({1, 2, 3}, {0, 0, 1}, std::span<float>{all}));
}

}  // namespace light_mesh_test
