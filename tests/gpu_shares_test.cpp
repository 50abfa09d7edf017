// SPDX-License-Identifier: MIT
#include "gpu/compute.hpp"
#include "hashed_tracer.hpp"
#include "hit_tracer.hpp"
#include "random_scene.hpp"
#include "watched_device.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <vector>

// Shares of lamps that shaders find, against those that the CPU finds by the same tracer. These tests need a
// Vulkan driver: Mesa's lavapipe will do.

namespace gpu_shares_test {

namespace {

using lightmesh::Segment;
using Cache = lightmesh::VisibilityCache<test::HitTracer>;

constexpr std::uint32_t hashed_words[] = {
#include "spirv/hashed_shares.comp.inc"
};

void find_on_cpu(std::span<const Segment> segments, std::span<std::uint8_t> hit) {
    for (std::size_t i = 0; i < segments.size(); ++i)
        hit[i] = test::is_open_by_hash(segments[i]) ? 0 : 1;
}

class HashedShares {
public:
    explicit HashedShares(const demo::ComputeDevice& device) : device_(device) {}

    void operator()(std::span<const std::byte> work, std::span<std::uint32_t> found) {
        const demo::ComputeBuffer words(device_, work);
        const demo::ComputeBuffer values(device_, found.size_bytes());
        const std::vector<demo::ComputeBinding> bindings{{0, 0, words}, {0, 1, values}};
        if (!kernel_)
            kernel_.emplace(device_, hashed_words, bindings, sizeof(std::uint32_t));
        for (const demo::ComputeBinding& binding : bindings)
            kernel_->bind(binding);
        // In two parts.
        const auto half = static_cast<std::uint32_t>(found.size() / 8 * 4);
        const auto groups = static_cast<std::uint32_t>((found.size() + 3) / 4);
        device_.run([&](const demo::ComputeCommands& commands) {
            const std::uint32_t none = 0;
            if (half != 0)
                commands.dispatch(*kernel_, half / 4, 1, 1, std::as_bytes(std::span(&none, 1)));
            commands.dispatch(*kernel_, groups - half / 4, 1, 1, std::as_bytes(std::span(&half, 1)));
        });
        values.read(0, std::as_writable_bytes(found));
        REQUIRE(found.size() <= lightmesh::most_listed_shares);
        REQUIRE(work.size() <= (std::size_t{18} << 20) + 64 * 1000);
        ++calls;
    }

    std::size_t calls = 0;

private:
    demo::ComputeDevice device_;
    std::optional<demo::ComputeKernel> kernel_;
};

/// Ground of slopes that some lamps graze.
std::vector<test::Triangle> hills(test::Random& random) {
    constexpr int side = 24;
    const auto height = [seed = random.next()](int x, int y) {
        return -3.0 + 0.4 * 0x1p-32 *
                          test::mixed(test::mixed(seed, static_cast<std::uint32_t>(x)),
                                      static_cast<std::uint32_t>(y));
    };
    const auto corner = [&](int x, int y) {
        return test::Vec(0.3 * x - 3.6, 0.3 * y - 3.6, height(x, y));
    };
    std::vector<test::Triangle> scene;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            scene.push_back(test::rounded(corner(x, y), corner(x + 1, y), corner(x + 1, y + 1)));
            scene.push_back(test::rounded(corner(x, y), corner(x + 1, y + 1), corner(x, y + 1)));
        }
    return scene;
}

/// Boxes on a floor or hills, under lamps of all kinds, somewhere.
struct World {
    World(std::uint64_t seed, int spheres, const glm::vec3& middle, bool has_hills = false) {
        test::Random random(seed);
        scene = has_hills ? hills(random) : test::boxes_on_floor(random, 5);
        for (test::Triangle& triangle : scene)
            for (test::Vec* corner : {&triangle.a, &triangle.b, &triangle.c})
                *corner = test::Vec(glm::vec3(*corner) + middle);
        for (int i = 0; i < spheres; ++i)
            lights.push_back(lightmesh::PointLight{
                .position = middle + glm::vec3(random.in_box({-4.0, -4.0, 0.5}, {4.0, 4.0, 4.5})),
                .radius = i % 3 == 0 ? 0.0f : 0.2f * static_cast<float>(i % 5)});
        lights.push_back(lightmesh::DirectionalLight{{0.3f, 0.5f, -1.0f}, 0.05f});
        lights.push_back(lightmesh::DirectionalLight{{0.0f, 0.0f, -1.0f}});
        lights.push_back(lightmesh::DirectionalLight{{0.8f, 0.6f, -0.2f}, 0.02f});
        lights.push_back(lightmesh::SpotLight{.position = middle + glm::vec3(1.0f, 0.0f, 4.0f),
                                              .axis = {0.1f, 0.2f, -1.0f},
                                              .cone = 0.7f,
                                              .radius = 0.2f});
        lights.push_back(lightmesh::RectLight{.position = middle + glm::vec3(0.0f, 0.0f, 4.0f),
                                              .half_u = {0.0f, 1.0f, 0.0f},
                                              .half_v = {0.6f, 0.0f, 0.1f}});
        lights.push_back(lightmesh::RectLight{.position = middle + glm::vec3(0.0f, 1.0f, 1.0f),
                                              .half_u = {0.0f, 0.3f, 0.4f},
                                              .half_v = {0.6f, 0.0f, 0.1f}});
        for (const test::SurfacePoint& p : test::surface_points(random, scene, 40))
            points.push_back({.position = p.position, .normal = p.normal});
    }

