// SPDX-License-Identifier: MIT
#include "followed_upload.hpp"
#include "gpu/mesh_queries.hpp"
#include "gpu/uploaded.hpp"
#include "hashed_tracer.hpp"
#include "plain.hpp"
#include "random_scene.hpp"
#include "render/embree_scene.hpp"
#include "render/view.hpp"
#include "render/visibility.hpp"
#include "scene/scene.hpp"
#include "seen_points.hpp"
#include "snapshot_bytes.hpp"
#include "watched_device.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/snapshot.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <bit>
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

namespace gpu_mesh_test {

/// These tests need a Vulkan driver (Mesa's lavapipe will do) and the validation layers, and fail without
/// them.

namespace {

constexpr std::uint32_t hashed_links[] = {
#include "spirv/hashed_links.comp.inc"
};

using lightmesh::Settings;
using lightmesh::ShortTest;
using lightmesh::SnapshotView;
using lightmesh::SurfacePoint;
using Mesh = lightmesh::LightMesh<test::PlainTracer>;

/// Ray by ray: packets may see the edges of triangles otherwise.
struct SingleRays {
    demo::EmbreeIntersector embree;

    bool occluded(const lightmesh::Segment& segment) const { return embree.occluded(segment); }
};

/// One for all tests, since making a device takes long.
test::WatchedDevice& watched() {
    static test::WatchedDevice one;
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

    /// Footprints of all kinds: in one step of a level and between two, at their ends, and those that are
    /// none.
    void add_footprints() {
        const float step = settings.radius / settings.quality;
        const float infinity = std::numeric_limits<float>::infinity();
        const std::array odd{0.0f,       -step,       std::numeric_limits<float>::quiet_NaN(),
                             1e-42f,     infinity,    -infinity,
                             3e38f,      0.5f * step, step,
                             2.0f * step};
        test::Random random(11);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double octave = random.uniform(-1.0, 4.0);
            const double in_blend = std::floor(octave) - 0.2 * std::pow(random.uniform(0.0, 1.0), 3.0);
            points[i].footprint = i % 4 == 0   ? odd[i / 4 % odd.size()]
                                  : i % 4 == 1 ? step * static_cast<float>(std::exp2(octave))
                                               : step * static_cast<float>(std::exp2(in_blend));
        }
    }

    test::PlainTracer tracer() const { return {&scene}; }
    Mesh mesh() const { return Mesh{tracer(), lights, settings}; }
    demo::TraceSegments trace() const { return demo::trace_by(tracer()); }
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
    static demo::MeshQueries one(watched().device, 1024, 2800);
    return one;
}

/// Asks the mesh at all points, and the device with what the mesh then knows: all bits must be the same.
void check_equal(const World& world) {
    const Mesh mesh = world.mesh();
    const std::vector<float> expected = ask(mesh, world.points);
    const std::vector<std::byte> bytes = mesh.snapshot();
    demo::MeshQueries& queries = shared_queries();
    queries.upload(bytes);
    const auto answer = queries.ask(world.points, world.trace());
    CHECK(answer.points_without_rays == 0);
    CHECK(missing_in(answer.values) == 0);
    CHECK(answer.requests.empty());
    CHECK(differing(answer.values, expected) == 0);
}

}  // namespace

TEST_CASE("gpu mesh: all q, without and with the linked short test") {
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked})
        for (const float quality : {1.0f, 1.5f, 2.0f, 3.7f, 4.0f, 5.0f, 8.0f, 8.5f, 16.0f}) {
            CAPTURE(quality);
            CAPTURE(static_cast<int>(short_test));
            check_equal(World(9, quality < 8.0f ? 100 : 12, 0.8f, quality, short_test));
        }
    CHECK(watched().messages.empty());
}

