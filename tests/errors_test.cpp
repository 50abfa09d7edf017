// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

// Bad input is named, bad queries have a documented result.

namespace errors_test {

namespace {

using lightmesh::Light;
using lightmesh::Settings;
using lightmesh::ShortTest;

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

const std::vector<test::Triangle> nothing;
const std::vector<Light> one_lamp{lightmesh::PointLight{{0, 0, 5}}};

lightmesh::LightMesh<test::PlainTracer> make(const std::vector<Light>& lights, const Settings& settings) {
    return {test::PlainTracer{&nothing}, lights, settings};
}

/// What `action` says when it throws an Error; empty if it does not throw one.
template <class Error, class Action>
std::string message_of(Action&& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

std::string message_for(const Settings& settings) {
    return message_of<std::invalid_argument>([&] { make(one_lamp, settings); });
}

std::string message_for(const Light& light) {
    const std::vector<Light> lights{one_lamp.front(), light};
    return message_of<std::invalid_argument>([&] { make(lights, {}); });
}

/// An adapter that fails as often as it is told to.
struct FailingTracer {
    int* failures;

    bool occluded(const lightmesh::Segment& segment) const {
        if (*failures > 0) {
            --*failures;
            throw std::runtime_error("the tracer failed");
        }
        return segment.origin.x < 0.25f;
    }
};

}  // namespace

TEST_CASE("a radius out of range is named") {
    struct Bad {
        float value;
        const char* text;
    };
    for (const auto& [value, text] :
         {Bad{0.0f, "0"}, Bad{-1.5f, "-1.5"}, Bad{not_a_number, "nan"}, Bad{infinity, "inf"}}) {
        Settings settings;
        settings.radius = value;
        const std::string message = message_for(settings);
        CAPTURE(message);
        CHECK(contains(message, "lightmesh"));
        CHECK(contains(message, "radius"));
        CHECK(contains(message, text));
    }
}

TEST_CASE("a quality out of range is named") {
    struct Bad {
        float value;
        const char* text;
    };
    for (const auto& [value, text] : {Bad{0.5f, "0.5"}, Bad{-2.0f, "-2"}, Bad{16.5f, "16.5"},
                                      Bad{not_a_number, "nan"}, Bad{infinity, "inf"}, Bad{0.0f, "0"}}) {
        Settings settings;
        settings.quality = value;
        const std::string message = message_for(settings);
        CAPTURE(message);
        CHECK(contains(message, "quality"));
        CHECK(contains(message, text));
    }
    for (const float fine : {1.0f, 16.0f, 3.7f}) {
        Settings settings;
        settings.quality = fine;
        CHECK_NOTHROW(make(one_lamp, settings));
    }
}

TEST_CASE("an origin that is infinite or only partly NaN is named") {
    for (const glm::vec3& origin : {glm::vec3(0, infinity, 0), glm::vec3(not_a_number, 0, 0),
                                    glm::vec3(not_a_number, not_a_number, 1)}) {
        Settings settings;
        settings.origin = origin;
        CHECK(contains(message_for(settings), "origin"));
    }
    Settings settings;
    settings.origin = {not_a_number, 12.5f, 0};
    CHECK(contains(message_for(settings), "12.5"));
}

TEST_CASE("a light that is not finite or out of range is named with its number") {
    struct Bad {
        Light light;
        const char* what;
        const char* value;
    };
    const std::vector<Bad> all{
        {lightmesh::PointLight{{not_a_number, 0, 0}}, "position", "nan"},
        {lightmesh::PointLight{{0, infinity, 0}}, "position", "inf"},
        {lightmesh::PointLight{{0, 0, 1}, -3.5f}, "range", "-3.5"},
        {lightmesh::PointLight{{0, 0, 1}, not_a_number}, "range", "nan"},
        {lightmesh::DirectionalLight{{0, 0, 0}}, "direction", "(0, 0, 0)"},
        {lightmesh::DirectionalLight{{0, not_a_number, 1}}, "direction", "nan"},
        {lightmesh::DirectionalLight{{-infinity, 0, 0}}, "direction", "-inf"},
        {lightmesh::SpotLight{{not_a_number, 0, 0}}, "position", "nan"},
        {lightmesh::SpotLight{{0, 0, 1}, {0, 0, 0}}, "axis", "(0, 0, 0)"},
        {lightmesh::SpotLight{{0, 0, 1}, {0, not_a_number, 1}}, "axis", "nan"},
        {lightmesh::SpotLight{{0, 0, 1}, {0, 0, 1}, 0.0f}, "cone", "0"},
        {lightmesh::SpotLight{{0, 0, 1}, {0, 0, 1}, -0.5f}, "cone", "-0.5"},
        {lightmesh::SpotLight{{0, 0, 1}, {0, 0, 1}, 3.25f}, "cone", "3.25"},
        {lightmesh::SpotLight{{0, 0, 1}, {0, 0, 1}, not_a_number}, "cone", "nan"},
        {lightmesh::SpotLight{{0, 0, 1}, {0, 0, 1}, 1.0f, -2.5f}, "range", "-2.5"},
    };
    for (const Bad& bad : all) {
        const std::string message = message_for(bad.light);
        CAPTURE(message);
        CAPTURE(std::string(bad.what));
        CHECK(contains(message, "light 1"));
        CHECK(contains(message, bad.what));
        CHECK(contains(message, bad.value));
    }
}

TEST_CASE("a light that is not there is named") {
    const auto mesh = make({3, one_lamp.front()}, {});
    for (const std::size_t light :
         {std::size_t{3}, std::size_t{77}, (std::numeric_limits<std::size_t>::max)()}) {
        const auto message = message_of<std::out_of_range>([&] {
            mesh.visibility({0, 0, 0}, {0, 0, 1}, light);
        });
        CAPTURE(message);
        CHECK(contains(message, std::to_string(light)));
        CHECK(contains(message, "3"));
    }
}

TEST_CASE("a span of the wrong size is named") {
    const auto mesh = make({70, one_lamp.front()}, {});
    for (const std::size_t size : {0u, 69u, 71u}) {
        std::vector<float> values(size, 7.0f);
        const auto message = message_of<std::invalid_argument>([&] {
            mesh.visibility({0, 0, 0}, {0, 0, 1}, std::span<float>{values});
        });
        CAPTURE(message);
        CHECK(contains(message, std::to_string(size)));
        CHECK(contains(message, "70"));
        for (const float v : values)
            CHECK(v == 7.0f);
    }
}

TEST_CASE("a point or normal that is not finite gives NaN for every light") {
    const auto mesh = make({66, one_lamp.front()}, {});
    struct Bad {
        glm::vec3 point, normal;
    };
    for (const float bad : {not_a_number, infinity, -infinity}) {
        for (int axis = 0; axis < 3; ++axis) {
            glm::vec3 point(0.0f);
            point[axis] = bad;
            glm::vec3 normal(0.0f, 0.0f, 1.0f);
            normal[axis] = bad;
            for (const Bad& query : {Bad{point, {0, 0, 1}}, Bad{{0, 0, 0}, normal}, Bad{point, normal}}) {
                std::vector<float> values(66, 7.0f);
                mesh.visibility(query.point, query.normal, std::span<float>{values});
                for (const float v : values)
                    CHECK(std::isnan(v));
                CHECK(std::isnan(mesh.visibility(query.point, query.normal, 65)));
            }
        }
    }
    CHECK(mesh.statistics().bricks == 0);
}

TEST_CASE("a zero normal gives the exact shadow ray, whatever side the light is on") {
    std::vector<test::Triangle> roof;
    test::add_quad(roof, {-2, -2, 2}, {4, 0, 0}, {0, 4, 0});
    const std::vector<Light> lights{lightmesh::PointLight{{0.5f, 0.25f, 6}},
                                    lightmesh::PointLight{{0.5f, 0.25f, -6}}};
    for (const ShortTest short_test : test::all_short_tests) {
        Settings settings;
        settings.short_test = short_test;
        const lightmesh::LightMesh mesh{test::PlainTracer{&roof}, lights, settings};
        for (int i = -8; i <= 8; ++i) {
            const glm::vec3 p(0.5f * static_cast<float>(i), 0.0f, 0.0f);
            std::vector<float> all(2);
            mesh.visibility(p, {0, 0, 0}, std::span<float>{all});
            const bool blocked = test::blocked(p, std::get<lightmesh::PointLight>(lights[0]).position, roof);
            CHECK(all[0] == (blocked ? 0.0f : 1.0f));
            CHECK(all[1] == 1.0f);
            CHECK(mesh.visibility(p, {0, 0, 0}, 0) == all[0]);
            CHECK(mesh.visibility(p, {0, 0, 0}, 1) == all[1]);
        }
        CHECK(mesh.statistics().long_rays == 0);
    }
}

TEST_CASE("a point outside the grid is named") {
    for (const float radius : {1.0f, 1e-3f}) {
        Settings settings;
        settings.radius = radius;
        const auto mesh = make(one_lamp, settings);
        for (const float x : {1.0e8f, -1.0e8f, 3.0e38f}) {
            std::vector<float> values(1);
            const auto message = message_of<std::out_of_range>([&] {
                mesh.visibility({0, x, 0}, {0, 0, 1}, std::span<float>{values});
            });
            CAPTURE(message);
            CHECK(contains(message, x > 1e30f  ? "e+38"
                                    : x > 0.0f ? "(0, 100000000, 0)"
                                               : "(0, -100000000, 0)"));
            CHECK(contains(message, "grid"));
            // One light and all lights agree, also where the light is behind the surface.
            CHECK_THROWS_AS(mesh.visibility({0, x, 0}, {0, 0, 1}, 0), std::out_of_range);
            CHECK_THROWS_AS(mesh.visibility({0, x, 0}, {0, 0, -1}, 0), std::out_of_range);
        }
        // Near to the edge all is well.
        CHECK(mesh.visibility({0, radius / 4.0f * 16.0e6f, 0}, {0, -1, 0}, 0) == 1.0f);
    }
}

TEST_CASE("the length of a normal does not matter") {
    test::Random random(11);
    const auto scene = test::boxes_on_floor(random, 3);
    const auto lights = test::random_lights(random, 9);
    const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights, Settings{}};
    std::vector<float> all(9);
    std::vector<float> same(9);
    for (const test::SurfacePoint& p : test::surface_points(random, scene, 40)) {
        mesh.visibility(p.position, p.normal, std::span<float>{all});
        for (const float length : {0x1p-100f, 0x1p-20f, 2.0f, 0x1p100f}) {
            mesh.visibility(p.position, length * p.normal, std::span<float>{same});
            CHECK(same == all);
        }
    }
    CHECK(mesh.visibility({0, 0, 30}, {0, 0, 1e-45f}, 0) == mesh.visibility({0, 0, 30}, {0, 0, 1}, 0));
    CHECK(mesh.visibility({0, 0, 30}, {0, 0, 3e38f}, 0) == mesh.visibility({0, 0, 30}, {0, 0, 1}, 0));
}

TEST_CASE("lights at odd places neither hang nor crash, nor go dark") {
    const std::vector<Light> lights{lightmesh::PointLight{{0, 0, 0}},         // at the point itself
                                    lightmesh::PointLight{{0.25f, 0.5f, 1}},  // at a light point
                                    lightmesh::PointLight{{0, 0, 1e-30f}},
                                    lightmesh::PointLight{{0, 0, 1e18f}},
                                    lightmesh::PointLight{{0, 0, 1e30f}},
                                    lightmesh::PointLight{{0, 0, 3e38f}},
                                    lightmesh::DirectionalLight{{0, 0, -1e-30f}},
                                    lightmesh::DirectionalLight{{0, 0, -3e38f}},
                                    lightmesh::SpotLight{{0, 0, 1e18f}, {0, 0, -1e-30f}, 0.1f}};
    for (const ShortTest short_test : test::all_short_tests) {
        Settings settings;
        settings.origin = {0, 0, 0};
        settings.short_test = short_test;
        const auto mesh = make(lights, settings);
        std::vector<float> all(lights.size());
        mesh.visibility({0, 0, 0}, {0, 0, 1}, std::span<float>{all});
        for (std::size_t i = 0; i < lights.size(); ++i) {
            CAPTURE(i);
            CHECK(all[i] == 1.0f);
            CHECK(mesh.visibility({0, 0, 0}, {0, 0, 1}, i) == 1.0f);
        }
    }
}

TEST_CASE("an exception of the tracer leaves the query, and the mesh stays right") {
    const std::vector<Light> lights{lightmesh::PointLight{{0.5f, 0, 5}}, lightmesh::PointLight{{0, 0.5f, 5}}};
    for (const ShortTest short_test : test::all_short_tests) {
        Settings settings;
        settings.short_test = short_test;
        int never = 0;
        const lightmesh::LightMesh reference{FailingTracer{&never}, lights, settings};
        std::vector<float> expected(2);
        reference.visibility({0.25f, 0, 0}, {0, 0, 1}, std::span<float>{expected});
        int failures = 0;
        const lightmesh::LightMesh mesh{FailingTracer{&failures}, lights, settings};
        std::vector<float> values(2);
        for (int i = 0; i < 5; ++i) {
            failures = 1;
            CHECK_THROWS_AS(mesh.visibility({0.25f, 0, 0}, {0, 0, 1}, std::span<float>{values}),
                            std::runtime_error);
        }
        failures = 0;
        mesh.visibility({0.25f, 0, 0}, {0, 0, 1}, std::span<float>{values});
        CHECK(values == expected);
    }
}

}  // namespace errors_test
