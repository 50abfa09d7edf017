// SPDX-License-Identifier: MIT
#include "../examples/adapters/embree_depth_renderer.hpp"
#include "../examples/adapters/vulkan_depth_renderer.hpp"
#include "../examples/scene/scene.hpp"
#include "embree_scene.hpp"
#include "random_scene.hpp"

#include <lightmesh/shadows/shadow_map.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace vulkan_test {

/// These tests need a Vulkan driver (Mesa's lavapipe will do) and fail without one.

namespace {

using lightmesh::DepthView;

static_assert(lightmesh::check_depth_renderer<demo::VulkanDepthRenderer>());
static_assert(lightmesh::check_depth_renderer<demo::EmbreeDepthRenderer>());
static_assert(lightmesh::BatchDepthRenderer<demo::VulkanDepthRenderer>);
static_assert(lightmesh::BoundedDepthRenderer<demo::VulkanDepthRenderer>);
static_assert(lightmesh::BoundedDepthRenderer<demo::EmbreeDepthRenderer>);

std::vector<DepthView> views_of(const lightmesh::Light& light, int resolution, float z_near,
                                const lightmesh::Bounds& bounds) {
    lightmesh::ShadowMapSettings settings;
    settings.resolution = resolution;
    settings.z_near = z_near;
    settings.scene_bounds = bounds;
    return lightmesh::detail::ShadowMapViews(light, settings, "light").all();
}

std::vector<float> render(auto& renderer, const DepthView& view) {
    std::vector<float> distance(static_cast<std::size_t>(view.resolution) *
                                static_cast<std::size_t>(view.resolution));
    renderer.render_depth(view, std::span<float>(distance));
    return distance;
}

/// Two triangles at x = distance, much larger than what a face along +x sees of them, in its upper half (z >=
/// 0) only.
struct Wall {
    std::vector<glm::vec3> positions;
    std::vector<std::uint32_t> indices{0, 1, 2, 2, 1, 3};
    explicit Wall(float x) {
        positions = {
            {x, -9.0f * x, 0.0f}, {x, 9.0f * x, 0.0f}, {x, -9.0f * x, 9.0f * x}, {x, 9.0f * x, 9.0f * x}};
    }
};

/// Whether a texel's ray passes within 1/64 of a texel of an edge: rays around it hit another triangle.
bool on_edge(const test::EmbreeScene& scene, const DepthView& view, int column, int row) {
    const auto primitive = [&](float x, float y) {
        const float side = 2.0f / static_cast<float>(view.resolution);
        const glm::vec3 step = side / 64.0f * (x * view.right + y * view.down);
        if (view.orthographic) {
            const auto ray = view.ray(column, row);
            return scene.trace(ray.origin + step, ray.direction, 1e30f).hit.primID;
        }
        return scene.trace(view.eye, view.offset(column, row) + step, 1e30f).hit.primID;
    };
    const unsigned middle = primitive(0.0f, 0.0f);
    for (int i = 0; i < 16; ++i) {
        const float angle = 6.2831853f * static_cast<float>(i) / 16.0f;
        if (primitive(std::cos(angle), std::sin(angle)) != middle)
            return true;
    }
    return false;
}

/// Renders by both; all texels must agree to 1e-4 but those on edges, of which there may be few.
void compare_with_embree(const demo::Scene& scene, const lightmesh::Light& light, int resolution) {
    const auto indices = demo::indices_of(scene);
    const test::EmbreeScene traced(scene.positions, indices);
    demo::EmbreeDepthRenderer embree(traced.scene());
    demo::VulkanDepthRenderer vulkan(scene.positions, indices);
    int edges = 0;
    int texels = 0;
    for (const DepthView& view : views_of(light, resolution, 1e-3f, vulkan.bounds())) {
        const auto expected = render(embree, view);
        const auto found = render(vulkan, view);
        for (std::size_t i = 0; i < found.size(); ++i) {
            ++texels;
            if (found[i] == expected[i] || std::abs(found[i] - expected[i]) <= 1e-4f * expected[i])
                continue;
            ++edges;
            const auto side = static_cast<std::size_t>(view.resolution);
            const int column = static_cast<int>(i % side);
            const int row = static_cast<int>(i / side);
            CAPTURE(column);
            CAPTURE(row);
            CAPTURE(expected[i]);
            CAPTURE(found[i]);
            CHECK(on_edge(traced, view, column, row));
        }
    }
    CHECK(edges < texels / 2000);
}

}  // namespace