TEST_CASE("gpu mesh: the exact short test, by rays of the host, also of many lights") {
    for (const float quality : {1.0f, 2.0f, 3.7f, 8.5f}) {
        CAPTURE(quality);
        check_equal(World(9, quality < 8.0f ? 60 : 4, 0.8f, quality, ShortTest::exact));
    }
    World many(130, 20, 0.8f, 2.0f, ShortTest::exact);
    check_equal(many);
    // In a hollow that is thinner than a step a point sees none of its neighbours.
    many.settings.radius = 8.0f;
    check_equal(many);
    World blended(9, 60, 0.4f, 1.5f, ShortTest::exact);
    blended.add_footprints();
    check_equal(blended);
    CHECK(watched().messages.empty());
}

TEST_CASE("gpu mesh: at all points of small pictures, without footprints and with those of pixels") {
    for (const demo::Scene& scene : {demo::make_spheres(), demo::make_rooms(), demo::make_park()}) {
        CAPTURE(scene.name);
        const demo::EmbreeScene embree(scene);
        const int side = scene.lights.size() > 40 ? 12 : 24;
        std::vector<SurfacePoint> points = test::seen_points(embree, side);
        const float pixel_angle = demo::View(scene.camera, side, side).pixel_angle();
        for (std::size_t i = 0; i < points.size(); i += 2)
            points[i].footprint = pixel_angle * glm::distance(points[i].position, scene.camera.eye);
        for (const ShortTest short_test : {ShortTest::none, ShortTest::linked}) {
            CAPTURE(static_cast<int>(short_test));
            Settings settings = demo::options_of(scene).settings;
            settings.short_test = short_test;
            const SingleRays tracer{embree.intersector()};
            const lightmesh::LightMesh mesh{tracer, demo::shapes_of_lights(scene), settings};
            std::vector<float> expected(points.size() * mesh.light_count());
            mesh.visibility(std::span<const SurfacePoint>(points), std::span<float>(expected));
            demo::MeshQueries& queries = shared_queries();
            queries.upload(mesh.snapshot());
            const auto answer = queries.ask(points, demo::trace_by(tracer));
            CHECK(answer.points_without_rays == 0);
            CHECK(missing_in(answer.values) == 0);
            CHECK(differing(answer.values, expected) == 0);
        }
    }
    CHECK(watched().messages.empty());
}

TEST_CASE("gpu mesh: what the exact short test lacks is missing, and asked for") {
    const World world(9, 40, 0.8f, 2.0f, ShortTest::exact);
    const Mesh mesh = world.mesh();
    demo::MeshQueries& queries = shared_queries();
    queries.upload(mesh.snapshot());
    const auto cold = queries.ask(world.points, world.trace());
    CHECK(missing_in(cold.values) > 0);
    REQUIRE(!cold.requests.empty());
    // Some may stand for others beside them.
    for (int turn = 0; turn < 20; ++turn) {
        const auto answer = queries.ask(world.points, world.trace());
        if (answer.requests.empty())
            break;
        mesh.fill(answer.requests);
        queries.upload(mesh.snapshot());
    }
    const auto warm = queries.ask(world.points, world.trace());
    CHECK(missing_in(warm.values) == 0);
    CHECK(differing(warm.values, ask(mesh, world.points)) == 0);
}

TEST_CASE("gpu mesh: footprints choose levels and blend them") {
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked})
        for (const float quality : {1.5f, 4.0f, 8.5f}) {
            CAPTURE(quality);
            CAPTURE(static_cast<int>(short_test));
            World world(66, quality < 8.0f ? 400 : 40, 0.4f, quality, short_test);
            world.add_footprints();
            check_equal(world);
            world.settings.footprint_scale = quality < 2.0f ? 0.3f : 0.0f;
            world.settings.origin = glm::vec3(0.125f, -3.0f, 7.0f);
            check_equal(world);
        }
    // As far as levels go.
    World coarse(5, 60, 1e17f, 4.0f, ShortTest::none);
    coarse.add_footprints();
    check_equal(coarse);
    CHECK(watched().messages.empty());
}

