// SPDX-License-Identifier: MIT
#include "../examples/adapters/embree_intersector.hpp"
#include "../examples/render/embree_scene.hpp"
#include "../examples/scene/random.hpp"
#include "../examples/scene/scene.hpp"
#include "seen_points.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

// How many rays Embree traces at once is found by the clock when an adapter is made: answers must not depend
// on it.

namespace embree_intersector_test {

namespace {

using Batches = demo::EmbreeIntersector::Batches;

/// Loose triangles of which light passes every other one by chance.
demo::Scene half_clear() {
    demo::Scene scene;
    scene.materials.resize(2);
    scene.materials[1].alpha_mode = demo::AlphaMode::blend;
    scene.materials[1].shadow = demo::ShadowBy::opacity;
    scene.materials[1].opacity = 0.5f;
    demo::Random random(27);
    const auto place = [&] {
        return 2.0f * random.uniform() - 1.0f;
    };
    for (std::uint32_t t = 0; t < 200; ++t) {
        const glm::vec3 middle{3.0f * place(), 3.0f * place(), 3.0f * place()};
        for (int k = 0; k < 3; ++k)
            scene.positions.push_back(middle + glm::vec3(place(), place(), place()));
        scene.triangles.push_back({{3 * t, 3 * t + 1, 3 * t + 2}, t % 2});
    }
    scene.normals.assign(scene.positions.size(), {0.0f, 0.0f, 1.0f});
    return scene;
}

/// From places in the box around a scene's triangles to a light, as long tests have them, and to each other.
std::vector<lightmesh::Segment> segments_in(const demo::Scene& scene, int count) {
    glm::vec3 low = scene.positions.front();
    glm::vec3 high = low;
    for (const glm::vec3& position : scene.positions) {
        low = (glm::min)(low, position);
        high = (glm::max)(high, position);
    }
    demo::Random random(3);
    const auto place = [&] {
        return low + glm::vec3(random.uniform(), random.uniform(), random.uniform()) * (high - low);
    };
    std::vector<lightmesh::Segment> segments;
    glm::vec3 light = place();
    for (int i = 0; i < count; ++i) {
        if (i % 100 == 0)
            light = place();
        segments.push_back({place(), i % 2 == 0 ? light : place()});
    }
    return segments;
}

void check_answers(const demo::Scene& scene) {
    const demo::EmbreeScene traced(scene);
    const std::array adapters{demo::EmbreeIntersector(traced.handle(), Batches::packets),
                              demo::EmbreeIntersector(traced.handle(), Batches::streams),
                              demo::EmbreeIntersector(traced.handle())};
    const std::vector<lightmesh::Segment> segments = segments_in(scene, 20000);
    std::vector<std::uint8_t> alone;
    std::size_t blocked = 0;
    for (const lightmesh::Segment& segment : segments) {
        alone.push_back(adapters[0].occluded(segment) ? 1 : 0);
        blocked += alone.back();
    }
    CHECK(blocked > segments.size() / 50);
    CHECK(blocked < segments.size());
    for (const demo::EmbreeIntersector& adapter : adapters) {
        CAPTURE(static_cast<int>(adapter.batches()));
        // All at once, and by calls of any size.
        for (const std::size_t most : {segments.size(), std::size_t{1}, std::size_t{7}, std::size_t{64}}) {
            std::vector<std::uint8_t> hit(segments.size(), 2);
            for (std::size_t first = 0; first < segments.size(); first += most) {
                const std::size_t size = (std::min)(most, segments.size() - first);
                adapter.occluded(std::span(segments).subspan(first, size),
                                 std::span(hit).subspan(first, size));
            }
            CHECK(hit == alone);
        }
    }
}

}  // namespace

TEST_CASE("packets and streams and single rays of Embree have the same answers") {
    SUBCASE("in rooms") {
        check_answers(demo::make_rooms());
    }
    SUBCASE("in the park") {
        check_answers(demo::make_park());
    }
    SUBCASE("where light passes by chance") {
        check_answers(half_clear());
    }
}

TEST_CASE("a light mesh by packets of Embree is that by its streams to the bit") {
    const demo::Scene scene = demo::make_park();
    const demo::EmbreeScene traced(scene);
    const std::vector<lightmesh::Light> lights = demo::shapes_of_lights(scene);
    const lightmesh::Settings settings{.radius = scene.radius, .quality = scene.quality};
    const std::vector<lightmesh::SurfacePoint> points = test::seen_points(traced, 24);
    std::array<std::vector<float>, 3> found;
    const std::array adapters{demo::EmbreeIntersector(traced.handle(), Batches::packets),
                              demo::EmbreeIntersector(traced.handle(), Batches::streams),
                              demo::EmbreeIntersector(traced.handle())};
    for (std::size_t i = 0; i < adapters.size(); ++i) {
        const lightmesh::LightMesh mesh{adapters[i], lights, settings};
        found[i].resize(points.size() * lights.size());
        mesh.visibility(std::span<const lightmesh::SurfacePoint>(points), std::span<float>(found[i]));
    }
    CHECK(found[1] == found[0]);
    CHECK(found[2] == found[0]);
}

}  // namespace embree_intersector_test
