// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/shadow_rays.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

// Inputs that once came out wrong: cracks, lamps far away, cones and ranges at the ends of what floats hold.

namespace traps_test {

namespace {

using lightmesh::Light;
using lightmesh::LightMesh;
using lightmesh::Settings;
using lightmesh::ShortTest;

struct OpenSpace {
    bool occluded(const lightmesh::Segment&) const { return false; }
};

std::string error_of(const Light& light, const Settings& settings = {}) {
    try {
        const std::vector<Light> lights{light};
        const LightMesh mesh{OpenSpace{}, lights, settings};
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

float lit(const Light& light, const glm::vec3& point, const glm::vec3& normal, Settings settings = {}) {
    settings.short_test = ShortTest::none;
    const std::vector<Light> lights{light};
    const LightMesh mesh{OpenSpace{}, lights, settings};
    std::vector<float> all(1);
    mesh.visibility(point, normal, std::span<float>(all));
    CHECK(mesh.visibility(point, normal, std::size_t{0}) == all[0]);
    return all[0];
}

}  // namespace

TEST_CASE("at a crack to a dark hollow linked stays near to exact") {
    // A wall whose lower edge stands a crack over the floor, a closed hollow behind it, lamps before it.
    for (const double crack : {0.0, 0.03, 0.05}) {
        CAPTURE(crack);
        std::vector<test::Triangle> scene;
        test::add_quad(scene, {-5, -5, 0}, {10, 0, 0}, {0, 10, 0});
        test::add_quad(scene, {-3, 0, crack}, {6, 0, 0}, {0, 0, 3});
        test::add_quad(scene, {-3, 0.6, 0}, {6, 0, 0}, {0, 0, 3});
        test::add_quad(scene, {-3, 0, 1}, {6, 0, 0}, {0, 0.6, 0});
        test::add_quad(scene, {-3, 0, 0}, {0, 0.6, 0}, {0, 0, 3});
        test::add_quad(scene, {3, 0, 0}, {0, 0.6, 0}, {0, 0, 3});
        std::vector<Light> lights;
        for (int i = 0; i < 12; ++i)
            lights.push_back(lightmesh::PointLight{
                {-2.5f + 0.45f * static_cast<float>(i), -2.0f - 0.1f * static_cast<float>(i % 3), 1.5f}});
        Settings settings{.radius = 0.5f, .quality = 4.0f, .short_test = ShortTest::linked};
        const LightMesh linked{test::PlainTracer{&scene}, lights, settings};
        settings.short_test = ShortTest::exact;
        const LightMesh exact{test::PlainTracer{&scene}, lights, settings};
        std::vector<float> a(lights.size());
        std::vector<float> b(lights.size());
        float largest = 0.0f;
        for (int i = 0; i < 240; ++i) {
            const glm::vec3 point(-2.4f + 0.02f * static_cast<float>(i),
                                  -0.01f - 0.004f * static_cast<float>(i % 7), 0.0f);
            linked.visibility(point, {0, 0, 1}, std::span<float>(a));
            exact.visibility(point, {0, 0, 1}, std::span<float>(b));
            for (std::size_t l = 0; l < a.size(); ++l)
                largest = (std::max)(largest, std::abs(a[l] - b[l]));
        }
        CHECK(largest < 0.2f);
    }
}

TEST_CASE("in a hollow thinner than a step the shadow ray decides, though all light points around agree") {
    const Settings settings{.radius = 1.0f, .quality = 2.0f, .short_test = ShortTest::linked};
    // A box on a floor, in the middle of a cell of the grid: no link and no long test meets it but the second
    // lamp's, which is in the box.
    const glm::vec3 point = glm::vec3(lightmesh::Grid(settings).position({0, 0, 0})) + glm::vec3(0.25f);
    std::vector<test::Triangle> scene;
    test::add_quad(scene, test::Vec(point) - test::Vec(9, 9, 0), {18, 0, 0}, {0, 18, 0});
    test::add_box(scene, test::Vec(point) - test::Vec(0.02, 0.02, 0.01),
                  test::Vec(point) + test::Vec(0.02, 0.02, 0.02));
    const std::vector<Light> lights{lightmesh::PointLight{point + glm::vec3(0.3f, 0.2f, 6.0f)},
                                    lightmesh::PointLight{point + glm::vec3(0.0f, 0.0f, 0.01f)}};
    for (const ShortTest short_test : test::all_short_tests) {
        Settings chosen = settings;
        chosen.short_test = short_test;
        const LightMesh mesh{test::PlainTracer{&scene}, lights, chosen};
        std::vector<float> all(2);
        // The second time all is known.
        for (int i = 0; i < 2; ++i) {
            mesh.visibility(point, {0, 0, 1}, std::span<float>(all));
            CHECK(all ==
                  (short_test == ShortTest::none ? std::vector<float>{1, 0} : std::vector<float>{0, 1}));
            for (std::size_t l = 0; l < 2; ++l)
                CHECK(mesh.visibility(point, {0, 0, 1}, l) == all[l]);
        }
        // Beside the box it is as without: all light points around are those of the point in it.
        const glm::vec3 beside = point + glm::vec3(0.05f, 0.0f, 0.0f);
        mesh.visibility(beside, {0, 0, 1}, std::span<float>(all));
        CHECK(all == std::vector<float>{1, 0});
    }
}

TEST_CASE("a lamp at any distance equals the sun that it stands for") {
    std::vector<test::Triangle> scene;
    test::add_quad(scene, {-4, -4, 0}, {8, 0, 0}, {0, 8, 0});
    test::add_box(scene, {-0.5, -0.5, 0.0}, {0.5, 0.5, 1.0});
    test::add_quad(scene, {-2, 1, 0.7}, {1.2, 0, 0}, {0, 1.2, 0.2});
    const glm::vec3 to_sun = glm::normalize(glm::vec3(0.4f, -0.3f, 0.8f));
    test::Random random(17);
    std::vector<test::SurfacePoint> points;
    for (int i = 0; i < 200; ++i)
        points.push_back({glm::vec3(random.in_box({-2, -2, 0}, {2, 2, 0})), {0, 0, 1}});
    for (const ShortTest short_test : test::all_short_tests) {
        const Settings settings{.radius = 0.3f, .quality = 3.0f, .short_test = short_test};
        const std::vector<Light> sun{lightmesh::DirectionalLight{-to_sun}};
        const LightMesh expected{test::PlainTracer{&scene}, sun, settings};
        for (const float distance : {1e5f, 1e6f, 1e7f, 1.5e8f, 1.5e11f, 1e20f, 3e38f}) {
            CAPTURE(distance);
            const std::vector<Light> lamp{lightmesh::PointLight{distance * to_sun}};
            const LightMesh mesh{test::PlainTracer{&scene}, lamp, settings};
            double difference = 0.0;
            double mean = 0.0;
            for (const test::SurfacePoint& p : points) {
                const float s = expected.visibility(p.position, p.normal, std::size_t{0});
                mean += static_cast<double>(s) / 200.0;
                difference +=
                    static_cast<double>(std::abs(mesh.visibility(p.position, p.normal, std::size_t{0}) - s)) /
                    200.0;
            }
            CHECK(difference < 0.002);
            CHECK(mean > 0.5);
            CHECK(mean < 0.97);
        }
    }
}

TEST_CASE("a cone of pi passes everything, narrow ones exactly what they hold") {
    test::Random random(18);
    for (int i = 0; i < 300; ++i) {
        const glm::vec3 axis(random.direction());
        const lightmesh::SpotLight everything{{0, 0, 0}, axis, std::numbers::pi_v<float>};
        CHECK(lit(everything, -2.5f * axis, axis) == 1.0f);
        const glm::vec3 across = glm::normalize(glm::cross(axis, glm::vec3(random.direction())));
        for (const float cone : {1e-4f, 3e-3f, 0.5f, 1.5f, 2.0f, 3.1f}) {
            CAPTURE(cone);
            const lightmesh::SpotLight spot{{0, 0, 0}, axis, cone};
            const auto at = [&](double angle) {
                return 3.0f * (static_cast<float>(std::cos(angle)) * axis +
                               static_cast<float>(std::sin(angle)) * across);
            };
            const double edge = static_cast<double>(cone);
            const double little = 0.01 * (std::min)(edge, std::numbers::pi - edge);
            CHECK(lit(spot, at(edge - little), -at(edge - little)) == 1.0f);
            CHECK(lit(spot, at(edge + little), -at(edge + little)) == 0.0f);
        }
    }
}

TEST_CASE("ranges neither overflow nor underflow") {
    for (const float scale : {1e17f, 1.0f, 1e-17f, 1e-24f}) {
        CAPTURE(scale);
        const lightmesh::PointLight lamp{{0, 0, 0}, scale};
        const Settings settings{.radius = scale, .quality = 2.0f};
        CHECK(lit(lamp, {0.99f * scale, 0, 0}, {-1, 0, 0}, settings) == 1.0f);
        CHECK(lit(lamp, {1.00001f * scale, 0, 0}, {-1, 0, 0}, settings) == 0.0f);
        CHECK(lit(lamp, {3.0f * scale, 0, 0}, {-1, 0, 0}, settings) == 0.0f);
    }
    CHECK(error_of(lightmesh::PointLight{{0, 0, 0}, 2e18f}).find("range is") != std::string::npos);
    CHECK(error_of(lightmesh::PointLight{{0, 0, 0}, std::numeric_limits<float>::infinity()}).empty());
    CHECK(error_of(lightmesh::PointLight{{3e38f, 0, 0}}).empty());
    CHECK(error_of(lightmesh::PointLight{}, Settings{.radius = 2e18f}).find("radius is") !=
          std::string::npos);
    CHECK(error_of(lightmesh::PointLight{}, Settings{.origin = glm::vec3(2e18f)}).find("origin is") !=
          std::string::npos);
}

TEST_CASE("a rectangle shines to its front only, as from its centre") {
    const lightmesh::RectLight pane{{0, 0, 2}, {0, 0.5f, 0}, {0.5f, 0, 0}};  // shines down
    CHECK(lit(pane, {0, 0, 0}, {0, 0, 1}) == 1.0f);
    CHECK(lit(pane, {0, 0, 4}, {0, 0, -1}) == 0.0f);
    CHECK(lit(pane, {3, 0, 2}, {-1, 0, 0}) == 0.0f);  // on its plane
    CHECK(lit(pane, {0, 0, 0}, {0, 0, -1}) == 0.0f);  // faces away
    CHECK(lit(lightmesh::RectLight{{0, 0, 2}, {0, 0.5f, 0}, {0.5f, 0, 0}, 1.0f}, {0, 0, 0}, {0, 0, 1}) ==
          0.0f);
    CHECK(error_of(lightmesh::RectLight{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}}).find("half_u") !=
          std::string::npos);
    CHECK(error_of(lightmesh::RectLight{{0, 0, 0}, {1, 1, 0}, {-2, -2, 0}}).find("not parallel") !=
          std::string::npos);
    CHECK(error_of(lightmesh::PointLight{.radius = -1.0f}).find("radius is -1") != std::string::npos);
    CHECK(error_of(lightmesh::DirectionalLight{.angular_radius = 1.6f}).find("angular_radius") !=
          std::string::npos);
}

TEST_CASE("shadow rays are those of a mesh without neighbours") {
    test::Random random(19);
    const std::vector<test::Triangle> scene = test::boxes_on_floor(random, 6);
    const std::vector<Light> lights = test::random_lights(random, 20);
    const Settings settings{.radius = 0.5f, .quality = 1.0f};
    const LightMesh mesh{test::PlainTracer{&scene}, lights, settings};
    const lightmesh::ShadowRays rays(lights, 0.5f);
    CHECK(rays.size() == 20);
    for (const test::SurfacePoint& p : test::surface_points(random, scene, 50)) {
        std::vector<float> expected(20, 0.0f);
        rays.for_each(p.position, 3.0f * p.normal, [&](std::size_t light, const lightmesh::Segment& segment) {
            CHECK(rays.can_light(light, p.position, p.normal));
            const lightmesh::Segment same = rays.segment(light, p.position, p.normal);
            CHECK(same.origin == segment.origin);
            CHECK(same.target == segment.target);
            expected[light] = test::PlainTracer{&scene}.occluded(segment) ? 0.0f : 1.0f;
        });
        for (std::size_t l = 0; l < 20; ++l)
            if (!rays.can_light(l, p.position, p.normal))
                CHECK(mesh.visibility(p.position, p.normal, l) == 0.0f);
    }
    CHECK_THROWS_AS(lightmesh::ShadowRays(lights, 0.0f), std::invalid_argument);
}

}  // namespace traps_test