TEST_CASE("gpu mesh: where a blend begins the share is that of the CPU to the last bit") {
    // The floats around the beginning of a blend.
    World world(3, 300, 0.7f, 3.0f, ShortTest::none);
    const float begin = 0.7f / 3.0f * static_cast<float>(std::exp2(-0.2));
    for (std::size_t i = 0; i < world.points.size(); ++i) {
        float footprint = std::ldexp(begin, static_cast<int>(i % 5));
        for (std::size_t k = 0; k < i / 5; ++k)
            footprint = std::nextafter(footprint, i % 2 == 0 ? 0.0f : 1e9f);
        world.points[i].footprint = footprint;
    }
    check_equal(world);
}

TEST_CASE("gpu mesh: any number of lights, also none, of all kinds, with ranges and cones") {
    for (const int light_count : {0, 1, 63, 64, 65, 256, 1024}) {
        CAPTURE(light_count);
        World world(light_count, light_count < 256 ? 60 : 12, 0.8f, 2.0f, ShortTest::linked);
        test::Random random(3);
        for (std::size_t i = 0; i < world.lights.size(); i += 5)
            world.lights[i] =
                lightmesh::RectLight{.position = glm::vec3(random.in_box(test::Vec(-5.0), test::Vec(5.0))),
                                     .half_u = glm::vec3(random.direction()),
                                     .half_v = glm::vec3(random.direction()),
                                     .range = i % 2 == 0 ? 6.0f : 1e18f};
        check_equal(world);
    }
}

TEST_CASE("gpu mesh: at the very edge of ranges, cones and horizons the CPU's doubles decide") {
    World world(1, 0, 0.8f, 2.0f, ShortTest::none);
    const float half = 0.5f * std::numbers::pi_v<float>;
    const float diagonal = std::atan(1.0f);
    world.lights = {
        lightmesh::PointLight{.position = {0.0f, 0.0f, 1.0f}},
        lightmesh::PointLight{.position = {3.0f, 4.0f, 0.0f}, .range = 5.0f},
        lightmesh::PointLight{.position = {0.1f, 0.2f, 0.3f}, .range = std::sqrt(0.14f)},
        lightmesh::PointLight{.position = {0.0f, 0.0f, 0.0f}, .range = 0.0f},
        lightmesh::PointLight{.position = {1.0f, 0.0f, 0.0f}, .range = 1e-20f},
        lightmesh::SpotLight{.position = {0.0f, 0.0f, 1.0f}, .axis = {0.0f, 0.0f, -1.0f}, .cone = diagonal},
        lightmesh::SpotLight{
            .position = {0.0f, 0.0f, 1.0f}, .axis = {0.0f, 0.0f, 1.0f}, .cone = 3.0f * diagonal},
        lightmesh::SpotLight{.position = {0.0f, 0.0f, 1.0f}, .axis = {1.0f, 0.0f, 0.0f}, .cone = half},
        lightmesh::SpotLight{.position = {0.0f, 0.0f, 1.0f}, .axis = {0.0f, 0.0f, -3.0f}, .cone = 1e-4f},
        lightmesh::RectLight{
            .position = {0.0f, 0.0f, 1.0f}, .half_u = {0.0f, 1.0f, 0.0f}, .half_v = {0.0f, 0.0f, 1.0f}},
    };
    // Points on a lattice, where all of these are hit exactly, and the floats next to them.
    const float infinity = std::numeric_limits<float>::infinity();
    for (int i = 0; i < 27; ++i) {
        glm::vec3 p(static_cast<float>(i % 3 - 1), static_cast<float>(i / 3 % 3 - 1),
                    static_cast<float>(i / 9 - 1));
        if (i % 2 == 0)
            p *= std::nextafter(1.0f, i % 4 == 0 ? infinity : 0.0f);
        for (const glm::vec3& n :
             {glm::vec3(0.0f, 0.0f, 1.0f), glm::vec3(0.0f, 1.0f, 0.0f), glm::vec3(-1.0f, 0.0f, 0.0f),
              glm::vec3(1.0f, 1.0f, 0.0f), glm::vec3(1.0f, -2.0f, 0.5f), glm::vec3(0.0f)})
            world.points.push_back({.position = p, .normal = n});
    }
    for (int i = 0; i < 40; ++i) {
        const float angle = 0.05f * static_cast<float>(i);
        world.points.push_back(
            {.position = {3.0f + 5.0f * std::cos(angle), 4.0f + 5.0f * std::sin(angle), 0.0f},
             .normal = {0.0f, 0.0f, 1.0f}});
        world.points.push_back(
            {.position = {std::cos(angle), std::sin(angle), 0.0f}, .normal = {0.0f, 0.0f, 1e-30f}});
        world.points.push_back({.position = {1e-4f * std::cos(angle), 1e-4f * std::sin(angle), 0.0f},
                                .normal = {0.0f, 0.0f, 9e20f}});
    }
    // On the horizon of the first light, and at the end of the second one's range, as near as floats come.
    test::Random random(5);
    for (int i = 0; i < 150; ++i) {
        const test::Vec n = random.direction();
        const test::Vec along = glm::normalize(glm::cross(n, random.direction()));
        world.points.push_back(
            {.position = glm::vec3(test::Vec(0.0, 0.0, 1.0) + random.uniform(0.5, 3.0) * along),
             .normal = glm::vec3(n)});
        world.points.push_back(
            {.position = glm::vec3(test::Vec(3.0, 4.0, 0.0) + 5.0 * n), .normal = glm::vec3(-n)});
    }
    check_equal(world);
}

