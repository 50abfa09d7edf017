// SPDX-License-Identifier: MIT
#include "random_scene.hpp"
#include "still_world.hpp"

#include <lightmesh/light_mesh.hpp>
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

}  // namespace moving_scenes_threads_test