TEST_SUITE("Vulkan depth renderer") {
    TEST_CASE("there is a device") {
        const auto names = demo::vulkan_device_names();
        REQUIRE(!names.empty());
        const Wall wall(2.0f);
        const demo::VulkanDepthRenderer renderer(wall.positions, wall.indices);
        MESSAGE("rendered by ", renderer.device_name());
        CHECK(std::ranges::find(names, renderer.device_name()) != names.end());
    }

    TEST_CASE("a wall at a known distance: every texel, row 0 on top, infinity for nothing, resolution 1, "
              "16, 4096") {
        for (const float x : {1e-3f, 2.0f, 5000.0f}) {
            const Wall wall(x);
            demo::VulkanDepthRenderer renderer(wall.positions, wall.indices);
            for (const int resolution : {16, 17, 4096}) {
                const auto view =
                    views_of(lightmesh::PointLight{}, resolution, 1e-4f, renderer.bounds()).front();
                const auto distance = render(renderer, view);
                int wrong = 0;
                for (int row = 0; row < resolution; ++row) {
                    for (int column = 0; column < resolution; ++column) {
                        const double y = (2.0 * column + 1.0) / resolution - 1.0;
                        const double z = 1.0 - (2.0 * row + 1.0) / resolution;
                        const double expected = static_cast<double>(x) * std::sqrt(1.0 + y * y + z * z);
                        const float found = distance[static_cast<std::size_t>(row * resolution + column)];
                        if (z < 0.0)
                            wrong += std::isinf(found) ? 0 : 1;
                        if (z > 0.0)
                            wrong +=
                                std::abs(static_cast<double>(found) - expected) < 1e-5 * expected ? 0 : 1;
                    }
                }
                CHECK(wrong == 0);
            }
        }
        const Wall wall(2.0f);
        demo::VulkanDepthRenderer renderer(wall.positions, wall.indices);
        const auto up =
            views_of(lightmesh::PointLight{{0.0f, 0.0f, 1.0f}}, 1, 1e-4f, renderer.bounds()).front();
        CHECK(render(renderer, up).front() == doctest::Approx(2.0));
    }

    TEST_CASE("the same as Embree but on edges: point, spot and directional lights in the built-in scenes") {
        const auto park = demo::make_park();
        const auto spheres = demo::make_spheres();
        compare_with_embree(park, park.lights.front().shape, 256);
        compare_with_embree(spheres, spheres.lights.front().shape, 256);
        compare_with_embree(park, lightmesh::DirectionalLight{{0.4f, 0.3f, -1.0f}}, 512);
        const glm::vec3 above = spheres.camera.target + glm::vec3(0.3f, 0.2f, 20.0f);
        compare_with_embree(spheres, lightmesh::SpotLight{above, {0.1f, 0.1f, -1.0f}, 0.5f}, 512);
    }

    TEST_CASE("far from the origin") {
        auto scene = demo::make_spheres();
        for (glm::vec3& position : scene.positions)
            position += glm::vec3(10000.0f, -7000.0f, 3000.0f);
        const glm::vec3 light = scene.camera.target + glm::vec3(10000.3f, -7000.2f, 3009.0f);
        compare_with_embree(scene, lightmesh::PointLight{light}, 128);
    }

    TEST_CASE("clean under the validation layers, and many views at once give what each gives alone") {
        const auto scene = demo::make_spheres();
        std::vector<std::string> messages;
        demo::VulkanDepthOptions options;
        options.validate = true;
        options.on_message = [&](const std::string& message) {
            messages.push_back(message);
        };
        {
            demo::VulkanDepthRenderer renderer(scene.positions, demo::indices_of(scene), options);
            auto copy = renderer;
            for (const int resolution : {64, 16, 128}) {
                const auto views = views_of(scene.lights.front().shape, resolution, 1e-3f, renderer.bounds());
                const auto texels =
                    static_cast<std::size_t>(resolution) * static_cast<std::size_t>(resolution);
                std::vector<std::vector<float>> together(views.size(), std::vector<float>(texels));
                const std::vector<std::span<float>> spans(together.begin(), together.end());
                renderer.render_depth(std::span<const DepthView>(views),
                                      std::span<const std::span<float>>(spans));
                for (std::size_t i = 0; i < views.size(); ++i)
                    CHECK(render(copy, views[i]) == together[i]);
            }
        }
        for (const std::string& message : messages)
            FAIL_CHECK(message);
    }

    TEST_CASE("a shadow map of it agrees with rays") {
        const auto scene = demo::make_spheres();
        const auto indices = demo::indices_of(scene);
        const test::EmbreeScene traced(scene.positions, indices);
        const demo::VulkanDepthRenderer renderer(scene.positions, indices);
        const auto box = renderer.bounds();
        const glm::vec3 position =
            0.5f * (box.low + box.high) + glm::vec3(0.1f, 0.2f, 0.4f * (box.high.z - box.low.z));
        const lightmesh::ShadowMap map(renderer, lightmesh::PointLight{position},
                                       lightmesh::ShadowMapSettings{});
        test::Random random(3);
        int wrong = 0;
        for (int i = 0; i < 20000; ++i) {
            const glm::vec3 point(random.in_box(test::Vec(box.low), test::Vec(box.high)));
            wrong += map.visible(point) == traced.blocked(position, point) ? 1 : 0;
        }
        CHECK(wrong < 60);
    }

    TEST_CASE("a device is chosen by its index or by a part of its name") {
        const Wall wall(1.0f);
        const auto names = demo::vulkan_device_names();
        demo::VulkanDepthOptions options;
        options.device = "0";
        CHECK(demo::VulkanDepthRenderer(wall.positions, wall.indices, options).device_name() == names[0]);
        options.device = names.back().substr(0, 6);
        CHECK_NOTHROW(demo::VulkanDepthRenderer(wall.positions, wall.indices, options));
        options.device = "no such device";
        const std::string expected = "Vulkan: no device \"no such device\"; there are:\n  0: " + names[0];
        try {
            demo::VulkanDepthRenderer(wall.positions, wall.indices, options);
            FAIL("not thrown");
        } catch (const std::runtime_error& error) {
            CHECK(std::string(error.what()).starts_with(expected));
        }
    }

    TEST_CASE("without a driver: one error that says what to install") {
        REQUIRE(setenv("VK_ICD_FILENAMES", "/nowhere/none.json", 1) == 0);
        REQUIRE(setenv("VK_DRIVER_FILES", "/nowhere/none.json", 1) == 0);
        const Wall wall(1.0f);
        std::string message;
        try {
            demo::VulkanDepthRenderer(wall.positions, wall.indices);
        } catch (const std::runtime_error& error) {
            message = error.what();
        }
        unsetenv("VK_ICD_FILENAMES");
        unsetenv("VK_DRIVER_FILES");
        CHECK(message.starts_with("Vulkan: no d"));
        CHECK(message.find("apt install libvulkan1 mesa-vulkan-drivers") != std::string::npos);
    }

    TEST_CASE("triangles that make no sense, pictures that are too large") {
        Wall wall(1.0f);
        const std::vector<std::uint32_t> none;
        CHECK_THROWS_AS(demo::VulkanDepthRenderer(wall.positions, none), std::invalid_argument);
        const std::vector<std::uint32_t> two{0, 1};
        CHECK_THROWS_AS(demo::VulkanDepthRenderer(wall.positions, two), std::invalid_argument);
        const std::vector<std::uint32_t> too_large{0, 1, 4};
        CHECK_THROWS_AS(demo::VulkanDepthRenderer(wall.positions, too_large), std::invalid_argument);

        demo::VulkanDepthRenderer renderer(wall.positions, wall.indices);
        auto view = views_of(lightmesh::PointLight{}, 1, 1e-4f, renderer.bounds()).front();
        view.resolution = renderer.largest_resolution() + 1;
        CHECK_THROWS_AS(renderer.render_depth(view, std::span<float>()), std::runtime_error);

        wall.positions[1].y = std::numeric_limits<float>::quiet_NaN();
        CHECK_THROWS_AS(demo::VulkanDepthRenderer(wall.positions, wall.indices), std::invalid_argument);
    }
}

}  // namespace vulkan_test