TEST_CASE("gpu mesh: walls on planes of the grid, and steps that no float is") {
    for (const float radius : {1.0f, 3.0f, 0.7f}) {
        CAPTURE(radius);
        for (const ShortTest short_test : {ShortTest::none, ShortTest::linked}) {
            World world(6, 0, radius, 4.0f, short_test);
            world.settings.origin = glm::vec3(0.0f);
            const float step = radius / 4.0f;
            for (int i = 0; i < 60; ++i) {
                const auto whole = [i](int factor) {
                    return static_cast<float>((i * factor) % 13 - 6);
                };
                glm::vec3 n(0.0f);
                n[i % 3] = i % 2 == 0 ? 1.0f : -1.0f;
                world.points.push_back(
                    {.position = step * glm::vec3(whole(1), whole(5), whole(7)), .normal = n});
                world.points.push_back({.position = 0.5f * step * glm::vec3(whole(3), whole(2), whole(4)),
                                        .normal = n + glm::vec3(-4.37e-8f, 6.1e-17f, 0.0f)});
                world.points.push_back(
                    {.position = {step * whole(1), std::ldexp(step, -60), -std::ldexp(step, -70)},
                     .normal = glm::vec3(whole(3), whole(4), whole(5))});
            }
            check_equal(world);
        }
    }
}

TEST_CASE("gpu mesh: what bricks agree about is known also where other points have found floods") {
    // Lights of one group of which points reach few: their bricks agree about these, and have no long tests.
    World world(24, 3000, 0.3f, 2.0f, ShortTest::linked, 31);
    test::Random random(17);
    for (std::size_t i = 0; i < world.lights.size(); ++i)
        world.lights[i] =
            lightmesh::PointLight{.position = glm::vec3(random.in_box(test::Vec(-1.5), test::Vec(1.5))),
                                  .range = i % 3 == 0 ? 0.7f : 1e18f};
    for (std::size_t i = 0; i < world.points.size(); ++i)
        if (i % 2 == 1)
            world.points[i] = {.position = world.points[i - 1].position,
                               .normal = world.points[i - 1].normal + 1.5f * glm::vec3(random.direction())};
    check_equal(world);
}

