// SPDX-License-Identifier: MIT
#include "hit_tracer.hpp"
#include "plain.hpp"
#include "random_scene.hpp"
#include "still_world.hpp"

#include <lightmesh/cache_settings.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <thread>
#include <vector>

namespace moving_scenes_threads_test {

TEST_CASE("moving scenes: updates between phases of many threads") {
    test::StillWorld world(12, 40);
    auto mesh = world.mesh();
    auto cache = world.cache();
    const auto fill_by_all = [&](auto& subject) {
        std::vector<std::jthread> threads;
        for (std::size_t t = 0; t < 4; ++t)
            threads.emplace_back([&, t] {
                for (std::size_t i = 0; i < world.points.size(); ++i)
                    (void)test::ask(subject, world.points[(i + 10 * t) % world.points.size()]);
            });
    };
    test::Random random(9);
    for (int round = 0; round < 4; ++round) {
        fill_by_all(mesh);
        fill_by_all(cache);
        const std::size_t i = random.below(world.lights.size());
        world.lights[i] = lightmesh::PointLight{
            .position = glm::vec3(random.in_box({-4.0, -4.0, 1.0}, {4.0, 4.0, 4.5})), .radius = 0.4f};
        mesh.set_light(i, world.lights[i]);
        cache.set_light(i, world.lights[i]);
        const glm::vec3 at(random.in_box(test::Vec(-4.0), test::Vec(3.0)));
        world.scene.pop_back();
        const lightmesh::Bounds everywhere{glm::vec3(-6.0f), glm::vec3(6.0f)};
        mesh.scene_changed(everywhere);
        cache.scene_changed(lightmesh::Bounds{at, at + 1.0f});
        cache.scene_changed(everywhere);
    }
    fill_by_all(mesh);
    fill_by_all(cache);
    const auto new_mesh = world.mesh();
    const auto new_cache = world.cache();
    for (const lightmesh::SurfacePoint& point : world.points) {
        CHECK(test::ask(mesh, point) == test::ask(new_mesh, point));
        CHECK(test::ask(cache, point) == test::ask(new_cache, point));
    }
}

TEST_CASE("moving scenes: lights come and go and memory is given back between phases of many threads") {
    test::StillWorld world(12, 90);
    lightmesh::Settings settings{.radius = 0.9f, .quality = 3.0f, .memory_budget = 1};
    lightmesh::LightMesh mesh{test::PlainTracer{&world.scene}, world.lights, settings};
    lightmesh::CacheSettings cache_settings{.spacing = 0.4f, .detail = 2};
    {
        const lightmesh::VisibilityCache empty{test::HitTracer{&world.scene}, world.lights, cache_settings};
        cache_settings.memory_budget = empty.statistics().bytes + 20'000;
    }
    lightmesh::VisibilityCache cache{test::HitTracer{&world.scene}, world.lights, cache_settings};
    // Each phase asks for a part of the points only, so that some go unused.
    const auto ask_by_all = [&](auto& subject, std::size_t phase) {
        std::vector<std::jthread> threads;
        for (std::size_t t = 0; t < 4; ++t)
            threads.emplace_back([&, t] {
                for (std::size_t i = 0; i < 20; ++i)
                    (void)test::ask(subject, world.points[(10 * phase + i + 5 * t) % world.points.size()]);
                if (t == 3)
                    (void)subject.snapshot();
            });
    };
    test::Random random(11);
    const auto new_lamp = [&] {
        return lightmesh::PointLight{.position = glm::vec3(random.in_box({-4.0, -4.0, 1.0}, {4.0, 4.0, 4.5})),
                                     .radius = 0.4f};
    };
    const auto other_mesh = world.mesh();
    const auto other_cache = world.cache();
    other_mesh.fill(world.points);
    other_cache.fill(world.points);
    const auto mesh_bytes = other_mesh.snapshot();
    const auto cache_bytes = other_cache.snapshot();
    for (std::size_t phase = 0; phase < 8; ++phase) {
        ask_by_all(mesh, phase);
        ask_by_all(cache, phase);
        const auto of_both = [&](auto&& update) {
            update(mesh);
            update(cache);
        };
        if (phase % 2 == 0) {
            world.lights.emplace_back(new_lamp());
            of_both([&](auto& subject) {
                CHECK(subject.add_light(world.lights.back()) + 1 == world.lights.size());
            });
        } else {
            const std::size_t i = random.below(4) + phase;
            world.lights[i] = lightmesh::PointLight{.range = 0.0f};
            of_both([&](auto& subject) { subject.remove_light(i); });
            world.lights[i] = new_lamp();
            of_both([&](auto& subject) { CHECK(subject.add_light(world.lights[i]) == i); });
        }
        ask_by_all(mesh, phase + 1);
        ask_by_all(cache, phase + 1);
        mesh.merge(mesh_bytes);
        cache.merge(cache_bytes);
        ask_by_all(mesh, phase + 2);
        ask_by_all(cache, phase + 2);
        of_both([&](auto& subject) { subject.begin_frame(); });
        if (phase % 3 == 2)
            of_both([&](auto& subject) { subject.compact(); });
    }
    ask_by_all(mesh, 0);
    ask_by_all(cache, 0);
    CHECK(mesh.statistics().evicted_bricks > 0);
    CHECK(cache.statistics().evicted_records > 0);
    const auto new_mesh = world.mesh();
    const auto new_cache = world.cache();
    for (const lightmesh::SurfacePoint& point : world.points) {
        CHECK(test::ask(mesh, point) == test::ask(new_mesh, point));
        CHECK(test::ask(cache, point) == test::ask(new_cache, point));
    }
}

}  // namespace moving_scenes_threads_test
