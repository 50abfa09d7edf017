// SPDX-License-Identifier: MIT
#include "hit_tracer.hpp"
#include "plain.hpp"
#include "plain_lamps.hpp"
#include "random_scene.hpp"

#include <lightmesh/cache_settings.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/surface_point.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace cache_errors_test {

namespace {

using lightmesh::CacheSettings;
using lightmesh::Light;
using lightmesh::VisibilityCache;
using test::HitTracer;
using test::Vec;

using Scene = std::vector<test::Triangle>;

void add_floor(Scene& scene) {
    test::add_quad(scene, {-10, -10, 0}, {20, 0, 0}, {0, 20, 0});
}

/// Three sphere lamps, a sun and a pane over what fits into a cube of +-`test::scene_size`.
std::vector<Light> lamps_of_all_kinds(test::Random& random) {
    std::vector<Light> lights;
    for (int i = 0; i < 3; ++i)
        lights.push_back(lightmesh::PointLight{
            .position = glm::vec3(random.in_box({-4.0, -4.0, 2.0}, {4.0, 4.0, 4.5})), .radius = 0.4f});
    lights.push_back(lightmesh::DirectionalLight{{0.3f, 0.5f, -1.0f}, 0.05f});
    lights.push_back(lightmesh::RectLight{
        .position = {0.0f, 0.0f, 4.0f}, .half_u = {0.0f, 1.0f, 0.0f}, .half_v = {0.6f, 0.0f, 0.1f}});
    return lights;
}

}  // namespace

TEST_CASE("cache errors: as near to lamps of 1024 rays as they were measured to be") {
    struct Case {
        const char* name;
        std::function<Scene(test::Random&)> make;
        std::uint64_t seed;
        double mean, misses;  ///< a mean 1.3 times what was measured; there were no misses
    };
    const auto boxes = [](test::Random& random) {
        return test::boxes_on_floor(random, 5);
    };
    const auto leaves = [](test::Random& random) {
        return test::triangle_soup(random, 40);
    };
    const std::array cases{
        Case{"boxes", boxes, 1, 0.0020, 0.005},
        Case{"boxes", boxes, 2, 0.0024, 0.005},
        Case{"boxes", boxes, 3, 0.0017, 0.005},
        Case{"walls", test::thin_walls, 4, 0.00035, 0.005},
        Case{"walls", test::thin_walls, 5, 0.00030, 0.005},
        Case{"leaves", leaves, 6, 0.0081, 0.005},
    };
    for (const Case& which : cases) {
        test::Random random(which.seed);
        const Scene scene = which.make(random);
        const std::vector<Light> lights = lamps_of_all_kinds(random);
        const auto points = test::surface_points(random, scene, 250);
        const VisibilityCache cache{HitTracer{&scene}, lights, CacheSettings{.spacing = 0.25f}};
        const test::LampErrors errors = test::errors_of(cache, scene, lights, points, 1024);
        CAPTURE(std::string(which.name));
        CAPTURE(which.seed);
        CHECK(errors.mean < which.mean);
        CHECK(errors.misses < which.misses);
    }
}