TEST_CASE("gpu mesh: the box of a hemisphere ends where the CPU has it end") {
    // A light point just beyond the radius, which fixed-point numbers have within it, first of its brick.
    World world(6, 0, 2.3f, 2.3f, ShortTest::none);
    world.settings.origin = glm::vec3(0.0f);
    const double step = 2.3f / static_cast<double>(2.3f);
    test::Random random(3);
    for (int i = 0; i < 60; ++i) {
        const double units = 2.3f * 2048.0 + random.uniform(0.0, 0.1);
        glm::vec3 p(static_cast<float>(step * (4.0 - units / 2048.0)), static_cast<float>(i % 4),
                    static_cast<float>(i / 4 % 4 - 2));
        glm::vec3 n = glm::vec3(random.direction()) + glm::vec3(2.0f, 0.0f, 0.0f);
        world.points.push_back({.position = p, .normal = n});
    }
    check_equal(world);
}

TEST_CASE("gpu mesh: places halfway between two of fixed point") {
    World world(6, 0, 11.2f, 16.0f, ShortTest::none);
    world.settings.origin = glm::vec3(0.0f);
    const double step = static_cast<double>(11.2f) / 16.0;
    test::Random random(3);
    for (int i = 0; i < 120; ++i) {
        const int half = i % 3 == 0 ? 256 << i % 2 : -(i % 40);
        auto x = static_cast<float>(step * (half - 0.5) / 1024.0);
        for (int k = 0; k < 2 + i % 5; ++k)
            x = std::nextafter(x, i % 2 == 0 ? 1.0f : -1.0f);
        world.points.push_back({.position = {x, 0.3f * static_cast<float>(random.uniform(0.0, 1.0)), 0.1f},
                                .normal = {0.1f, 0.2f, 1.0f}});
    }
    check_equal(world);
}

TEST_CASE("gpu mesh: normals of any length") {
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked}) {
        World world(6, 200, 0.8f, 4.0f, short_test);
        for (std::size_t i = 0; i < world.points.size(); ++i)
            world.points[i].normal *= std::array{1e36f, 1e-35f, 3e37f, 1e-20f}[i % 4];
        check_equal(world);
    }
}

TEST_CASE("gpu mesh: far from the origin, and at any scale") {
    struct Place {
        float offset;
        float scale;
    };
    for (const Place& at : {Place{1000.0f, 1.0f}, Place{-50000.0f, 1.0f}, Place{3e6f, 1.0f},
                            Place{0.0f, 1e-6f}, Place{0.0f, 1e8f}}) {
        CAPTURE(at.offset);
        CAPTURE(at.scale);
        for (const bool follows : {false, true}) {
            World world(5, 60, 0.8f * at.scale, 3.0f, ShortTest::linked, 23);
            const auto moved = [&](const glm::vec3& v) {
                return at.scale * v + glm::vec3(at.offset, -at.offset, 0.5f * at.offset);
            };
            for (test::Triangle& t : world.scene)
                for (test::Vec* corner : {&t.a, &t.b, &t.c})
                    *corner = test::Vec(moved(glm::vec3(*corner)));
            for (std::size_t i = 0; i < world.lights.size(); ++i)
                world.lights[i] = lightmesh::PointLight{
                    .position = moved(glm::vec3(float(i) - 2.0f, 1.0f - 0.5f * float(i), 1.5f)),
                    .range = i % 2 == 0 ? 1e18f : 6.0f * at.scale};
            for (SurfacePoint& point : world.points)
                point.position = moved(point.position);
            if (follows)
                world.settings.origin = moved(glm::vec3(0.0f));
            check_equal(world);
        }
    }
}

