// SPDX-License-Identifier: MIT
#include "analytic.hpp"
#include "random_scene.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

// Light meshes whose long tests are look-ups in shadow maps.

namespace map_mesh_test {

namespace {

using lightmesh::ShortTest;

constexpr std::array all_short_tests{ShortTest::exact, ShortTest::linked, ShortTest::none};

/// Boxes of side 1 to 3 on a floor.
test::BoxScene boxes_at_random(std::uint64_t seed) {
    test::Random random(seed);
    test::BoxScene scene;
    scene.boxes.push_back({{-12.0f, -12.0f, -9.0f}, {12.0f, 12.0f, -8.0f}});
    for (int i = 0; i < 15; ++i) {
        const glm::vec3 middle(random.in_box({-8.0, -8.0, -8.0}, {8.0, 8.0, 0.0}));
        const glm::vec3 half(random.in_box(test::Vec(0.5), test::Vec(1.5)));
        scene.boxes.push_back({middle - half, middle + half});
    }
    return scene;
}

/// Points that a camera far above sees: on the tops of things.
std::vector<test::SurfacePoint> points_on(const test::BoxScene& scene, int count) {
    test::Random random(77);
    std::vector<test::SurfacePoint> points;
    for (int i = 0; i < count; ++i) {
        const glm::dvec3 from(random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0), 50.0);
        const glm::dvec3 down(0.0, 0.0, -1.0);
        points.push_back({glm::vec3(from + scene.hit(from, down) * down), glm::vec3(0.0f, 0.0f, 1.0f)});
    }
    return points;
}

std::vector<lightmesh::Light> lights_above() {
    return {lightmesh::PointLight{{0.3f, -5.0f, 7.7f}},
            lightmesh::SpotLight{{-4.0f, 3.0f, 9.0f}, {0.3f, -0.2f, -1.0f}, 0.8f},
            lightmesh::DirectionalLight{{0.5f, 0.25f, -1.0f}},
            lightmesh::PointLight{{7.0f, 7.0f, 2.0f}, 9.0f},
            lightmesh::SpotLight{{5.0f, -6.0f, 3.0f}, {-1.0f, 0.4f, -0.5f}, 1.4f, 15.0f},
            lightmesh::DirectionalLight{{0.0f, 0.0f, -2.0f}}};
}

lightmesh::Settings settings_of(int map_size, bool refine, ShortTest short_test) {
    lightmesh::Settings settings;
    settings.radius = 1.5f;
    settings.adaptive_long_tests = false;
    settings.quality = 3.0f;
    settings.short_test = short_test;
    settings.shadow_map_size = map_size;
    settings.refine_shadow_maps = refine;
    settings.scene_bounds = lightmesh::Bounds{{-12.0f, -12.0f, -9.0f}, {12.0f, 12.0f, 2.0f}};
    return settings;
}

template <class Mesh>
std::vector<float> values(const Mesh& mesh, const std::vector<test::SurfacePoint>& points) {
    const std::size_t lights = mesh.light_count();
    std::vector<float> all(points.size() * lights);
    for (std::size_t i = 0; i < points.size(); ++i)
        mesh.visibility(points[i].position, points[i].normal, std::span(all).subspan(i * lights, lights));
    return all;
}

double mean_difference(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += static_cast<double>(std::abs(a[i] - b[i]));
    return sum / static_cast<double>(a.size());
}

}  // namespace

