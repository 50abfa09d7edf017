// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/light_order.hpp>
#include <lightmesh/mesh/light_shape.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

// What a light reaches, and that nothing is spent on what it does not reach.

namespace lights_test {

namespace {

using lightmesh::Light;
using lightmesh::ShortTest;

struct CountingTracer {
    const std::vector<test::Triangle>* triangles;
    std::uint64_t* rays;

    bool occluded(const lightmesh::Segment& segment) const {
        ++*rays;
        return test::PlainTracer{triangles}.occluded(segment);
    }
};

lightmesh::Settings settings_of(ShortTest short_test) {
    lightmesh::Settings settings;
    settings.radius = 1.0f;
    settings.adaptive_long_tests = false;
    settings.quality = 3.0f;
    settings.short_test = short_test;
    return settings;
}

constexpr glm::vec3 up(0.0f, 0.0f, 1.0f);

/// S of a point of the open floor, by both queries, on a cold mesh; `rays` is what it cost.
float on_open_floor(const Light& light, const glm::vec3& point, ShortTest short_test, std::uint64_t& rays) {
    std::vector<test::Triangle> floor;
    test::add_quad(floor, {-50, -50, 0}, {100, 0, 0}, {0, 100, 0});
    rays = 0;
    const std::vector<Light> lights{light};
    const lightmesh::LightMesh mesh{CountingTracer{&floor, &rays}, lights, settings_of(short_test)};
    std::vector<float> all(1);
    mesh.visibility(point, up, std::span<float>{all});
    CHECK(mesh.visibility(point, up, std::size_t{0}) == all[0]);
    return all[0];
}

void check_lit(const Light& light, const glm::vec3& point) {
    for (const ShortTest short_test : test::all_short_tests) {
        std::uint64_t rays = 0;
        CHECK(on_open_floor(light, point, short_test, rays) == 1.0f);
        CHECK(rays > 0);
    }
}

/// Dark, and known to be without a ray.
void check_unreached(const Light& light, const glm::vec3& point) {
    for (const ShortTest short_test : test::all_short_tests) {
        std::uint64_t rays = 0;
        CHECK(on_open_floor(light, point, short_test, rays) == 0.0f);
        CHECK(rays == 0);
    }
}

}  // namespace

TEST_CASE("points out of a light's range are dark and cost no ray") {
    const lightmesh::PointLight lamp{{0, 0, 3}, 5.0f};
    check_lit(lamp, {3.99f, 0, 0});
    check_unreached(lamp, {4.01f, 0, 0});
    check_unreached(lamp, {0, -30, 0});
    const lightmesh::SpotLight spot{{0, 0, 3}, {0, 0, -1}, 1.5f, 5.0f};
    check_lit(spot, {0, 3.99f, 0});
    check_unreached(spot, {0, 4.01f, 0});
    check_lit(lightmesh::PointLight{{0, 0, 3}}, {40, 0, 0});
}

TEST_CASE("points outside a spot light's cone are dark and cost no ray") {
    const lightmesh::SpotLight straight{{0, 0, 4}, {0, 0, -2}, std::numbers::pi_v<float> / 4.0f};
    for (const float angle : {0.1f, 1.0f, 2.5f, 4.0f}) {
        const glm::vec3 way(std::cos(angle), std::sin(angle), 0.0f);
        check_lit(straight, 3.99f * way);
        check_unreached(straight, 4.01f * way);
    }
    // More than half of all directions.
    const lightmesh::SpotLight wide{{0, 0, 4}, {0, 0, 0.01f}, 2.5f};
    check_unreached(wide, {1, 0, 0});
    check_lit(wide, {6, 0, 0});
    // Points below the light are in the cone of any axis if it is whole.
    check_lit(lightmesh::SpotLight{{0, 0, 4}, {0, 0, 1}, std::numbers::pi_v<float>}, {0.5f, 0, 0});
}

TEST_CASE("points that face away from a light are dark and cost no ray") {
    check_unreached(lightmesh::PointLight{{1, 2, -3}}, {0, 0, 0});
    check_unreached(lightmesh::DirectionalLight{{0.3f, 0, 1}}, {0, 0, 0});
    check_unreached(lightmesh::SpotLight{{0, 0, -4}, {0, 0, 1}, 1.0f}, {0, 0, 0});
    check_lit(lightmesh::DirectionalLight{{0.3f, 0, -1}}, {0, 0, 0});
}

TEST_CASE("chi is 1 for a light in the tangent plane") {
    const std::vector<test::Triangle> nothing;
    const std::vector<Light> lights{lightmesh::PointLight{{3, 0, 0}}, lightmesh::DirectionalLight{{0, 1, 0}}};
    for (const ShortTest short_test : test::all_short_tests) {
        const lightmesh::LightMesh mesh{test::PlainTracer{&nothing}, lights, settings_of(short_test)};
        CHECK(mesh.visibility({0, 0, 0}, up, 0) == 1.0f);
        CHECK(mesh.visibility({0, 0, 0}, up, 1) == 1.0f);
    }
}

TEST_CASE("lights whose range ends far away cost no long tests") {
    const std::vector<test::Triangle> nothing;
    std::vector<Light> lights;
    for (int i = 0; i < 20; ++i)
        lights.push_back(lightmesh::PointLight{{10.0f * static_cast<float>(i), 0, 2}, 4.0f});
    std::uint64_t rays = 0;
    const lightmesh::LightMesh mesh{CountingTracer{&nothing, &rays}, lights, settings_of(ShortTest::none)};
    std::vector<float> all(lights.size());
    mesh.visibility({50, 0, 0}, up, std::span<float>{all});
    for (std::size_t i = 0; i < lights.size(); ++i)
        CHECK(all[i] == (i == 5 ? 1.0f : 0.0f));
    CHECK(rays == mesh.statistics().light_points);  // Only light 5.
}

TEST_CASE("a directional light casts its shadow along its direction") {
    std::vector<test::Triangle> roof;
    test::add_quad(roof, {-3, -3, 5}, {6, 0, 0}, {0, 6, 0});
    for (const float length : {1e-20f, 1.0f, 1e20f}) {
        const std::vector<Light> lights{lightmesh::DirectionalLight{length * glm::vec3(1, 0, -1)}};
        const lightmesh::LightMesh mesh{test::PlainTracer{&roof}, lights, settings_of(ShortTest::none)};
        CHECK(mesh.visibility({5, 0, 0}, up, 0) == 0.0f);
        CHECK(mesh.visibility({5.9f, 1.9f, 0}, up, 0) == 0.0f);
        CHECK(mesh.visibility({0, 0, 0}, up, 0) == 1.0f);
        CHECK(mesh.visibility({10, 0, 0}, up, 0) == 1.0f);
        const float edge = mesh.visibility({8, 0, 0}, up, 0);
        CHECK(edge > 0.1f);
        CHECK(edge < 0.9f);
    }
}

TEST_CASE("a whole cone is a point light, and a light twice is a light") {
    test::Random random(51);
    const auto scene = test::boxes_on_floor(random, 3);
    const glm::vec3 place(0.3f, 0.2f, 4.0f);
    const std::vector<Light> lights{
        lightmesh::PointLight{place},
        lightmesh::SpotLight{place, {1, 0, 0}, std::numbers::pi_v<float>},
        lightmesh::PointLight{place},
        lightmesh::PointLight{place, 1000.0f},
    };
    const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights, settings_of(ShortTest::exact)};
    std::vector<float> all(lights.size());
    for (const test::SurfacePoint& p : test::surface_points(random, scene, 100)) {
        mesh.visibility(p.position, p.normal, std::span<float>{all});
        for (const float s : all)
            CHECK(s == all[0]);
    }
}