TEST_CASE("gpu mesh: links end where the CPU's do, on all levels, far from the origin and at any scale") {
    struct Place {
        float offset;
        float scale;
        float quality;
    };
    const demo::ComputeDevice& device = watched().device;
    std::uint64_t links = 0;
    std::uint64_t open_links = 0;
    for (const Place& at : {Place{0.0f, 1.0f, 1.0f}, Place{0.0f, 1.0f, 16.0f}, Place{-50000.0f, 1.0f, 3.7f},
                            Place{3e6f, 1.0f, 3.0f}, Place{0.0f, 1e-6f, 4.0f}, Place{0.0f, 1e8f, 4.0f}}) {
        CAPTURE(at.offset);
        CAPTURE(at.scale);
        CAPTURE(at.quality);
        World world(1, at.quality < 8.0f ? 40 : 4, 0.7f * at.scale, at.quality, ShortTest::linked);
        for (std::size_t i = 0; i < world.points.size(); ++i) {
            glm::vec3& position = world.points[i].position;
            position = at.scale * position + glm::vec3(at.offset, -at.offset, 0.5f * at.offset);
            world.points[i].footprint = i % 3 == 0 ? 1.5f * at.scale : 0.0f;
        }
        const Mesh mesh = world.mesh();
        const demo::UploadedMesh uploaded(device, mesh.snapshot());
        lightmesh::LinkList list;
        mesh.list_links(world.points, list);
        mesh.fill_links(
            list, [&](std::span<const lightmesh::LinkWord> words, std::span<lightmesh::OpenLinks> open) {
                std::vector<demo::ComputeBinding> bindings = uploaded.bindings(0);
                bindings.push_back({0, lightmesh::MeshUpload::requests_binding,
                                    demo::ComputeBuffer(device, lightmesh::empty_requests(1))});
                bindings.push_back({1, 0, demo::ComputeBuffer(device, std::as_bytes(words))});
                bindings.push_back({1, 1, demo::ComputeBuffer(device, open.size_bytes())});
                const demo::ComputeKernel kernel(device, hashed_links, bindings, sizeof(std::uint32_t));
                const auto count = static_cast<std::uint32_t>(words.size());
                device.run([&](const demo::ComputeCommands& commands) {
                    commands.dispatch(kernel, (count + 63) / 64, 1, 1, std::as_bytes(std::span(&count, 1)));
                });
                bindings.back().buffer().read(0, std::as_writable_bytes(open));
                std::uint64_t differing = 0;
                for (std::size_t i = 0; i < words.size(); ++i)
                    for (int p = 0; p < 64; ++p)
                        for (int axis = 0; axis < 3; ++axis) {
                            const bool is_open = test::is_open_by_hash(mesh.link_segment(words[i], p, axis));
                            const std::uint64_t found = open[i][static_cast<std::size_t>(axis)] >> p & 1;
                            differing += is_open == (found != 0) ? 0u : 1u;
                            open_links += found;
                            ++links;
                        }
                CHECK(differing == 0);
            });
    }
    CHECK(links > 100'000);
    CHECK(open_links > links / 8);
    CHECK(open_links < links - links / 8);
    CHECK(watched().messages.empty());
}

TEST_CASE("gpu mesh: what is not known is missing, asked for and filled, until nothing is") {
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked}) {
        World world(70, 150, 0.8f, 3.0f, short_test);
        if (short_test == ShortTest::linked)
            world.add_footprints();
        const Mesh mesh = world.mesh();
        demo::MeshQueries& queries = shared_queries();
        queries.upload(mesh.snapshot());
        auto answer = queries.ask(world.points, world.trace());
        const std::vector<float> expected = ask(world.mesh(), world.points);
        CHECK(missing_in(answer.values) > 1000);
        CHECK(!answer.requests.empty());
        int rounds = 0;
        for (; missing_in(answer.values) != 0 && rounds < 30; ++rounds) {
            // What is known is right at all times, and never dark for want of knowledge.
            for (std::size_t i = 0; i < expected.size(); ++i)
                if (!std::isnan(answer.values[i]) && answer.values[i] != expected[i])
                    FAIL("point ", i / world.lights.size(), " light ", i % world.lights.size());
            CHECK(!answer.requests.empty());
            CHECK(!answer.overflowed);
            for (const SurfacePoint& point : answer.requests)
                CHECK(std::ranges::any_of(world.points, [&](const SurfacePoint& p) {
                    return p.position == point.position && p.normal == point.normal &&
                           std::bit_cast<std::uint32_t>(p.footprint) ==
                               std::bit_cast<std::uint32_t>(point.footprint);
                }));
            mesh.fill(answer.requests);
            queries.upload(mesh.snapshot());
            answer = queries.ask(world.points, world.trace());
        }
        CHECK(rounds > 0);
        CHECK(rounds < 30);
        CHECK(answer.requests.empty());
        CHECK(differing(answer.values, expected) == 0);
    }
}

