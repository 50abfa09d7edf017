// SPDX-License-Identifier: MIT
#include "gpu/mesh_queries.hpp"
#include "plain.hpp"
#include "random_scene.hpp"
#include "snapshot_bytes.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/snapshot.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

/// These tests need a Vulkan driver (Mesa's lavapipe will do) and the validation layers, and fail without them.

namespace {

using lightmesh::Settings;
using lightmesh::ShortTest;
using lightmesh::SnapshotView;
using lightmesh::SurfacePoint;
using Mesh = lightmesh::LightMesh<test::PlainTracer>;

std::vector<std::string>& messages() {
    static std::vector<std::string> all;
    return all;
}

/// One for all tests, since making a device takes long; under the validation layer.
const demo::ComputeDevice& device() {
    static const demo::ComputeDevice one(
        {.validate = true, .on_message = [](const std::string& text) { messages().push_back(text); }});
    return one;
}

struct World {
    std::vector<test::Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<SurfacePoint> points;
    Settings settings;

    explicit World(int light_count, int point_count, float radius, float quality, ShortTest short_test,
                   std::uint64_t seed = 7) {
        test::Random random(seed);
        scene = test::thin_walls(random);
        lights = test::random_lights(random, light_count);
        for (const test::SurfacePoint& point : test::surface_points(random, scene, point_count))
            points.push_back({.position = point.position, .normal = point.normal});
        settings.radius = radius;
        settings.quality = quality;
        settings.short_test = short_test;
    }

    test::PlainTracer tracer() const { return {&scene}; }
    Mesh mesh() const { return Mesh{tracer(), lights, settings}; }
    demo::TraceSegments trace() const {
        return [by = tracer()](std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) {
            for (std::size_t i = 0; i < segments.size(); ++i)
                hit[i] = by.occluded(segments[i]) ? 1 : 0;
        };
    }
};

std::vector<float> ask(const Mesh& mesh, const std::vector<SurfacePoint>& points) {
    std::vector<float> all(points.size() * mesh.light_count());
    mesh.visibility(std::span<const SurfacePoint>(points), std::span<float>(all));
    return all;
}

/// Number of values that are not the same bits.
std::size_t differing(const std::vector<float>& a, const std::vector<float>& b) {
    REQUIRE(a.size() == b.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        count += std::bit_cast<std::uint32_t>(a[i]) != std::bit_cast<std::uint32_t>(b[i]) ? 1u : 0u;
    return count;
}

std::size_t missing_in(const std::vector<float>& values) {
    return static_cast<std::size_t>(
        std::ranges::count_if(values, [](float value) { return std::isnan(value); }));
}

/// One for many tests, since compiling its shaders takes long.
demo::MeshQueries& shared_queries() {
    static demo::MeshQueries one(device(), 1024, 100);
    return one;
}

/// Asks the mesh at all points, and the device with what the mesh then knows: all bits must be the same.
void check_equal(const World& world) {
    const Mesh mesh = world.mesh();
    const std::vector<float> expected = ask(mesh, world.points);
    const std::vector<std::byte> bytes = mesh.snapshot();
    demo::MeshQueries& queries = shared_queries();
    queries.upload(SnapshotView(bytes));
    const auto answer = queries.ask(world.points, world.trace());
    CHECK(answer.points_without_rays == 0);
    CHECK(missing_in(answer.values) == 0);
    CHECK(answer.requests.empty());
    CHECK(differing(answer.values, expected) == 0);
}

}  // namespace

TEST_CASE("gpu: all q, without and with the linked short test") {
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked})
        for (const float quality : {1.0f, 1.5f, 2.0f, 3.7f, 4.0f, 5.0f, 8.0f, 8.5f, 16.0f}) {
            CAPTURE(quality);
            CAPTURE(static_cast<int>(short_test));
            check_equal(World(12, 150, 0.8f, quality, short_test));
        }
    CHECK(messages().empty());
}