TEST_CASE("cache errors: thin things keep their contact shadows at the default settings") {
    const std::vector<Light> lamp{lightmesh::PointLight{.position = {1.6f, -2.4f, 2.5f}, .radius = 0.15f}};
    const auto add_fence = [](Scene& scene) {
        for (int post = -8; post <= 8; ++post) {
            const double x = 0.12 * post;
            test::add_box(scene, {x - 0.02, -0.02, 0.0}, {x + 0.02, 0.02, 0.7});
        }
    };
    const auto add_legs = [](Scene& scene) {
        for (const double x : {-0.6, 0.6})
            for (const double y : {-0.4, 0.4})
                test::add_box(scene, {x - 0.03, y - 0.03, 0.0}, {x + 0.03, y + 0.03, 0.7});
    };
    const auto add_grass = [](Scene& scene) {
        test::Random random(3);
        for (int blade = 0; blade < 150; ++blade) {
            const Vec foot(random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), 0.0);
            const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
            const Vec turn(std::cos(angle), std::sin(angle), 0.0);
            scene.push_back(test::rounded(foot - 0.012 * turn, foot + 0.012 * turn,
                                          foot + Vec(0.05 * turn.x, 0.05 * turn.y, 0.2)));
        }
    };
    struct Thing {
        const char* name;
        std::function<void(Scene&)> add;
        int kept;  ///< per cent: of grass, which is half as wide as a step of the finest records, few
    };
    const std::array things{Thing{"fence", add_fence, 92}, Thing{"legs", add_legs, 93},
                            Thing{"grass", add_grass, 27}};
    for (const Thing& thing : things) {
        Scene scene;
        add_floor(scene);
        thing.add(scene);
        const VisibilityCache cache{HitTracer{&scene}, lamp, CacheSettings{.spacing = 0.25f}};
        test::Random random(7);
        int dark = 0;
        int kept = 0;
        for (int i = 0; i < 6000; ++i) {
            const glm::vec3 point(random.in_box({-1.0, -0.6, 0.0}, {1.0, 1.0, 0.0}));
            if (test::share_of(scene, lamp[0], Vec(point), Vec(0, 0, 1), 16, random) > 0.32 ||
                test::share_of(scene, lamp[0], Vec(point), Vec(0, 0, 1), 256, random) > 0.2)
                continue;
            ++dark;
            kept += cache.visibility(point, {0.0f, 0.0f, 1.0f}, 0) < 0.4f ? 1 : 0;
        }
        CAPTURE(std::string(thing.name));
        CAPTURE(dark);
        CAPTURE(kept);
        CHECK(dark > 100);
        CHECK(kept > dark * thing.kept / 100);
    }
}

TEST_CASE("cache errors: where no record serves blur rows are rays to the lamps, whatever the mesh says") {
    test::Random random(8);
    const Scene scene = test::boxes_on_floor(random, 5);
    const std::vector<Light> lights = lamps_of_all_kinds(random);
    const CacheSettings settings{.spacing = 0.25f};
    const VisibilityCache lamps{HitTracer{&scene}, lights, settings};
    const VisibilityCache blur{
        lightmesh::LightMesh{HitTracer{&scene}, lights, lightmesh::Settings{.radius = 1.0f}}, settings};
    int partly_open = 0;
    for (int i = 0; i < 60; ++i) {
        // Without a normal there is no surface that records could lie on.
        const glm::vec3 point(random.in_box({-4.0, -4.0, -2.9}, {4.0, 4.0, 0.0}));
        for (std::size_t l = 0; l < lights.size(); ++l) {
            const float share = lamps.visibility(point, glm::vec3(0.0f), l);
            CHECK(blur.visibility(point, glm::vec3(0.0f), l) == share);
            partly_open += share > 0.0f && share < 1.0f ? 1 : 0;
        }
    }
    CHECK(partly_open > 3);
    CHECK(blur.mesh().statistics().light_points == 0);
}

namespace {

constexpr int most_lamps = 3;

/// The largest change of S of any lamp between neighbours of a walk, where both face the middles of the
/// lamps.
float largest_step(const auto& cache, int steps, const std::function<lightmesh::SurfacePoint(int)>& at) {
    const std::span<const Light> lights = cache.lights();
    std::array<float, most_lamps> before{}, now{};
    std::array<bool, most_lamps> was_faced{};
    float largest = 0.0f;
    for (int i = 0; i <= steps; ++i) {
        const lightmesh::SurfacePoint point = at(i);
        cache.visibility(point, now);
        for (std::size_t l = 0; l < most_lamps; ++l) {
            const auto& lamp = std::get<lightmesh::PointLight>(lights[l]);
            const bool is_faced = glm::dot(point.normal, lamp.position - point.position) >= 0.0f;
            if (i > 0 && is_faced && was_faced[l])
                largest = std::max(largest, std::abs(now[l] - before[l]));
            was_faced[l] = is_faced;
        }
        before = now;
    }
    return largest;
}

/// A ball of radius 2 between bars that shade it.
Scene ball_between_bars() {
    constexpr int rings = 24;
    constexpr int sectors = 48;
    const auto at = [](int ring, int sector) {
        const double polar = std::numbers::pi * ring / rings;
        const double turn = 2.0 * std::numbers::pi * sector / sectors;
        return 2.0 * Vec(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar));
    };
    Scene scene;
    for (int ring = 0; ring < rings; ++ring)
        for (int sector = 0; sector < sectors; ++sector) {
            if (ring > 0)
                scene.push_back(test::rounded(at(ring, sector), at(ring + 1, sector), at(ring, sector + 1)));
            if (ring + 1 < rings)
                scene.push_back(
                    test::rounded(at(ring, sector + 1), at(ring + 1, sector), at(ring + 1, sector + 1)));
        }
    test::add_box(scene, {2.6, -4.0, 0.9}, {2.9, 4.0, 1.2});
    test::add_box(scene, {-4.0, 2.6, 0.9}, {4.0, 2.9, 1.2});
    return scene;
}

