// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

// Light meshes whose long tests are shadow volumes: equal to those whose long tests are rays, but for the
// band of plain.hpp, within which a ray grazes an edge, or ends on a triangle, as far as floats can tell.

namespace volume_mesh_test {

namespace {

using lightmesh::ShortTest;

struct Triangles {
    std::vector<std::array<glm::vec3, 3>> corners;
    std::size_t triangle_count() const { return corners.size(); }
    const std::array<glm::vec3, 3>& triangle(std::size_t i) const { return corners[i]; }
};

Triangles triangles_of(const std::vector<test::Triangle>& scene) {
    Triangles triangles;
    for (const test::Triangle& t : scene)
        triangles.corners.push_back({glm::vec3(t.a), glm::vec3(t.b), glm::vec3(t.c)});
    return triangles;
}

/// Boxes in a room without a gap.
std::vector<test::Triangle> closed_room(test::Random& random) {
    auto scene = test::boxes_on_floor(random, 3);
    test::add_box(scene, test::Vec(-test::scene_size), test::Vec(test::scene_size));
    return scene;
}

struct Case {
    const char* name;
    std::vector<test::Triangle> scene;
    float quality;
};

std::vector<Case> cases() {
    test::Random random(1977);
    std::vector<Case> all;
    all.push_back({"soup", test::triangle_soup(random, 30), 2.0f});
    all.push_back({"boxes", test::boxes_on_floor(random, 3), 3.0f});
    all.push_back({"walls", test::thin_walls(random), 2.5f});
    all.push_back({"closed", closed_room(random), 2.0f});
    return all;
}

/// Lights of all kinds: anywhere, next to a surface, and within a surface's own rounding of it.
std::vector<lightmesh::Light> lights_for(const std::vector<test::Triangle>& scene, test::Random& random) {
    std::vector<lightmesh::Light> lights = test::random_lights(random, 9);
    const auto points = test::surface_points(random, scene, 2);
    lights.push_back(lightmesh::PointLight{points[0].position + 0.01f * points[0].normal});
    lights.push_back(lightmesh::SpotLight{points[1].position + 1e-5f * points[1].normal, points[1].normal});
    return lights;
}

lightmesh::Settings settings_of(float quality, ShortTest short_test) {
    lightmesh::Settings settings;
    settings.radius = 1.0f;
    settings.adaptive_long_tests = false;
    settings.quality = quality;
    settings.short_test = short_test;
    return settings;
}

struct Tally {
    int all = 0, sure = 0, between = 0;
};

void compare_with_rays(const Case& c, ShortTest short_test, Tally& tally) {
    test::Random random(7);
    const auto lights = lights_for(c.scene, random);
    const auto settings = settings_of(c.quality, short_test);
    const test::PlainTracer tracer{&c.scene};
    const lightmesh::LightMesh by_rays{tracer, lights, settings};
    const lightmesh::LightMesh by_volumes{tracer, triangles_of(c.scene), lights, settings};
    const auto& grid = by_volumes.grid();
    const test::PlainMesh plain(c.scene, lights, grid.origin(), grid.step(), static_cast<double>(c.quality),
                                short_test);
    std::vector<float> rays(lights.size());
    std::vector<float> volumes(lights.size());
    for (const test::SurfacePoint& p : test::surface_points(random, c.scene, 150)) {
        by_rays.visibility(p.position, p.normal, std::span<float>{rays});
        by_volumes.visibility(p.position, p.normal, std::span<float>{volumes});
        const auto neighbours = plain.neighbours(p.position, p.normal);
        for (std::size_t light = 0; light < lights.size(); ++light) {
            CAPTURE(light);
            const test::Interval fair = plain.visibility(p.position, p.normal, neighbours, light);
            CHECK(fair.contains(volumes[light]));
            if (fair.is_sure())
                CHECK(volumes[light] == rays[light]);
            CHECK(by_volumes.visibility(p.position, p.normal, light) == volumes[light]);
            ++tally.all;
            tally.sure += fair.is_sure() ? 1 : 0;
            tally.between += fair.is_sure() && volumes[light] > 0.0f && volumes[light] < 1.0f ? 1 : 0;
        }
    }
    const lightmesh::MeshStatistics held = by_volumes.statistics();
    CHECK(held.long_rays == 0);
    CHECK(held.long_tests == by_rays.statistics().long_tests);
    CHECK(held.light_points == by_rays.statistics().light_points);
    CHECK(held.bytes > by_rays.statistics().bytes);
}

template <class Mesh>
std::vector<float> values(const Mesh& mesh, const std::vector<test::SurfacePoint>& points,
                          std::vector<std::size_t> order) {
    const std::size_t lights = mesh.light_count();
    std::vector<float> all(points.size() * lights);
    for (const std::size_t i : order)
        mesh.visibility(points[i].position, points[i].normal, std::span(all).subspan(i * lights, lights));
    return all;
}

}  // namespace

TEST_SUITE("light mesh by shadow volumes") {
    TEST_CASE("equal to the light mesh by rays, but for the band") {
        for (const ShortTest short_test : test::all_short_tests) {
            Tally tally;
            for (const Case& c : cases()) {
                CAPTURE(c.name);
                compare_with_rays(c, short_test, tally);
            }
            CHECK(tally.sure > tally.all * 9 / 10);
            CHECK(tally.between > 100);
        }
    }

    TEST_CASE("what a ray passes by at the light's end hides nothing") {
        // A plate of side 2 below a lamp, nearer to it than rays start.
        const glm::vec3 at(0.0f, 0.0f, 3.0f);
        const float step = 0.25f;
        const float offset = lightmesh::detail::end_offset(at, step);
        for (const float distance : {0.5f * offset, 2.0f * offset}) {
            std::vector<test::Triangle> scene;
            test::add_quad(scene, {-1.0, -1.0, static_cast<double>(at.z - distance)}, {2.0, 0.0, 0.0},
                           {0.0, 2.0, 0.0});
            const std::vector<lightmesh::Light> lights{lightmesh::PointLight{at}};
            const auto settings = settings_of(4.0f, ShortTest::none);
            const test::PlainTracer tracer{&scene};
            const lightmesh::LightMesh by_rays{tracer, lights, settings};
            const lightmesh::LightMesh by_volumes{tracer, triangles_of(scene), lights, settings};
            const float expected = distance < offset ? 1.0f : 0.0f;
            CHECK(by_rays.visibility({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0) == expected);
            CHECK(by_volumes.visibility({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0) == expected);
        }
    }

    TEST_CASE("many threads on a cold mesh give the same bits as one") {
        test::Random random(3);
        const auto scene = test::thin_walls(random);
        const auto lights = test::random_lights(random, 20);
        const auto points = test::surface_points(random, scene, 40);
        const test::PlainTracer tracer{&scene};
        for (const ShortTest short_test : test::all_short_tests) {
            const auto settings = settings_of(2.0f, short_test);
            std::vector<std::size_t> order;
            for (std::size_t i = 0; i < points.size(); ++i)
                order.push_back(i);
            const lightmesh::LightMesh alone{tracer, triangles_of(scene), lights, settings};
            const std::vector<float> expected = values(alone, points, order);
            const lightmesh::LightMesh shared{tracer, triangles_of(scene), lights, settings};
            std::vector<std::vector<float>> found(8);
            {
                std::vector<std::jthread> threads;
                for (std::vector<float>& mine : found) {
                    random.shuffle(order);
                    threads.emplace_back(
                        [&shared, &points, &mine, order] { mine = values(shared, points, order); });
                }
            }
            for (const std::vector<float>& mine : found)
                CHECK(mine == expected);
            CHECK(shared.statistics().light_points == alone.statistics().light_points);
        }
    }

    TEST_CASE("the triangles are copied, and may be none") {
        const std::vector<test::Triangle> nothing;
        const std::vector<lightmesh::Light> lights{lightmesh::PointLight{{0.0f, 0.0f, 5.0f}},
                                                   lightmesh::DirectionalLight{}};
        const auto settings = settings_of(2.0f, ShortTest::exact);
        const lightmesh::LightMesh mesh{test::PlainTracer{&nothing}, Triangles{}, lights, settings};
        CHECK(mesh.visibility({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0) == 1.0f);
        CHECK(mesh.visibility({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, 1) == 1.0f);
        const lightmesh::LightMesh unlit{test::PlainTracer{&nothing}, Triangles{},
                                         std::vector<lightmesh::Light>{}, settings};
        CHECK(unlit.light_count() == 0);
    }

    namespace {

    /// A scene that moves, and how often it is read, by which threads.
    struct ReadWorld {
        std::vector<std::array<glm::vec3, 3>> corners;
        lightmesh::Bounds box{glm::vec3(-1.0f), glm::vec3(1.0f)};
        std::size_t triangles_read = 0;
        std::size_t boxes_read = 0;
    };
    struct CountedTriangles {
        ReadWorld* world;
        std::size_t triangle_count() const { return world->corners.size(); }
        std::array<glm::vec3, 3> triangle(std::size_t i) const {
            ++world->triangles_read;
            return world->corners[i];
        }
    };
    struct CountedPictures {
        ReadWorld* world;
        void render_depth(const lightmesh::DepthView&, std::span<float> distance) const {
            std::ranges::fill(distance, std::numeric_limits<float>::infinity());
        }
        lightmesh::Bounds bounds() const {
            ++world->boxes_read;
            return world->box;
        }
    };

    }  // namespace

    TEST_CASE("sources are kept and read anew: when a mesh is made, and when it is told of a change") {
        const std::vector<test::Triangle> nothing;
        const std::vector<lightmesh::Light> lights{lightmesh::PointLight{.position{0, 0, 9}},
                                                   lightmesh::DirectionalLight{.direction{0, 0, -1}}};
        ReadWorld world;
        const std::array<glm::vec3, 3> roof{glm::vec3{-9, -9, 2}, glm::vec3{9, -9, 2}, glm::vec3{0, 9, 2}};
        world.corners = {roof, roof};
        lightmesh::LightMesh volumes{test::PlainTracer{&nothing}, CountedTriangles{&world}, lights,
                                     lightmesh::Settings{.short_test = ShortTest::none}};
        CHECK(world.triangles_read == 2);
        const auto share = [&] {
            return volumes.visibility({0, 0, 0}, {0, 0, 1}, std::size_t{0});
        };
        CHECK(share() == 0.0f);
        volumes.set_light(1, lightmesh::PointLight{.position{1, 1, 9}});
        CHECK(volumes.add_light(lights[1]) == 2);
        volumes.compact();
        volumes.begin_frame();
        CHECK(share() == 0.0f);
        CHECK(world.triangles_read == 2);
        // Fewer, elsewhere.
        world.corners = {{glm::vec3{20, 0, 2}, glm::vec3{21, 0, 2}, glm::vec3{20, 1, 2}}};
        volumes.scene_changed(lightmesh::Bounds{{-9, -9, 2}, {21, 9, 2}});
        CHECK(world.triangles_read == 3);
        CHECK(share() == 1.0f);
        CHECK(world.triangles_read == 3);

        lightmesh::LightMesh maps{test::PlainTracer{&nothing}, CountedPictures{&world}, lights,
                                  lightmesh::Settings{.short_test = ShortTest::none, .shadow_map_size = 4}};
        CHECK(world.boxes_read == 2);
        CHECK(maps.visibility({0, 0, 0}, {0, 0, 1}, std::size_t{1}) == 1.0f);
        CHECK(world.boxes_read == 2);
        maps.scene_changed(world.box);
        CHECK(world.boxes_read == 4);
    }

    TEST_CASE("bad triangles and lights are named") {
        const std::vector<test::Triangle> nothing;
        const auto make = [&](const Triangles& triangles, const lightmesh::Light& light) {
            return lightmesh::LightMesh{test::PlainTracer{&nothing}, triangles,
                                        std::vector<lightmesh::Light>{lightmesh::PointLight{}, light},
                                        lightmesh::Settings{}};
        };
        const float nan = std::numeric_limits<float>::quiet_NaN();
        Triangles triangles;
        triangles.corners.push_back({glm::vec3(0.0f), {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}});
        CHECK_NOTHROW(make(triangles, lightmesh::PointLight{}));
        CHECK_THROWS_WITH_AS(make(triangles, lightmesh::PointLight{{0.0f, nan, 0.0f}}),
                             "lightmesh: light 1: PointLight::position is (0, nan, 0); it must be finite",
                             std::invalid_argument);
        triangles.corners.push_back({glm::vec3(0.0f), {1.0f, nan, 0.0f}, {0.0f, 1.0f, 0.0f}});
        CHECK_THROWS_WITH_AS(make(triangles, lightmesh::PointLight{}),
                             "lightmesh: a corner of occluder 1 is (1, nan, 0); it must be finite",
                             std::invalid_argument);
    }
}

}  // namespace volume_mesh_test
