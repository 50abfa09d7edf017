// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>
#include <glm/vec3.hpp>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

// How many segments an adapter gets at once.

namespace batches_test {

namespace {

struct Seen {
    std::size_t calls = 0;
    std::size_t largest = 0;
    std::size_t segments = 0;
};

/// As `test::PlainTracer`, in batches; notes what it was asked.
struct Counting {
    const std::vector<test::Triangle>* triangles;
    Seen* seen;

    bool occluded(const lightmesh::Segment& segment) const {
        return test::PlainTracer{triangles}.occluded(segment);
    }
    void occluded(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) const {
        REQUIRE(segments.size() == hit.size());
        REQUIRE(!segments.empty());
        ++seen->calls;
        seen->largest = (std::max)(seen->largest, segments.size());
        seen->segments += segments.size();
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = occluded(segments[i]) ? 1 : 0;
    }
};

template <std::size_t Most>
struct UpTo : Counting {
    static constexpr std::size_t max_batch = Most;
};

struct Work {
    std::vector<test::Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;

    Work() {
        test::Random random(811);
        scene = test::boxes_on_floor(random, 10);
        lights = test::random_lights(random, 70);
        for (const test::SurfacePoint& p : test::surface_points(random, scene, 12)) {
            positions.push_back(p.position);
            normals.push_back(p.normal);
        }
    }
};

template <class Tracer>
std::vector<float> ask(const Work& work, const Tracer& tracer, lightmesh::ShortTest short_test,
                       bool adaptive) {
    const lightmesh::LightMesh mesh{
        tracer, work.lights,
        lightmesh::Settings{
            .radius = 0.8f, .quality = 3.0f, .short_test = short_test, .adaptive_long_tests = adaptive}};
    std::vector<float> all(work.positions.size() * work.lights.size());
    mesh.visibility(work.positions, work.normals, all);
    return all;
}

}  // namespace

TEST_CASE("calls hold up to 64 segments, or as many as the adapter declares, with the same results") {
    const Work work;
    for (const lightmesh::ShortTest short_test : test::all_short_tests) {
        for (const bool adaptive : {true, false}) {
            Seen plain;
            const std::vector<float> expected =
                ask(work, Counting{&work.scene, &plain}, short_test, adaptive);
            CHECK(plain.largest <= 64);
            CHECK(plain.largest > 32);
            Seen few;
            CHECK(ask(work, UpTo<5>{{&work.scene, &few}}, short_test, adaptive) == expected);
            CHECK(few.largest == 5);
            Seen many;
            CHECK(ask(work, UpTo<300>{{&work.scene, &many}}, short_test, adaptive) == expected);
            CHECK(many.largest <= 300);
            CHECK(many.largest > 128);
            CHECK(many.calls < plain.calls);
            CHECK(many.segments == plain.segments);
            Seen endless;
            CHECK(ask(work, UpTo<(std::size_t{1} << 40)>{{&work.scene, &endless}}, short_test, adaptive) ==
                  expected);
            CHECK(endless.largest <= 1024);
        }
    }
}

TEST_CASE("many points at once have the values that each has alone, also where they jump to and fro") {
    constexpr float step = 0.8f / 4.0f;
    test::Random random(100);
    const std::vector<test::Triangle> scene = test::boxes_on_floor(random, 25);
    const std::vector<lightmesh::Light> lights = test::random_lights(random, 10);
    const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights,
                                    lightmesh::Settings{.radius = 0.8f, .quality = 4.0f}};
    const std::vector<test::SurfacePoint> places = test::surface_points(random, scene, 12);
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    for (int i = 0; i < 2000; ++i) {
        const test::SurfacePoint& place = places[random.below(3)];
        const float way = 8.0f * step * (static_cast<float>(random.below(3)) - 1.0f);
        glm::vec3 jump(0.0f);
        jump[static_cast<int>(random.below(3))] = way;
        positions.push_back(place.position + jump);
        normals.push_back(place.normal);
    }
    std::vector<float> all(positions.size() * lights.size());
    mesh.visibility(positions, normals, all);
    std::vector<float> alone(lights.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        CAPTURE(i);
        mesh.visibility(positions[i], normals[i], alone);
        CHECK(std::ranges::equal(alone, std::span(all).subspan(i * lights.size(), lights.size())));
    }
}

}  // namespace batches_test