const std::vector<Light>& lamps_around() {
    static const std::vector<Light> lamps{
        lightmesh::PointLight{.position = {6.0f, 2.0f, 5.0f}, .radius = 0.8f},
        lightmesh::PointLight{.position = {1.0f, 6.0f, 4.0f}, .radius = 0.8f},
        lightmesh::PointLight{.position = {-3.0f, 1.0f, 7.0f}, .radius = 0.8f}};
    return lamps;
}

}  // namespace

namespace {

constexpr float spacing = 0.25f;

/// Along a way, within 50 steps of g: up from half the finest level's step to that of 2 g, and back.
float through_levels(float way) {
    const float turn = way / (50.0f * spacing);
    const float up = 2.0f * std::min(turn - std::floor(turn), 1.0f - turn + std::floor(turn));
    return spacing * std::exp2(-4.0f + 4.75f * up);
}

/// All around a ball, through all axes.
glm::vec3 around(float way) {
    const float turn = 0.5f * way;
    const float height = 0.9f * std::sin(0.31f * turn);
    const float flat = std::sqrt(1.0f - height * height);
    return {flat * std::cos(turn), flat * std::sin(turn), height};
}

/// To and fro through the direction that leans to all three axes alike, from all sides.
glm::vec3 through_tie_of_three(float way) {
    const glm::vec3 middle = glm::normalize(glm::vec3(1.0f));
    const glm::vec3 right = glm::normalize(glm::vec3(1.0f, -1.0f, 0.0f));
    const float side = 0.25f * std::sin(2.0f * way);
    const glm::vec3 across =
        std::cos(0.37f * way) * right + std::sin(0.37f * way) * glm::cross(middle, right);
    return std::cos(side) * middle + std::sin(side) * across;
}

}  // namespace

TEST_CASE("cache errors: a slow walk over a curved surface meets no step, through all axes and levels") {
    const Scene scene = ball_between_bars();
    const VisibilityCache cache{HitTracer{&scene}, lamps_around(), CacheSettings{.spacing = spacing}};
    struct Walk {
        const char* name;
        glm::vec3 (*normal)(float way);
        bool is_through_levels;
        float largest;  ///< 1.3 times what was measured, in steps of g / 1000
    };
    for (const Walk& walk : {Walk{"around", around, false, 0.0043f}, Walk{"around", around, true, 0.0015f},
                             Walk{"tie", through_tie_of_three, false, 0.0061f},
                             Walk{"tie", through_tie_of_three, true, 0.0061f}}) {
        CAPTURE(std::string(walk.name));
        CAPTURE(walk.is_through_levels);
        // Just over the facets, with the normals of the smooth ball.
        const float largest = largest_step(cache, 50'500, [&](int i) {
            const float way = spacing / 1000.0f * static_cast<float>(i);
            const glm::vec3 normal = walk.normal(way);
            return lightmesh::SurfacePoint{.position = 2.0f * normal,
                                           .normal = normal,
                                           .footprint = walk.is_through_levels ? through_levels(way) : 0.0f};
        });
        CHECK(largest < walk.largest);
    }
}