TEST_CASE("gpu mesh: requests beyond the room for them are not lost in silence") {
    const World world(3, 400, 0.4f, 2.0f, ShortTest::none);
    const Mesh mesh = world.mesh();
    demo::MeshQueries queries(watched().device, 8, 24);
    queries.upload(mesh.snapshot());
    auto answer = queries.ask(world.points, world.trace());
    CHECK(answer.overflowed);
    CHECK(answer.requests.size() == 8);
    int rounds = 0;
    for (; !answer.requests.empty() && rounds < 200; ++rounds) {
        mesh.fill(answer.requests);
        queries.upload(mesh.snapshot());
        answer = queries.ask(world.points, world.trace());
    }
    CHECK(rounds < 200);
    CHECK(!answer.overflowed);
    CHECK(differing(answer.values, ask(mesh, world.points)) == 0);
}

TEST_CASE("gpu mesh: points that are nowhere are missing, not dark") {
    World world(2, 1, 0.8f, 2.0f, ShortTest::none);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    const SurfacePoint good = world.points.front();
    for (const glm::vec3& p :
         {glm::vec3(nan, 0.0f, 0.0f), glm::vec3(0.0f, infinity, 0.0f), glm::vec3(0.0f, 0.0f, 1e9f)})
        world.points.push_back({.position = p, .normal = good.normal});
    world.points.push_back({.position = good.position, .normal = {0.0f, -infinity, 0.0f}});
    const Mesh mesh = world.mesh();
    const auto expected = ask(mesh, {good});
    demo::MeshQueries& queries = shared_queries();
    queries.upload(mesh.snapshot());
    const auto answer = queries.ask(world.points, world.trace());
    REQUIRE(answer.values.size() == 10);
    CHECK(differing({answer.values.begin(), answer.values.begin() + 2}, expected) == 0);
    CHECK(missing_in(answer.values) == 8);
    CHECK(answer.requests.empty());
}

TEST_CASE("gpu mesh: an upload that follows changes answers as a fresh one, and writes little") {
    World world(70, 120, 0.8f, 3.0f, ShortTest::linked);
    world.add_footprints();
    Mesh mesh = world.mesh();
    const auto few = std::span<const SurfacePoint>(world.points).first(100);
    mesh.fill(few);
    const std::vector<std::byte> first_bytes = mesh.snapshot();
    lightmesh::MeshUpload upload{SnapshotView(first_bytes)};
    test::FollowedUpload host(upload);
    // Enough rays where a point has no neighbours, with all lights and on two levels.
    constexpr std::uint32_t rays_per_point = 400;
    demo::MeshQueries followed(watched().device, 1024, rays_per_point);
    followed.upload(mesh.snapshot());
    const std::size_t all_bytes = host.size();

    demo::MeshQueries fresh(watched().device, 1024, rays_per_point);
    const std::vector<std::byte> another_grid = World(3, 0, 0.7f, 3.0f, ShortTest::none).mesh().snapshot();
    const auto check = [&] {
        const std::vector<std::byte> bytes = mesh.snapshot();
        const std::size_t written = host.write(upload, upload.update(SnapshotView(bytes)));
        CHECK(host.equals(upload));
        followed.upload(bytes);
        // A mesh on another grid in between: then the upload begins anew.
        fresh.upload(another_grid);
        fresh.upload(bytes);
        const auto expected = fresh.ask(world.points, world.trace()).values;
        CHECK(differing(followed.ask(world.points, world.trace()).values, expected) == 0);
        return written;
    };
    CHECK(check() == 0);
    mesh.fill(std::span<const SurfacePoint>(world.points).subspan(100, 2));
    CHECK(check() < all_bytes / 4);
    const auto check_filled = [&] {
        // Snapshots keep lights in the order of a new mesh, and so does one that is compact.
        mesh.compact();
        mesh.fill(world.points);
        check();
        CHECK(missing_in(followed.ask(world.points, world.trace()).values) == 0);
    };
    mesh.set_light(3, lightmesh::PointLight{.position = {1.0f, 0.5f, 0.25f}, .range = 3.0f});
    check();
    check_filled();
    // Lights that stay in their order must be kept by whole groups, too.
    mesh.scene_changed(lightmesh::Bounds{glm::vec3(0.25f), glm::vec3(1.25f)});
    check();
    check_filled();
    mesh.scene_changed(lightmesh::Bounds{glm::vec3(-1.0f), glm::vec3(1.0f)});
    mesh.remove_light(5);
    check();
    check_filled();
    for (int i = 0; i < 80; ++i)
        mesh.add_light(lightmesh::PointLight{.position = {0.1f * static_cast<float>(i), 1.0f, 1.0f}});
    check();
    check_filled();
    CHECK(differing(followed.ask(world.points, world.trace()).values, ask(mesh, world.points)) == 0);
}