    std::vector<test::Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<lightmesh::SurfacePoint> points;
};

template <class Fill>
int fill_by_lists(const Cache& cache, std::span<const lightmesh::SurfacePoint> points, Fill&& fill) {
    for (int lists = 0;; ++lists) {
        REQUIRE(lists < 30);
        lightmesh::LampRayList list;
        cache.list_lamp_rays(points, list);
        if (list.is_empty())
            return lists;
        fill(list);
    }
}

}  // namespace

TEST_CASE("gpu shares: what shaders find of lamps is what the CPU finds by the same tracer to the bit") {
    test::WatchedDevice gpu;
    HashedShares shaders(gpu.device);
    std::size_t values = 0;
    const auto check = [&](const World& world, const lightmesh::CacheSettings& settings) {
        CAPTURE(settings.lamp_rays);
        CAPTURE(settings.shaft_rows);
        const Cache expected{test::HitTracer{&world.scene}, world.lights, settings};
        const int lists = fill_by_lists(expected, world.points,
                                        [&](const auto& list) { expected.fill(list, find_on_cpu); });
        const Cache cache{test::HitTracer{&world.scene}, world.lights, settings};
        CHECK(fill_by_lists(cache, world.points,
                            [&](const auto& list) { cache.fill_shares(list, shaders); }) == lists);
        CHECK(cache.snapshot() == expected.snapshot());
        CHECK(cache.statistics().listed_rays == expected.statistics().listed_rays);
        CHECK(cache.statistics().lamp_rays == 0);
        values += cache.statistics().rows;
    };
    const World world(911, 6, glm::vec3(0.0f));
    for (const bool shaft_rows : {false, true})
        for (const int lamp_rays : {1, 7, 16, 64, 256})
            check(world, {.spacing = 0.5f, .detail = 3, .lamp_rays = lamp_rays, .shaft_rows = shaft_rows});
    check(World(912, 70, glm::vec3(0.0f)), {.spacing = 0.5f, .detail = 2, .lamp_rays = 32});
    check(World(913, 6, {100'000.0f, -300'000.0f, 20'000.0f}), {.spacing = 0.5f, .detail = 2});
    const World slopes(916, 6, glm::vec3(0.0f), true);
    for (const bool shaft_rows : {false, true})
        check(slopes, {.spacing = 0.5f, .detail = 3, .shaft_rows = shaft_rows});
    check(World(914, 0, {1.0f, 2.0f, 3.0f}), {.spacing = 2.0f, .detail = 0});
    MESSAGE(values << " rows of eight, " << shaders.calls << " calls");
    CHECK(values > 10'000);
    CHECK(gpu.messages.empty());
}

TEST_CASE("gpu shares: shaders that throw leave nothing half and may go on") {
    const World world(915, 3, glm::vec3(0.0f));
    const lightmesh::CacheSettings settings{.spacing = 0.5f, .detail = 1};
    const Cache cache{test::HitTracer{&world.scene}, world.lights, settings};
    lightmesh::LampRayList list;
    cache.list_lamp_rays(world.points, list);
    CHECK_THROWS_AS(
        cache.fill_shares(list, [](auto, auto) { throw std::runtime_error("the device was lost"); }),
        std::runtime_error);
    CHECK(cache.statistics().rows == 0);
    CHECK(cache.statistics().listed_rays == 0);
    test::WatchedDevice gpu;
    HashedShares shaders(gpu.device);
    cache.fill_shares(list, shaders);
    CHECK(cache.statistics().rows > 0);
    const std::size_t calls = shaders.calls;
    cache.fill_shares(list, shaders);
    CHECK(shaders.calls == calls);
}

}  // namespace gpu_shares_test