TEST_CASE("cache errors: a slow walk over a slope meets no step, between any axes, through levels") {
    struct Slope {
        const char* name;
        Vec normal;
        float largest, largest_through_levels;  ///< 1.3 times what was measured, in steps of g / 1000
    };
    for (const Slope& slope : {Slope{"one axis", {0.0, -1.0, 2.3}, 0.0075f, 0.0028f},
                               Slope{"two axes", {0.0, -1.0, 1.03}, 0.0073f, 0.0051f},
                               Slope{"three axes", {0.97, -1.0, 1.02}, 0.0034f, 0.0022f}}) {
        const Vec normal = glm::normalize(slope.normal);
        const Vec right = glm::normalize(Vec(1, 0, 0) - normal.x * normal);
        const Vec along = glm::cross(normal, right);
        Scene scene;
        test::add_quad(scene, -8.0 * right - 4.0 * along, 16.0 * right, 8.0 * along);
        test::Random random(6);
        for (int i = 0; i < 12; ++i) {
            const Vec middle = random.uniform(-6.0, 6.0) * right + random.uniform(-1.5, 1.5) * along +
                               random.uniform(0.8, 1.2) * normal;
            test::add_box(scene, middle - 0.3, middle + 0.3);
        }
        const std::vector<Light> lamps{
            lightmesh::PointLight{.position = glm::vec3(6.0 * normal - along), .radius = 0.6f},
            lightmesh::PointLight{.position = glm::vec3(5.0 * normal + 2.0 * right), .radius = 0.3f},
            lightmesh::PointLight{.position = glm::vec3(4.0 * normal - 4.0 * right), .radius = 0.9f}};
        const VisibilityCache cache{HitTracer{&scene}, lamps, CacheSettings{.spacing = spacing}};
        CAPTURE(std::string(slope.name));
        for (const bool is_through_levels : {false, true}) {
            CAPTURE(is_through_levels);
            const float largest = largest_step(cache, 50'000, [&](int i) {
                const float way = spacing / 1000.0f * static_cast<float>(i);
                const Vec point = (way - 6.25) * right + (0.06 * way - 0.375) * along;
                return lightmesh::SurfacePoint{.position = glm::vec3(point),
                                               .normal = glm::vec3(normal),
                                               .footprint = is_through_levels ? through_levels(way) : 0.0f};
            });
            CHECK(largest < (is_through_levels ? slope.largest_through_levels : slope.largest));
        }
    }
}

TEST_CASE("cache errors: soft edges have hardly a wave, and no steep places") {
    Scene scene;
    add_floor(scene);
    test::add_box(scene, {0.0, -8.0, 1.5}, {8.0, 8.0, 1.7});
    const std::vector<Light> lamp{lightmesh::PointLight{.position = {0.3f, 0.2f, 5.0f}, .radius = 0.5f}};
    const VisibilityCache cache{HitTracer{&scene}, lamp, CacheSettings{.spacing = spacing}};
    // Across the edge, slantwise, from light to dark.
    constexpr int count = 3000;
    std::vector<float> steps;
    float before = 1.0f;
    float variation = 0.0f;
    for (int i = 0; i <= count; ++i) {
        const float s = spacing / 500.0f * static_cast<float>(i) - 0.75f;
        const float now = cache.visibility(glm::vec3(0.9f * s, 0.44f * s, 0.0f), {0.0f, 0.0f, 1.0f}, 0);
        steps.push_back(std::abs(now - before));
        variation += steps.back();
        before = now;
    }
    CHECK(before == 0.0f);
    // 1 would be a slope without any wave; steps, of g / 500, about 1.3 times what was measured.
    CHECK(variation < 1.03f);
    std::ranges::sort(steps);
    CHECK(steps[steps.size() * 99 / 100] < 0.0025f);
    CHECK(steps.back() < 0.004f);
}

TEST_CASE("cache errors: nothing pops for any lamp while footprints shrink") {
    const Scene scene = ball_between_bars();
    const VisibilityCache cache{HitTracer{&scene}, lamps_around(), CacheSettings{.spacing = 0.25f}};
    test::Random random(12);
    for (const test::SurfacePoint& point : test::surface_points(random, scene, 12)) {
        const float largest = largest_step(cache, 1400, [&](int i) {
            return lightmesh::SurfacePoint{.position = point.position,
                                           .normal = point.normal,
                                           .footprint = 1.6f * std::pow(0.998f, static_cast<float>(i))};
        });
        CHECK(largest < 0.01f);
    }
}

TEST_CASE("cache errors: a slow walk with a footprint that grows meets no step") {
    test::Random random(13);
    Scene scene = test::boxes_on_floor(random, 6);
    const VisibilityCache cache{HitTracer{&scene}, lamps_around(), CacheSettings{.spacing = 0.25f}};
    const float largest = largest_step(cache, 12000, [](int i) {
        const float s = 0.5e-3f * static_cast<float>(i);
        return lightmesh::SurfacePoint{.position = {s - 3.0f, 0.3f * s - 1.0f, -3.0f},
                                       .normal = {0.0f, 0.0f, 1.0f},
                                       .footprint = 0.01f * std::exp(0.6f * s)};
    });
    CHECK(largest < 0.003f);
}

}  // namespace cache_errors_test
