// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/surface_point.hpp>

#include <doctest/doctest.h>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

// What a camera that comes nearer sees of a light mesh: no value jumps from one frame to the next.

namespace moving_camera_test {

namespace {

using lightmesh::ShortTest;
using lightmesh::SurfacePoint;
using Mesh = lightmesh::LightMesh<test::PlainTracer>;

constexpr float step = 0.1f;
constexpr int frames = 600;

/// The middle of what a camera sees that flies over a floor, from 4 to 0.4 above it: both where it is and how
/// wide a pixel is there change.
SurfacePoint seen_in_frame(int frame, bool is_blended) {
    const float share = static_cast<float>(frame) / static_cast<float>(frames);
    const float distance = 4.0f * std::exp2(-3.3f * share);
    SurfacePoint point{.position = {0.02f * distance - 0.5f + 0.3f * share, 0.2f + 0.1f * share, -2.0f},
                       .normal = {0.0f, 0.0f, 1.0f},
                       .footprint = 0.25f * distance};
    // What levels without blends would be: the next octave's begin instead of where between two it lies.
    if (!is_blended)
        point.footprint = step * std::exp2(std::ceil(std::log2(point.footprint / step)) - 0.5f);
    return point;
}

/// The largest difference of a light's S from one frame to the next.
float largest_step(ShortTest short_test, bool is_blended) {
    test::Random random(57);
    const std::vector<test::Triangle> scene = test::thin_walls(random);
    // Between floor and ceiling, so that no light comes or goes.
    std::vector<lightmesh::Light> lights;
    for (int i = 0; i < 40; ++i)
        lights.emplace_back(
            lightmesh::PointLight{glm::vec3(random.in_box({-5.0, -5.0, -1.8}, {5.0, 5.0, 1.9}))});
    lightmesh::Settings settings;
    settings.radius = 8.0f * step;
    settings.quality = 8.0f;
    settings.short_test = short_test;
    const Mesh mesh{test::PlainTracer{&scene}, lights, settings};
    std::vector<float> before(lights.size());
    std::vector<float> now(lights.size());
    float largest = 0.0f;
    for (int frame = 0; frame < frames; ++frame) {
        mesh.visibility(seen_in_frame(frame, is_blended), now);
        for (std::size_t l = 0; frame > 0 && l < now.size(); ++l)
            largest = (std::max)(largest, std::abs(now[l] - before[l]));
        std::swap(now, before);
    }
    return largest;
}

}  // namespace

TEST_CASE("nothing pops while a camera comes nearer as it would without blends of levels") {
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked}) {
        CAPTURE(static_cast<int>(short_test));
        // A blend, a fifth of an octave, takes 36 frames.
        CHECK(largest_step(short_test, true) < 1.5f / 36.0f);
        CHECK(largest_step(short_test, false) > 0.2f);
    }
}

}  // namespace moving_camera_test