TEST_CASE("a light has the same values alone and among others, wherever it is kept") {
    test::Random random(52);
    const auto scene = test::boxes_on_floor(random, 4);
    const auto points = test::surface_points(random, scene, 60);
    const std::vector<Light> lights = test::random_lights(random, 150);
    for (const ShortTest short_test : test::all_short_tests) {
        const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights, settings_of(short_test)};
        for (std::size_t i = 0; i < lights.size(); i += 7) {
            const std::vector<Light> one{lights[i]};
            const lightmesh::LightMesh alone{test::PlainTracer{&scene}, one, settings_of(short_test)};
            for (const test::SurfacePoint& p : points) {
                std::vector<float> all(lights.size(), -1.0f);
                mesh.visibility(p.position, p.normal, std::span<float>{all});
                CHECK(all[i] == alone.visibility(p.position, p.normal, 0));
                CHECK(all[i] == mesh.visibility(p.position, p.normal, i));
            }
        }
    }
}

TEST_CASE("lights are kept as given, but those with a range stand last, neighbours together") {
    using lightmesh::detail::LightOrder;
    using lightmesh::detail::LightShape;
    using lightmesh::detail::shape_of;
    const std::vector<LightShape> endless{shape_of(lightmesh::PointLight{{5, 0, 0}}),
                                          shape_of(lightmesh::DirectionalLight{}),
                                          shape_of(lightmesh::PointLight{{1, 0, 0}})};
    CHECK(LightOrder(endless).is_given());

    // Two clusters far apart, in turn, and two lights without a range among them.
    std::vector<LightShape> lights;
    for (int i = 0; i < 40; ++i) {
        const float x = (i % 2 == 0 ? 0.0f : 100.0f) + 0.1f * static_cast<float>(i);
        if (i == 7 || i == 30)
            lights.push_back(shape_of(lightmesh::PointLight{{x, 0, 0}}));
        else
            lights.push_back(shape_of(lightmesh::PointLight{{x, 0, 0}, 2.0f}));
    }
    const LightOrder order(lights);
    CHECK_FALSE(order.is_given());
    CHECK(order.light_at(0) == 7);
    CHECK(order.light_at(1) == 30);
    std::vector<bool> seen(lights.size());
    for (std::size_t slot = 0; slot < lights.size(); ++slot) {
        const std::size_t light = order.light_at(slot);
        CHECK(order.slot_of(light) == slot);
        CHECK_FALSE(seen[light]);
        seen[light] = true;
        if (slot >= 2)
            CHECK((light % 2 == 1) == (slot >= 2 + 19));
    }
}

}  // namespace lights_test