TEST_CASE("gpu mesh: what cannot be served never reaches a device") {
    const World world(3, 40, 0.8f, 2.0f, ShortTest::linked);
    const Mesh mesh = world.mesh();
    mesh.fill(world.points);
    std::vector<std::byte> bytes = mesh.snapshot();
    // Not before its bytes are right is there a view, and without a view no upload.
    bytes[bytes.size() / 2] ^= std::byte{1};
    CHECK_THROWS_AS(SnapshotView{std::span<const std::byte>(bytes)}, std::invalid_argument);
    test::sign<lightmesh::detail::SnapshotHeader>(bytes);
    bytes[bytes.size() / 2] ^= std::byte{1};
    test::sign<lightmesh::detail::SnapshotHeader>(bytes);
    lightmesh::MeshUpload upload{SnapshotView(bytes)};

    CHECK_FALSE(upload.is_exact());
    World exact = world;
    exact.settings.short_test = ShortTest::exact;
    const std::vector<std::byte> of_exact = exact.mesh().snapshot();
    CHECK(lightmesh::MeshUpload{SnapshotView(of_exact)}.is_exact());
    CHECK(upload.update(SnapshotView(bytes)).empty());
    const lightmesh::VisibilityCache cache(world.tracer(), world.lights,
                                           lightmesh::CacheSettings{.spacing = 0.5f});
    const std::vector<std::byte> of_cache = cache.snapshot();
    CHECK_THROWS_AS(lightmesh::MeshUpload{SnapshotView(of_cache)}, std::invalid_argument);
}

TEST_CASE("gpu requests: bytes that are none are refused") {
    CHECK_THROWS_AS(lightmesh::empty_requests(0), std::invalid_argument);
    CHECK_THROWS_AS(lightmesh::empty_requests((std::size_t{1} << 26) + 1), std::invalid_argument);
    std::vector<std::byte> bytes = lightmesh::empty_requests(3);
    CHECK(lightmesh::read_requests(bytes).points.empty());
    CHECK_THROWS_AS(lightmesh::read_requests(std::span<const std::byte>(bytes).first(bytes.size() - 4)),
                    std::invalid_argument);
    CHECK_THROWS_AS(lightmesh::read_requests({}), std::invalid_argument);
    const std::uint32_t count = 7;
    std::memcpy(bytes.data(), &count, sizeof count);
    CHECK(lightmesh::read_requests(bytes).points.size() == 3);
    CHECK(lightmesh::read_requests(bytes).overflowed);
}

TEST_CASE("gpu: the validation layer had nothing to say") {
    CHECK(watched().messages.empty());
}

}  // namespace gpu_mesh_test
