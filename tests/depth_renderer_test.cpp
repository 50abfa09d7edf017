// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/adapters/depth_renderer.hpp>
#include <lightmesh/shadows/shadow_map_views.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

namespace depth_renderer_test {

namespace {

using lightmesh::DepthView;

struct Fitting {
    void render_depth(const DepthView&, std::span<float>);
};
struct Const {
    void render_depth(const DepthView&, std::span<float>) const;
};
struct MoveOnly {
    std::unique_ptr<int> device;
    void render_depth(const DepthView&, std::span<float>);
};
struct Batch {
    void render_depth(const DepthView&, std::span<float>);
    void render_depth(std::span<const DepthView>, std::span<const std::span<float>>);
    lightmesh::Bounds bounds() const;
};
struct Lacking {};
struct Returning {
    bool render_depth(const DepthView&, std::span<float>);
};
struct Doubles {
    void render_depth(const DepthView&, std::span<double>);
};
struct ChangesView {
    void render_depth(DepthView&, std::span<float>);
};
struct Pinned {
    Pinned(Pinned&&) = delete;
    void render_depth(const DepthView&, std::span<float>);
};
struct UnfitBatch : Fitting {
    using Fitting::render_depth;
    void render_depth(std::span<const DepthView>, std::span<std::span<float>>);
};

static_assert(lightmesh::check_depth_renderer<Fitting>() && lightmesh::check_depth_renderer<Const>());
static_assert(lightmesh::check_depth_renderer<MoveOnly>() && lightmesh::check_depth_renderer<Batch>());
static_assert(lightmesh::DepthRenderer<Fitting> && lightmesh::DepthRenderer<Const> &&
              lightmesh::DepthRenderer<MoveOnly>);
static_assert(!lightmesh::DepthRenderer<Lacking> && !lightmesh::DepthRenderer<Returning> &&
              !lightmesh::DepthRenderer<Doubles> && !lightmesh::DepthRenderer<ChangesView> &&
              !lightmesh::DepthRenderer<Pinned> && !lightmesh::DepthRenderer<int>);
static_assert(lightmesh::BatchDepthRenderer<Batch> && !lightmesh::BatchDepthRenderer<Fitting> &&
              !lightmesh::BatchDepthRenderer<UnfitBatch> &&
              lightmesh::detail::MisspeltRenderBatch<UnfitBatch>);
static_assert(lightmesh::BoundedDepthRenderer<Batch> && !lightmesh::BoundedDepthRenderer<Fitting>);

lightmesh::detail::ShadowMapViews views_of(const lightmesh::Light& light, int resolution) {
    lightmesh::ShadowMapSettings settings;
    settings.resolution = resolution;
    settings.z_near = 0.01f;
    settings.scene_bounds = lightmesh::Bounds{{-4.0f, -5.0f, -6.0f}, {7.0f, 8.0f, 9.0f}};
    return {light, settings, "light"};
}

std::vector<DepthView> all_views_of(const lightmesh::Light& light, int resolution) {
    return views_of(light, resolution).all();
}

std::vector<lightmesh::Light> some_lights() {
    return {lightmesh::PointLight{{1.0f, -2.0f, 3.0f}},
            lightmesh::SpotLight{{-3.0f, 2.0f, 5.0f}, {1.0f, 0.5f, -2.0f}, 0.6f},
            lightmesh::DirectionalLight{{0.3f, -0.4f, -1.0f}},
            lightmesh::DirectionalLight{{0.0f, 0.0f, -2.0f}}};
}

}  // namespace

TEST_SUITE("depth view") {
    TEST_CASE("a point at a known distance on the ray of a texel is projected into its middle, with that "
              "distance") {
        for (const lightmesh::Light& light : some_lights()) {
            for (const DepthView& view : all_views_of(light, 9)) {
                for (const auto& [column, row] : {std::pair{0, 0}, {8, 0}, {0, 8}, {4, 4}, {2, 7}}) {
                    const auto ray = view.ray(column, row);
                    const double distance = 5.0;
                    const glm::dvec3 point = glm::dvec3(ray.origin) + distance * glm::dvec3(ray.direction);
                    const glm::dvec4 clip = glm::dmat4(view.clip_from_world) * glm::dvec4(point, 1.0);
                    CHECK(clip.w > 0.0);
                    CHECK((clip.x / clip.w + 1.0) * 4.5 == doctest::Approx(column + 0.5).epsilon(1e-5));
                    CHECK((clip.y / clip.w + 1.0) * 4.5 == doctest::Approx(row + 0.5).epsilon(1e-5));
                    const auto depth = static_cast<float>(clip.z / clip.w);
                    CHECK(view.distance(column, row, depth) == doctest::Approx(distance).epsilon(1e-5));
                }
            }
        }
    }

    TEST_CASE("depth is 1 at z_near and 0 at z_far") {
        for (const lightmesh::Light& light : some_lights()) {
            for (const DepthView& view : all_views_of(light, 3)) {
                const auto depth_at = [&](float z) {
                    const glm::dvec3 point =
                        glm::dvec3(view.eye) + static_cast<double>(z) * glm::dvec3(view.forward);
                    const glm::dvec4 clip = glm::dmat4(view.clip_from_world) * glm::dvec4(point, 1.0);
                    return clip.z / clip.w;
                };
                CHECK(depth_at(view.z_near) == doctest::Approx(1.0).epsilon(1e-4));
                CHECK(std::abs(depth_at(view.z_far)) < 1e-6);
                CHECK(std::isinf(view.distance(1, 1, 0.0f)));
            }
        }
    }

    TEST_CASE("row 0 is on top and column 0 at the left") {
        const auto views = views_of(lightmesh::SpotLight{{0.0f, 0.0f, 0.0f}, {0.0f, 2.0f, 0.0f}, 0.5f}, 4);
        const DepthView& view = views[0];  // along +y: z is up, x to the right
        CHECK(view.ray(0, 0).direction.z > 0.1f);
        CHECK(view.ray(0, 3).direction.z < -0.1f);
        CHECK(view.ray(0, 0).direction.x < -0.1f);
        CHECK(view.ray(3, 0).direction.x > 0.1f);
        const glm::vec4 above = view.clip_from_world * glm::vec4(0.0f, 1.0f, 0.2f, 1.0f);
        CHECK(above.y < 0.0f);
    }

    TEST_CASE("axes are perpendicular and right-handed, whatever the direction") {
        test::Random random(7);
        for (int i = 0; i < 200; ++i) {
            const glm::vec3 axis(random.direction());
            const auto views = views_of(lightmesh::SpotLight{{}, axis, 0.7f}, 8);
            const DepthView& view = views[0];
            CHECK(std::abs(glm::dot(view.right, view.forward)) < 1e-6f);
            CHECK(std::abs(glm::dot(view.down, view.forward)) < 1e-6f);
            CHECK(std::abs(glm::dot(view.down, view.right)) < 1e-6f);
            CHECK(glm::dot(glm::cross(view.right, view.down), view.forward) > 0.0f);
        }
    }

    TEST_CASE("the six faces of a point light are of 90 degrees and cover all directions") {
        const auto views = views_of(lightmesh::PointLight{}, 4);
        REQUIRE(views.size() == 6);
        for (const DepthView& view : views.all()) {
            CHECK(glm::length(view.right) == doctest::Approx(1.0));
            CHECK(glm::length(view.down) == doctest::Approx(1.0));
        }
        std::array<bool, 6> seen{};
        test::Random random(1);
        for (int i = 0; i < 1000; ++i) {
            const glm::vec3 way(random.direction());
            const auto place = views.locate(way);
            seen[static_cast<std::size_t>(place.view)] = true;
            const auto view = views[static_cast<std::size_t>(place.view)];
            const glm::vec3 back = view.forward + (place.column / 2.0f - 1.0f) * view.right +
                                   (place.row / 2.0f - 1.0f) * view.down;
            CHECK(glm::dot(glm::normalize(back), glm::normalize(way)) > 0.99999f);
        }
        for (const bool face : seen)
            CHECK(face);
    }

    TEST_CASE("the picture of a directional light holds the whole scene") {
        test::Random random(3);
        for (int i = 0; i < 100; ++i) {
            const auto views = views_of(lightmesh::DirectionalLight{glm::vec3(random.direction())}, 16);
            REQUIRE(views.size() == 1);
            for (int corner = 0; corner < 8; ++corner) {
                const glm::vec4 point((corner & 1) != 0 ? 7.0f : -4.0f, (corner & 2) != 0 ? 8.0f : -5.0f,
                                      (corner & 4) != 0 ? 9.0f : -6.0f, 1.0f);
                const glm::vec4 clip = views[0].clip_from_world * point;
                CHECK(clip.w == 1.0f);
                CHECK(std::abs(clip.x) < 1.0f);
                CHECK(std::abs(clip.y) < 1.0f);
                CHECK(clip.z > 0.0f);
                CHECK(clip.z < 1.0f);
            }
        }
    }
}

}  // namespace depth_renderer_test