TEST_SUITE("light mesh by shadow maps") {
    TEST_CASE("near to the light mesh by rays, nearer by finer maps, nearest with rays at edges") {
        const auto scene = boxes_at_random(1);
        const auto points = points_on(scene, 400);
        const auto lights = lights_above();
        for (const ShortTest short_test : all_short_tests) {
            const auto rays_only = settings_of(1024, false, short_test);
            const lightmesh::LightMesh by_rays{test::BoxTracer{&scene}, lights, rays_only};
            const std::vector<float> expected = values(by_rays, points);
            const auto long_rays = static_cast<double>(by_rays.statistics().long_rays);
            const auto difference = [&](int size, bool refine, double& share_of_rays) {
                const auto settings = settings_of(size, refine, short_test);
                const lightmesh::LightMesh by_maps{test::BoxTracer{&scene}, test::BoxRenderer{&scene}, lights,
                                                   settings};
                const double mean = mean_difference(values(by_maps, points), expected);
                const lightmesh::MeshStatistics held = by_maps.statistics();
                share_of_rays = static_cast<double>(held.long_rays) / long_rays;
                CHECK(held.long_tests == by_rays.statistics().long_tests);
                CHECK(held.bytes > sizeof(float) * static_cast<std::size_t>(size * size));
                return mean;
            };
            double share = 0.0;
            const double coarse = difference(64, false, share);
            CHECK(share == 0.0);
            const double fine = difference(256, false, share);
            CHECK(share == 0.0);
            const double refined = difference(256, true, share);
            CHECK(share > 0.0);
            CHECK(share < 0.1);
            CHECK(fine < 0.005);
            CHECK(fine < 0.5 * coarse);
            CHECK(refined < 0.1 * fine);
        }
    }

    TEST_CASE("bounds are for directional lights alone, lights with a position work at any scale") {
        for (const float scale : {1e-6f, 1.0f, 1e6f}) {
            test::BoxScene scene;
            scene.boxes.push_back(
                {glm::vec3(-1.0f, -1.0f, 2.0f) * scale, glm::vec3(1.0f, 1.0f, 2.1f) * scale});
            lightmesh::Settings settings;
            settings.radius = 0.3f * scale;
            settings.shadow_map_size = 128;
            const std::vector<lightmesh::Light> lamp{
                lightmesh::PointLight{glm::vec3(0.0f, 0.0f, 4.0f) * scale}};
            const lightmesh::LightMesh mesh{test::BoxTracer{&scene}, test::BoxRenderer{&scene}, lamp,
                                            settings};
            const glm::vec3 up(0.0f, 0.0f, 1.0f);
            CHECK(mesh.visibility(glm::vec3(0.0f), up, 0) == 0.0f);
            CHECK(mesh.visibility(glm::vec3(4.0f, 0.0f, 0.0f) * scale, up, 0) == 1.0f);
            const float edge = mesh.visibility(glm::vec3(2.0f, 0.0f, 0.0f) * scale, up, 0);
            CHECK(edge > 0.2f);
            CHECK(edge < 0.8f);
        }
        const test::BoxScene nothing;
        const auto with_sun = [&] {
            return lightmesh::LightMesh{
                test::BoxTracer{&nothing}, test::BoxRenderer{&nothing},
                std::vector<lightmesh::Light>{lightmesh::PointLight{}, lightmesh::DirectionalLight{}},
                lightmesh::Settings{}};
        };
        CHECK_THROWS_WITH_AS(with_sun(),
                             "lightmesh: light 1 is directional, and its shadow map needs the bounds of the "
                             "scene: give them by the settings, or the DepthRenderer a member "
                             "`lightmesh::Bounds bounds() const`",
                             std::invalid_argument);
    }

    TEST_CASE("what a ray passes by at the light's end hides nothing") {
        const glm::vec3 at(0.0f, 0.0f, 3.0f);
        const float offset = lightmesh::detail::end_offset(at, 0.25f);
        for (const float distance : {0.5f * offset, 2.0f * offset}) {
            test::BoxScene scene;
            scene.boxes.push_back({{-1.0f, -1.0f, at.z - 1.01f * distance}, {1.0f, 1.0f, at.z - distance}});
            const std::vector<lightmesh::Light> lights{lightmesh::PointLight{at}};
            auto settings = settings_of(64, false, ShortTest::none);
            settings.radius = 1.0f;
            settings.quality = 4.0f;
            const lightmesh::LightMesh by_rays{test::BoxTracer{&scene}, lights, settings};
            const lightmesh::LightMesh by_maps{test::BoxTracer{&scene}, test::BoxRenderer{&scene}, lights,
                                               settings};
            const float expected = distance < offset ? 1.0f : 0.0f;
            CHECK(by_rays.visibility({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0) == expected);
            CHECK(by_maps.visibility({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0) == expected);
        }
    }

    TEST_CASE("a renderer that fails: its own exception leaves the query, the next query asks again") {
        struct Failing : test::BoxRenderer {
            int* failures;
            void render_depth(const lightmesh::DepthView& view, std::span<float> distance) {
                BoxRenderer::render_depth(view, distance);
                if (--*failures >= 0)
                    throw std::domain_error("device lost");
            }
        };
        const auto scene = boxes_at_random(2);
        const auto points = points_on(scene, 30);
        const auto lights = lights_above();
        const auto settings = settings_of(64, false, ShortTest::linked);
        const lightmesh::LightMesh sound{test::BoxTracer{&scene}, test::BoxRenderer{&scene}, lights,
                                         settings};
        int failures = 3;
        const lightmesh::LightMesh mesh{test::BoxTracer{&scene}, Failing{{&scene}, &failures}, lights,
                                        settings};
        for (int i = 0; i < 3; ++i) {
            std::vector<float> all(lights.size());
            CHECK_THROWS_WITH_AS(mesh.visibility(points[0].position, points[0].normal, std::span<float>{all}),
                                 "device lost", std::domain_error);
            CHECK(mesh.statistics().light_points == 0);
        }
        CHECK(values(mesh, points) == values(sound, points));
        CHECK(failures < 0);
    }

    TEST_CASE("many threads on a cold mesh give the same bits as one") {
        const auto scene = boxes_at_random(3);
        const auto points = points_on(scene, 60);
        const auto lights = lights_above();
        for (const bool refine : {false, true}) {
            const auto settings = settings_of(64, refine, ShortTest::linked);
            const test::BoxTracer tracer{&scene};
            const lightmesh::LightMesh alone{tracer, test::BoxRenderer{&scene}, lights, settings};
            const std::vector<float> expected = values(alone, points);
            std::size_t views = 0;
            const lightmesh::LightMesh shared{tracer, test::BoxRenderer{&scene, &views}, lights, settings};
            std::vector<std::vector<float>> found(8);
            {
                std::vector<std::jthread> threads;
                for (std::vector<float>& mine : found)
                    threads.emplace_back([&] { mine = values(shared, points); });
            }
            for (const std::vector<float>& mine : found)
                CHECK(mine == expected);
            CHECK(views <= 6 * lights.size());
        }
    }
}

}  // namespace map_mesh_test
