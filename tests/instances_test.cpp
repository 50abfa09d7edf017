// SPDX-License-Identifier: MIT

// Scenes with instances, against the same triangles where they are drawn.

#include "render/embree_scene.hpp"
#include "render/scene_occluders.hpp"
#include "scene/boxes.hpp"
#include "scene/instances.hpp"
#include "scene/random.hpp"
#include "scene/scene.hpp"
#include "scene/scene_change.hpp"

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

namespace instances_test {

namespace {

/// A floor, and a part of 40 triangles in a cube of side 2 around 0, every fourth of them half clear; three
/// instances of it, one a mirror image.
demo::Scene make_scene() {
    demo::Scene scene;
    scene.materials.resize(2);
    scene.materials[1].alpha_mode = demo::AlphaMode::blend;
    scene.materials[1].opacity = 0.5f;
    scene.positions = {{-6, -6, -2}, {6, -6, -2}, {6, 6, -2}, {-6, 6, -2}};
    scene.triangles = {{{0, 1, 2}, 0}, {{0, 2, 3}, 0}};
    demo::Random random(7);
    const auto place = [&] {
        return 2.0f * random.uniform() - 1.0f;
    };
    scene.parts = {{4, 120, 2, 40}};
    for (std::uint32_t t = 0; t < 40; ++t) {
        const glm::vec3 middle{place(), place(), place()};
        for (int k = 0; k < 3; ++k)
            scene.positions.push_back(glm::clamp(middle + 0.4f * glm::vec3(place(), place(), place()),
                                                 glm::vec3(-1.0f), glm::vec3(1.0f)));
        scene.triangles.push_back({{4 + 3 * t, 5 + 3 * t, 6 + 3 * t}, t % 4 == 0 ? 1u : 0u});
    }
    for (const glm::vec3& position : scene.positions)
        scene.normals.push_back(glm::normalize(position + glm::vec3(0.0f, 0.0f, 0.1f)));
    scene.instances = {{0, {1, 0, 0, 0, 1, 0, 0, 0, 1, -2.5f, 0, 0}},
                       {0, {0.5f, 0.5f, 0, -0.7f, 0.7f, 0.1f, 0, 0.2f, 1.1f, 2, 1, 0}},
                       {0, {-1, 0, 0, 0, 0.8f, 0, 0, 0.3f, 1, 0, -3, 1}}};
    return scene;
}

/// The same without instances; mirror images go round the other way.
demo::Scene made_flat(const demo::Scene& scene) {
    demo::Scene flat = scene;
    flat.parts.clear();
    flat.instances.clear();
    flat.positions.resize(4);
    flat.normals.resize(4);
    flat.triangles.resize(2);
    for (const demo::Instance& instance : scene.instances)
        for (std::size_t t = 2; t < scene.triangles.size(); ++t) {
            demo::Triangle triangle = scene.triangles[t];
            for (std::uint32_t& vertex : triangle.vertex) {
                flat.positions.push_back(demo::placed(instance, scene.positions[vertex]));
                flat.normals.push_back(demo::placed_normal(instance, scene.normals[vertex]));
                vertex = static_cast<std::uint32_t>(flat.positions.size()) - 1;
            }
            if (demo::is_mirrored(instance))
                std::swap(triangle.vertex[1], triangle.vertex[2]);
            flat.triangles.push_back(triangle);
        }
    return flat;
}

/// What rays from around the scene meet in both.
void compare(const demo::EmbreeScene& shared, const demo::EmbreeScene& flat) {
    demo::Random random(11);
    const auto place = [&] {
        return 10.0f * (random.uniform() - 0.5f);
    };
    const auto tracer = shared.intersector();
    const auto flat_tracer = flat.intersector();
    int hits = 0;
    int misses = 0;
    int blocked = 0;
    for (int i = 0; i < 4000; ++i) {
        const lightmesh::Segment segment{{place(), place(), place()}, {place(), place(), place()}};
        const glm::vec3 way = segment.target - segment.origin;
        const auto found = shared.trace(segment.origin, glm::normalize(way), glm::length(way));
        const auto expected = flat.trace(segment.origin, glm::normalize(way), glm::length(way));
        const auto closest = tracer.closest_hit(segment);
        const bool is_same = found.has_value() == expected.has_value() &&
                             (!found || glm::distance(found->position, expected->position) < 1e-4f);
        misses += is_same ? 0 : 1;
        blocked += tracer.occluded(segment) != flat_tracer.occluded(segment) ? 1 : 0;
        if (!is_same || !found || !closest)
            continue;
        hits += flat.scene().triangles[expected->triangle].material == 1 ? 1 : 0;
        CHECK(found->material == expected->material);
        CHECK(found->from_inside == expected->from_inside);
        CHECK(glm::distance(found->geometric_normal, expected->geometric_normal) < 1e-3f);
        CHECK(glm::distance(found->shading_normal, expected->shading_normal) < 1e-3f);
        CHECK(std::abs(glm::dot(closest->normal, expected->geometric_normal)) > 0.999f);
        CHECK(closest->distance ==
              doctest::Approx(glm::distance(segment.origin, found->position)).epsilon(1e-3));
    }
    CHECK(hits > 20);
    CHECK(misses < 8);     // at edges
    CHECK(blocked < 200);  // chance has decided anew on what is half clear
}

}  // namespace

TEST_CASE("demo: rays meet instances where they meet copies, also after both have moved") {
    demo::Scene scene = make_scene();
    demo::Scene flat = made_flat(scene);
    demo::EmbreeScene shared(scene, demo::EmbreeScene::For::films);
    demo::EmbreeScene copies(flat, demo::EmbreeScene::For::films);
    compare(shared, copies);
    CHECK(demo::drawn_triangles(scene) == flat.triangles.size());

    const demo::Scene before = scene;
    SUBCASE("one instance") {
        scene.instances[1].transform[3] += glm::vec3(0.5f, 0.0f, 0.2f);
    }
    SUBCASE("the part") {
        for (std::size_t i = 4; i < scene.positions.size(); ++i)
            scene.positions[i] *= 0.7f;
    }
    const demo::SceneChange change = demo::difference(before, scene);
    CHECK_FALSE(change.is_another_scene);
    CHECK(change.boxes.size() >= 1);
    const demo::Scene flat_before = flat;
    flat = made_flat(scene);
    // All that moved lies in the boxes that are told, and what did not move lies in none.
    for (std::size_t i = 0; i < flat.positions.size(); ++i) {
        const bool moved = flat.positions[i] != flat_before.positions[i];
        for (const glm::vec3& p : {flat.positions[i], flat_before.positions[i]}) {
            const bool is_told = std::ranges::any_of(change.boxes, [&](const lightmesh::Bounds& box) {
                return glm::clamp(p, box.low - 1e-4f, box.high + 1e-4f) == p;
            });
            CHECK((!moved || is_told));
        }
    }
    CHECK(
        std::ranges::none_of(change.boxes, [](const lightmesh::Bounds& box) { return box.low.z < -1.99f; }));
    shared.update(change);
    copies.update(demo::difference(flat_before, flat));
    compare(shared, copies);
}

TEST_CASE("demo: what knows only triangles in their places refuses instances by name") {
    const demo::Scene scene = make_scene();
    CHECK_THROWS_WITH_AS(demo::indices_of(scene), "a list of triangles cannot draw the scene's 3 instances",
                         std::invalid_argument);
    CHECK_THROWS_WITH_AS(demo::SceneOccluders{scene}, "shadow volumes cannot draw the scene's 3 instances",
                         std::invalid_argument);
    const demo::Scene flat = made_flat(scene);
    CHECK(demo::indices_of(flat).size() == 3 * flat.triangles.size());
    const demo::Bounds all = demo::bounds_of(scene);
    const demo::Bounds exact = demo::bounds_of(flat);
    for (int axis = 0; axis < 3; ++axis) {
        CHECK(all.low[axis] <= exact.low[axis]);
        CHECK(all.high[axis] >= exact.high[axis]);
    }
    CHECK(demo::diagonal_of(all) < 1.3f * demo::diagonal_of(exact));
    demo::Scene other = scene;
    other.instances.pop_back();
    CHECK(demo::difference(scene, other).is_another_scene);
}

}  // namespace instances_test
