// SPDX-License-Identifier: MIT
#include "analytic.hpp"
#include "random_scene.hpp"

#include <lightmesh/shadows/shadow_map.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace shadow_map_test {

namespace {

using lightmesh::ShadowMapLookup;
using Map = lightmesh::ShadowMap<test::BoxRenderer>;

constexpr lightmesh::Bounds room_bounds{{-10.0f, -10.0f, -10.0f}, {10.0f, 10.0f, 10.0f}};

lightmesh::ShadowMapSettings settings_of(int resolution) {
    lightmesh::ShadowMapSettings settings;
    settings.resolution = resolution;
    settings.scene_bounds = room_bounds;
    return settings;
}

/// Boxes of side 1 to 3 in a room of 20.
test::BoxScene boxes_at_random(std::uint64_t seed, int count) {
    test::Random random(seed);
    test::BoxScene scene;
    for (int i = 0; i < count; ++i) {
        const glm::vec3 middle(random.in_box(test::Vec(-8.0), test::Vec(8.0)));
        const glm::vec3 half(random.in_box(test::Vec(0.5), test::Vec(1.5)));
        scene.boxes.push_back({middle - half, middle + half});
    }
    return scene;
}

/// Where the light comes from, as seen from a point.
glm::dvec3 source(const lightmesh::Light& light, const glm::dvec3& point) {
    if (const auto* sun = std::get_if<lightmesh::DirectionalLight>(&light))
        return point - 100.0 * glm::normalize(glm::dvec3(sun->direction));
    if (const auto* spot = std::get_if<lightmesh::SpotLight>(&light))
        return glm::dvec3(spot->position);
    return glm::dvec3(std::get<lightmesh::PointLight>(light).position);
}

/// The band in which a map may differ from a ray: within two sides of a texel, in any direction, rays to
/// points around this one disagree.
bool in_band(const test::BoxScene& scene, const lightmesh::Light& light, const glm::dvec3& point,
             double texel_angle) {
    const glm::dvec3 from = source(light, point);
    const bool parallel = std::holds_alternative<lightmesh::DirectionalLight>(light);
    const double side = parallel ? texel_angle : texel_angle * glm::length(point - from);
    const bool blocked = scene.blocked(from, point);
    for (int i = 0; i < 27; ++i) {
        const glm::dvec3 step(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        for (const double reach : {1.0, 2.0}) {
            const glm::dvec3 other = point + reach * side * step;
            if (scene.blocked(parallel ? source(light, other) : from, other) != blocked)
                return true;
        }
    }
    return false;
}

/// Looks up points all around and traces them; returns the share of the points that lie in the band.
double compare_with_rays(const test::BoxScene& scene, const lightmesh::Light& light, int resolution,
                         double texel_angle) {
    const Map map({&scene}, light, settings_of(resolution));
    test::Random random(99);
    const int count = 4000;
    int unsure = 0;
    int wrong = 0;
    for (int i = 0; i < count; ++i) {
        const glm::vec3 point(random.in_box(test::Vec(-10.0), test::Vec(10.0)));
        if (in_band(scene, light, glm::dvec3(point), texel_angle)) {
            ++unsure;
        } else if (map.visible(point) == scene.blocked(source(light, glm::dvec3(point)), glm::dvec3(point))) {
            ++wrong;
        }
    }
    CHECK(wrong == 0);
    return unsure / static_cast<double>(count);
}

/// Six walls around the origin, their inner sides at distance 1.
test::BoxScene closed_room() {
    test::BoxScene scene;
    for (int axis = 0; axis < 3; ++axis) {
        for (const float side : {-1.0f, 1.0f}) {
            glm::vec3 low(-2.0f);
            glm::vec3 high(2.0f);
            (side < 0.0f ? high : low)[axis] = side;
            scene.boxes.push_back({low, high});
        }
    }
    return scene;
}

}  // namespace

TEST_SUITE("shadow map") {
    TEST_CASE("points all around a point light, looked up and traced, agree but for the band") {
        const auto scene = boxes_at_random(1, 20);
        const lightmesh::Light light = lightmesh::PointLight{{0.3f, -9.0f, 0.7f}};
        CHECK(compare_with_rays(scene, light, 256, 2.0 / 256) < 0.25);
        CHECK(compare_with_rays(scene, light, 512, 2.0 / 512) < 0.13);
    }

    TEST_CASE("a light in the middle, in a corner, on a wall, outside of the scene") {
        auto scene = boxes_at_random(2, 15);
        scene.boxes.push_back(
            {{-11.0f, -11.0f, -11.0f}, {-10.0f, 11.0f, 11.0f}});  // walls at x = -10 and z = -10
        scene.boxes.push_back({{-11.0f, -11.0f, -11.0f}, {11.0f, 11.0f, -10.0f}});
        for (const glm::vec3 place :
             {glm::vec3(0.0f), glm::vec3(-9.99f, 0.0f, -9.99f), glm::vec3(-9.999f, 3.0f, 2.0f),
              glm::vec3(-10.0f, -2.0f, 3.0f), glm::vec3(40.0f, 5.0f, 30.0f)})
            compare_with_rays(scene, lightmesh::PointLight{place}, 256, 2.0 / 256);
    }

    TEST_CASE("a spot light, narrow and wide, inside its cone and outside") {
        const auto scene = boxes_at_random(3, 20);
        for (const float cone : {0.1f, 0.7f, 1.04f, 1.3f, 3.0f})
            compare_with_rays(scene, lightmesh::SpotLight{{0.0f, 0.5f, 9.5f}, {0.1f, 0.2f, -1.0f}, cone}, 256,
                              3.6 / 256);
    }

    TEST_CASE("a directional light") {
        const auto scene = boxes_at_random(4, 20);
        CHECK(compare_with_rays(scene, lightmesh::DirectionalLight{{0.5f, 0.25f, -1.0f}}, 512, 36.0 / 512) <
              0.4);
        compare_with_rays(scene, lightmesh::DirectionalLight{{0.0f, 0.0f, -1.0f}}, 512, 36.0 / 512);
    }

    TEST_CASE("no seams: directions along the edges and corners of the cube, and next to them") {
        const auto scene = closed_room();
        const int resolution = 64;
        const Map map({&scene}, lightmesh::PointLight{}, settings_of(resolution));
        const float texel = 2.0f / resolution;
        const float step = std::numeric_limits<float>::epsilon();
        for (int axis = 0; axis < 3; ++axis) {
            for (int i = -70; i <= 70; ++i) {
                for (const float across :
                     {1.0f, 1.0f - step, 1.0f + step, 0.999f, 1.001f, -1.0f, -0.999f, -1.001f}) {
                    glm::vec3 way;
                    way[axis] = static_cast<float>(i) / 70.0f;
                    way[(axis + 1) % 3] = 1.0f;
                    way[(axis + 2) % 3] = across;
                    const float largest = (std::max)(std::abs(across), 1.0f);
                    CHECK(map.visible(way * (1.0f - texel) / largest));
                    CHECK_FALSE(map.visible(way * (1.0f + 4.0f * texel) / largest));
                    CHECK(map.look_up(way * (1.0f - 4.0f * texel) / largest) == ShadowMapLookup::lit);
                    CHECK(map.look_up(way * (1.0f + 4.0f * texel) / largest) == ShadowMapLookup::dark);
                    CHECK(map.visibility(way * (1.0f - texel) / largest, 3.0f) == 1.0f);
                    CHECK(map.visibility(way * 1.5f, 3.0f) == 0.0f);
                }
            }
        }
    }

    TEST_CASE("surfaces do not shade themselves, up to 85 degrees off the perpendicular") {
        test::BoxScene scene;
        scene.boxes.push_back({{-20.0f, -20.0f, -2.0f}, {20.0f, 20.0f, -1.0f}});
        auto settings = settings_of(256);
        settings.scene_bounds = scene.boxes.front();
        test::Random random(12);
        for (const lightmesh::Light& light :
             {lightmesh::Light(lightmesh::PointLight{}),
              lightmesh::Light(lightmesh::DirectionalLight{{10.0f, 3.0f, -1.0f}})}) {
            const Map map({&scene}, light, settings);
            int dark = 0;
            for (int i = 0; i < 20000; ++i) {
                const double angle = random.uniform(0.0, 6.28);
                const double away = std::tan(random.uniform(0.0, 85.0) * 0.0174533);
                dark +=
                    map.visible(glm::vec3(glm::dvec3(away * std::cos(angle), away * std::sin(angle), -1.0)))
                        ? 0
                        : 1;
            }
            CHECK(dark == 0);
        }
    }

    TEST_CASE("resolution 1, 16 and 2048") {
        const auto scene = closed_room();
        for (const int resolution : {1, 16, 2048}) {
            std::size_t views = 0;
            const Map map({&scene, &views}, lightmesh::PointLight{}, settings_of(resolution));
            CHECK(map.visible({0.9f, 0.1f, -0.2f}));
            CHECK_FALSE(map.visible({8.0f, 0.1f, -0.2f}));
            CHECK(views <=
                  (resolution == 1 ? 3u : 1u));  // its only texel is surrounded by those of other faces
            const auto texels = static_cast<std::size_t>(resolution) * static_cast<std::size_t>(resolution);
            CHECK(map.bytes() >= 4 * texels * views);
            CHECK(map.bytes() < 4 * texels * views + 4096);
            CHECK(map.visibility({0.9f, 0.1f, -0.2f}) == 1.0f);
        }
    }

    TEST_CASE("resolution 4096 tells points apart that 16 cannot") {
        test::BoxScene scene;
        scene.boxes.push_back({{5.0f, 0.0f, -1.0f}, {5.1f, 0.02f, 1.0f}});  // a blade
        const lightmesh::Light light = lightmesh::PointLight{};
        const Map fine({&scene}, light, settings_of(4096));
        CHECK_FALSE(fine.visible({6.0f, 0.012f, 0.0f}));
        CHECK(fine.visible({6.0f, -0.005f, 0.0f}));
        CHECK(fine.visible({6.0f, 0.03f, 0.0f}));
    }

    TEST_CASE("pictures that nobody needs are not rendered") {
        const auto scene = boxes_at_random(5, 10);
        std::size_t views = 0;
        const Map point({&scene, &views}, lightmesh::PointLight{}, settings_of(32));
        CHECK(views == 0);
        point.visible({5.0f, 0.1f, 0.2f});
        point.visible({6.0f, 0.2f, -0.2f});
        CHECK(views == 1);
        CHECK(point.rendered() == 1);
        point.visible({-6.0f, 0.2f, -0.2f});
        CHECK(views == 2);
        point.render_all();
        CHECK(views == 6);
        point.render_all();
        CHECK(views == 6);

        views = 0;
        const lightmesh::SpotLight spot{{0.0f, 0.0f, 9.0f}, {0.0f, 0.3f, -1.0f}, 0.5f};
        const Map cone({&scene, &views}, spot, settings_of(32));
        const glm::vec3 axis = glm::normalize(spot.axis);
        const glm::vec3 side = glm::normalize(glm::cross(axis, glm::vec3(1.0f, 0.0f, 0.0f)));
        for (int i = 0; i < 360; ++i) {
            const float turn = static_cast<float>(i) * 0.0174533f;
            const glm::vec3 out = std::cos(turn) * side + std::sin(turn) * glm::cross(axis, side);
            cone.visible(spot.position + 5.0f * (std::cos(0.4999f) * axis + std::sin(0.4999f) * out));
            cone.look_up(spot.position + 5.0f * (std::cos(0.4999f) * axis + std::sin(0.4999f) * out));
        }
        CHECK(views == 1);
        cone.visible(spot.position - axis);
        CHECK(views == 2);
    }

    TEST_CASE("what look_up is sure of is so, and the rest is little") {
        const auto scene = boxes_at_random(6, 20);
        const lightmesh::PointLight light{{0.3f, -9.0f, 0.7f}};
        const Map map({&scene}, light, settings_of(512));
        test::Random random(5);
        int wrong = 0;
        int edges = 0;
        const int count = 20000;
        for (int i = 0; i < count; ++i) {
            const glm::vec3 point(random.in_box(test::Vec(-10.0), test::Vec(10.0)));
            const auto found = map.look_up(point);
            const bool blocked = scene.blocked(glm::dvec3(light.position), glm::dvec3(point));
            edges += found == ShadowMapLookup::edge ? 1 : 0;
            wrong += found == (blocked ? ShadowMapLookup::lit : ShadowMapLookup::dark) ? 1 : 0;
        }
        CHECK(wrong <= 2);
        CHECK(edges < count / 20);
    }

    TEST_CASE("percentage-closer filtering goes from dark to lit across an edge, evenly") {
        test::BoxScene scene;
        scene.boxes.push_back({{4.0f, -8.0f, -8.0f}, {4.5f, 0.0f, 8.0f}});  // its edge at y = 0
        const int resolution = 128;
        const Map map({&scene}, lightmesh::PointLight{}, settings_of(resolution));
        const float x = 8.0f;
        const float texel = 2.0f * x / resolution;
        for (const float filter : {0.5f, 1.0f, 4.0f}) {
            float previous = 0.0f;
            for (int i = -100; i <= 100; ++i) {
                const float y = static_cast<float>(i) * 0.1f * texel;
                const float share = map.visibility({x, y, 0.3f}, filter);
                CHECK(share >= previous);
                CHECK(share == doctest::Approx((std::clamp)(0.5f + y / texel / (2.0f * filter), 0.0f, 1.0f))
                                   .epsilon(0.01));
                previous = share;
            }
        }
        CHECK(map.visibility({x, -0.01f, 0.3f}, 0.0f) == 0.0f);
        CHECK(map.visibility({x, 0.01f, 0.3f}, 0.0f) == 1.0f);
        CHECK_THROWS_AS(map.visibility({x, 0.0f, 0.0f}, -1.0f), std::invalid_argument);
        CHECK_THROWS_AS(map.visibility({x, 0.0f, 0.0f}, std::numeric_limits<float>::quiet_NaN()),
                        std::invalid_argument);
    }

    TEST_CASE("points that are no points, the light itself, points outside the map") {
        const auto scene = closed_room();
        const float nan = std::numeric_limits<float>::quiet_NaN();
        const float infinite = std::numeric_limits<float>::infinity();
        const Map map({&scene}, lightmesh::PointLight{}, settings_of(16));
        CHECK_FALSE(map.visible({nan, 0.0f, 0.0f}));
        CHECK_FALSE(map.visible({0.0f, infinite, 0.0f}));
        CHECK(map.look_up({0.0f, 0.0f, nan}) == ShadowMapLookup::dark);
        CHECK(map.visibility({0.0f, 0.0f, nan}) == 0.0f);
        CHECK(map.visible(glm::vec3(0.0f)));
        CHECK(map.visibility(glm::vec3(0.0f)) == 1.0f);
        CHECK_FALSE(map.visible(glm::vec3(1e38f)));

        const Map sun({&scene}, lightmesh::DirectionalLight{}, settings_of(16));
        CHECK(sun.visible({500.0f, 0.0f, 0.0f}));
        CHECK(sun.look_up({500.0f, 0.0f, 0.0f}) == ShadowMapLookup::lit);
        CHECK(sun.visible({0.0f, 0.0f, 50.0f}));
        CHECK_FALSE(sun.visible({0.0f, 0.0f, -50.0f}));
    }

    TEST_CASE("the scale of the scene does not matter") {
        for (const float scale : {1e-6f, 1e-3f, 1.0f, 1e3f, 1e6f}) {
            auto scene = closed_room();
            for (auto& box : scene.boxes) {
                box.low *= scale;
                box.high *= scale;
            }
            lightmesh::ShadowMapSettings settings;
            settings.resolution = 128;
            settings.z_near = 1e-4f * scale;
            const Map map({&scene}, lightmesh::PointLight{}, settings);
            CHECK(map.visible(scale * glm::vec3(0.9f, 0.3f, 0.5f)));
            CHECK_FALSE(map.visible(scale * glm::vec3(1.1f, 0.3f, 0.5f)));
        }
    }

    TEST_CASE("settings and lights that make no sense") {
        const test::BoxScene scene;
        const float nan = std::numeric_limits<float>::quiet_NaN();
        const auto make = [&](const lightmesh::Light& light, lightmesh::ShadowMapSettings settings) {
            return Map({&scene}, light, settings);
        };
        const lightmesh::PointLight point;
        CHECK_THROWS_AS(make(point, settings_of(0)), std::invalid_argument);
        CHECK_THROWS_AS(make(point, settings_of(16385)), std::invalid_argument);
        CHECK_NOTHROW(make(point, settings_of(16384)));
        CHECK_THROWS_AS(make(lightmesh::PointLight{{nan, 0.0f, 0.0f}}, settings_of(16)),
                        std::invalid_argument);
        CHECK_THROWS_AS(make(lightmesh::SpotLight{{}, {}, 0.5f}, settings_of(16)), std::invalid_argument);
        CHECK_THROWS_AS(make(lightmesh::DirectionalLight{{}}, settings_of(16)), std::invalid_argument);

        lightmesh::ShadowMapSettings settings;
        CHECK_THROWS_WITH(make(point, settings),
                          "lightmesh: light: shadow map's z_near is not set; it must be, unless the bounds "
                          "of the scene are given");
        settings.z_near = std::numeric_limits<float>::quiet_NaN();
        CHECK_THROWS_AS(make(point, settings), std::invalid_argument);
        settings.z_near = 0.0f;
        CHECK_THROWS_AS(make(point, settings), std::invalid_argument);
        settings.z_near = 0.1f;
        CHECK_NOTHROW(make(point, settings));
        CHECK_THROWS_AS(make(lightmesh::DirectionalLight{}, settings), std::invalid_argument);
        settings.scene_bounds = lightmesh::Bounds{{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 1.0f}};
        CHECK_THROWS_AS(make(lightmesh::DirectionalLight{}, settings), std::invalid_argument);
        settings.scene_bounds = lightmesh::Bounds{{0.0f, 0.0f, 0.0f}, {4.0f, 4.0f, 0.0f}};  // flat is fine
        CHECK_NOTHROW(make(lightmesh::DirectionalLight{}, settings));
    }

    TEST_CASE("the renderer's own bounds are used where the settings give none") {
        struct Bounded : test::BoxRenderer {
            lightmesh::Bounds bounds() const { return {glm::vec3(-2.0f), glm::vec3(2.0f)}; }
        };
        const auto scene = closed_room();
        const lightmesh::ShadowMap<Bounded> map(Bounded{{&scene}}, lightmesh::DirectionalLight{}, {});
        CHECK_FALSE(map.visible(glm::vec3(0.0f)));
        CHECK(map.visible({0.0f, 0.0f, 2.5f}));
    }

    TEST_CASE("a renderer that fails: its own message, nothing kept, the next query asks again") {
        struct Failing {
            int* calls;
            int mode;
            void render_depth(const lightmesh::DepthView&, std::span<float> distance) {
                std::ranges::fill(distance, 1.0f);
                if (++*calls > 2)
                    return;
                if (mode == 0)
                    throw std::runtime_error("device lost");
                distance[5] = mode == 1 ? std::numeric_limits<float>::quiet_NaN() : -1.0f;
            }
        };
        for (const int mode : {0, 1, 2}) {
            int calls = 0;
            const lightmesh::ShadowMap<Failing> map({&calls, mode}, lightmesh::PointLight{}, settings_of(4));
            for (int attempt = 1; attempt <= 2; ++attempt) {
                const std::string place =
                    " at row 1, column 1 of view 0 of light; it must be 0 or greater, or +infinity "
                    "where nothing is hit";
                const std::string gave = "lightmesh: the DepthRenderer gave the distance ";
                const std::string messages[] = {"device lost", gave + "nan" + place, gave + "-1" + place};
                CHECK_THROWS_WITH_AS(map.visible({3.0f, 0.0f, 0.0f}), messages[mode].c_str(),
                                     std::runtime_error);
                CHECK(calls == attempt);
                CHECK(map.rendered() == 0);
            }
            CHECK_FALSE(map.visible({3.0f, 0.0f, 0.0f}));
            CHECK(map.rendered() == 1);
            CHECK(calls == 3);
        }
    }

    TEST_CASE("a renderer that can take several views gets them at once") {
        struct Batch : test::BoxRenderer {
            using BoxRenderer::render_depth;
            std::vector<std::size_t>* sizes;
            void render_depth(std::span<const lightmesh::DepthView> all,
                              std::span<const std::span<float>> distances) {
                sizes->push_back(all.size());
                for (std::size_t i = 0; i < all.size(); ++i)
                    render_depth(all[i], distances[i]);
            }
        };
        const auto scene = closed_room();
        std::vector<std::size_t> sizes;
        const lightmesh::ShadowMap<Batch> map(Batch{{&scene}, &sizes}, lightmesh::PointLight{},
                                              settings_of(16));
        map.visible({0.5f, 0.0f, 0.0f});
        CHECK(sizes.empty());
        map.render_all();
        CHECK(sizes == std::vector<std::size_t>{5});
        CHECK(map.rendered() == 6);
    }

    TEST_CASE("many threads: one picture at a time, each once, the same answers") {
        struct Counting {
            const test::BoxScene* scene;
            std::atomic<int>* inside;
            std::atomic<int>* views;
            void render_depth(const lightmesh::DepthView& view, std::span<float> distance) {
                CHECK(++*inside == 1);
                test::BoxRenderer{scene}.render_depth(view, distance);
                ++*views;
                --*inside;
            }
        };
        const auto scene = boxes_at_random(8, 10);
        std::atomic<int> inside = 0;
        std::atomic<int> views = 0;
        const auto renderer =
            std::make_shared<lightmesh::SharedDepthRenderer<Counting>>(Counting{&scene, &inside, &views});
        std::vector<lightmesh::ShadowMap<Counting>> maps;
        for (int i = 0; i < 4; ++i)
            maps.emplace_back(renderer, lightmesh::PointLight{glm::vec3(static_cast<float>(i))},
                              settings_of(32));
        std::vector<std::vector<bool>> answers(8);
        {
            std::vector<std::jthread> threads;
            for (auto& answer : answers) {
                threads.emplace_back([&maps, &answer] {
                    test::Random random(11);
                    for (int i = 0; i < 4000; ++i)
                        answer.push_back(maps[random.below(4)].visible(
                            glm::vec3(random.in_box(test::Vec(-9.0), test::Vec(9.0)))));
                });
            }
        }
        CHECK(views == 24);
        for (const auto& answer : answers)
            CHECK(answer == answers[0]);
    }
}

}  // namespace shadow_map_test
