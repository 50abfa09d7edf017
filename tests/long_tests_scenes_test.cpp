// SPDX-License-Identifier: MIT
#include "../examples/adapters/embree_depth_renderer.hpp"
#include "../examples/adapters/vulkan_depth_renderer.hpp"
#include "../examples/render/embree_scene.hpp"
#include "../examples/render/scene_occluders.hpp"
#include "../examples/scene/scene.hpp"
#include "embree_scene.hpp"
#include "plain.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <cstddef>
#include <memory>
#include <span>
#include <variant>
#include <vector>

// How near light meshes by shadow maps and by shadow volumes come to the one by rays, in the built-in scenes,
// at the points that their cameras see. These tests need a Vulkan driver.

namespace long_tests_scenes_test {

namespace {

struct Sample {
    demo::Scene scene;
    demo::EmbreeScene traced{scene};
    std::vector<lightmesh::Light> lights;
    std::vector<glm::vec3> points;
    std::vector<glm::vec3> normals;
    lightmesh::Settings settings;

    /// Every `light_step`th light, and a picture of so many columns.
    Sample(demo::Scene made, std::size_t light_step, int columns) : scene(std::move(made)) {
        const auto all = demo::shapes_of_lights(scene);
        for (std::size_t i = 0; i < all.size(); i += light_step)
            lights.push_back(all[i]);
        settings.radius = scene.radius;
        settings.quality = scene.quality;
        settings.short_test = lightmesh::ShortTest::exact;
        see_points(columns, columns * 3 / 4);
    }

private:
    void see_points(int columns, int rows) {
        const demo::Camera& camera = scene.camera;
        const glm::vec3 forward = glm::normalize(camera.target - camera.eye);
        const glm::vec3 right = glm::normalize(glm::cross(forward, camera.up));
        const glm::vec3 up = glm::cross(right, forward);
        const float half = std::tan(0.5f * camera.vertical_field_of_view);
        const float side = 2.0f * half / static_cast<float>(rows);
        for (int row = 0; row < rows; ++row) {
            for (int column = 0; column < columns; ++column) {
                const float x =
                    side * (static_cast<float>(column) + 0.5f - 0.5f * static_cast<float>(columns));
                const float y = side * (static_cast<float>(row) + 0.5f - 0.5f * static_cast<float>(rows));
                const auto hit = traced.trace(camera.eye, glm::normalize(forward + x * right - y * up));
                if (!hit)
                    continue;
                points.push_back(hit->position);
                normals.push_back(hit->geometric_normal);
            }
        }
    }
};

template <class Mesh>
std::vector<float> values(const Mesh& mesh, const Sample& sample) {
    std::vector<float> all(sample.points.size() * mesh.light_count());
    mesh.visibility(sample.points, sample.normals, std::span<float>(all));
    return all;
}

/// The light mesh by rays, and how others differ from it.
class Reference {
public:
    explicit Reference(const Sample& sample) : sample_(sample) {
        const lightmesh::LightMesh mesh{sample.traced.intersector(), sample.lights, sample.settings};
        values_ = values(mesh, sample);
        long_rays_ = static_cast<double>(mesh.statistics().long_rays);
    }

    struct Difference {
        double mean;  ///< absolute, of S, over all points and lights
        double rays;  ///< share of the long rays
    };

    template <class Source>
    Difference difference(const Source& source, int map_size = 1024, bool refine = false) const {
        lightmesh::Settings settings = sample_.settings;
        settings.shadow_map_size = map_size;
        settings.refine_shadow_maps = refine;
        const lightmesh::LightMesh mesh{sample_.traced.intersector(), source, sample_.lights, settings};
        const std::vector<float> found = values(mesh, sample_);
        double sum = 0.0;
        for (std::size_t i = 0; i < found.size(); ++i)
            sum += static_cast<double>(std::abs(found[i] - values_[i]));
        return {sum / static_cast<double>(found.size()),
                static_cast<double>(mesh.statistics().long_rays) / long_rays_};
    }

private:
    const Sample& sample_;
    std::vector<float> values_;
    double long_rays_;
};

struct Bars {
    int map_size;
    double mean;          ///< of LMM+ATK
    double refined_mean;  ///< with rays where a map cannot tell
    double refined_rays;
};

void check_maps(const Reference& reference, const auto& renderer, const Bars& bars) {
    CAPTURE(bars.map_size);
    const auto plain = reference.difference(renderer, bars.map_size);
    CHECK(plain.mean < bars.mean);
    CHECK(plain.rays == 0.0);
    const auto refined = reference.difference(renderer, bars.map_size, true);
    CHECK(refined.mean < bars.refined_mean);
    CHECK(refined.rays < bars.refined_rays);
    MESSAGE("maps of ", bars.map_size, ": mean difference ", 100.0 * plain.mean, " %, refined ",
            100.0 * refined.mean, " % with ", 100.0 * refined.rays, " % of the long rays");
}

std::vector<test::Triangle> triangles_of(const demo::Scene& scene) {
    std::vector<test::Triangle> triangles;
    const demo::SceneOccluders source(scene);
    for (std::size_t i = 0; i < source.triangle_count(); ++i) {
        const auto corners = source.triangle(i);
        triangles.push_back({test::Vec(corners[0]), test::Vec(corners[1]), test::Vec(corners[2])});
    }
    return triangles;
}

/// Long tests of the light points above the sample's points, by volumes and by rays.
void check_volumes(const Sample& sample) {
    const auto source =
        std::make_shared<const lightmesh::OccluderTriangles>(demo::SceneOccluders(sample.scene));
    const auto triangles = triangles_of(sample.scene);
    const lightmesh::Grid grid(sample.settings);
    const lightmesh::detail::LightTable table(sample.lights, grid);
    const auto step = static_cast<float>(grid.step());
    int differ = 0;
    for (std::size_t i = 0; i < sample.lights.size(); ++i) {
        const lightmesh::ShadowVolumes volumes(source, sample.lights[i],
                                               lightmesh::detail::light_clearance(sample.lights[i], step));
        for (std::size_t k = 0; k < sample.points.size(); ++k) {
            const auto above =
                sample.points[k] + step * (1.0f + static_cast<float>(k % 3)) * sample.normals[k];
            const lightmesh::Segment segment = table.long_segment(i, above);
            if (volumes.visible(above) != sample.traced.intersector().occluded(segment))
                continue;
            // Embree computes in float: 1e-5 of the way, across it.
            const double band = 1e-5 * static_cast<double>(sample.traced.diagonal());
            CHECK(test::sees(test::Vec(segment.origin), test::Vec(segment.target), triangles, band) ==
                  test::Answer::unsure);
            ++differ;
        }
    }
    CHECK(differ * 10000.0 < static_cast<double>(sample.lights.size() * sample.points.size()));
}

demo::VulkanDepthRenderer vulkan_renderer(const demo::Scene& scene) {
    return {scene.positions, demo::indices_of(scene)};
}

}  // namespace

TEST_SUITE("long tests in the built-in scenes") {
    TEST_CASE("spheres by shadow maps") {
        const Sample sample(demo::make_spheres(), 1, 48);
        const Reference reference(sample);
        const Bars fine{1024, 0.005, 0.0005, 0.05};
        const Bars coarse{512, 0.01, 0.0005, 0.05};
        const demo::EmbreeDepthRenderer embree(sample.traced.handle());
        check_maps(reference, embree, fine);
        check_maps(reference, embree, coarse);
        const auto vulkan = vulkan_renderer(sample.scene);
        check_maps(reference, vulkan, fine);
        check_maps(reference, vulkan, coarse);
    }

    TEST_CASE("park by shadow maps, whose leaves need twice as many texels to a side") {
        const Sample sample(demo::make_park(), 16, 48);
        const Reference reference(sample);
        const demo::EmbreeDepthRenderer embree(sample.traced.handle());
        check_maps(reference, embree, {512, 0.02, 0.005, 0.2});
        check_maps(reference, embree, {1024, 0.01, 0.002, 0.1});
        const auto vulkan = vulkan_renderer(sample.scene);
        check_maps(reference, vulkan, {1024, 0.01, 0.002, 0.1});
        check_maps(reference, vulkan, {2048, 0.005, 0.0005, 0.05});
    }

    TEST_CASE("by shadow volumes, the same but within the band") {
        for (const bool is_park : {false, true}) {
            const Sample sample(is_park ? demo::make_park() : demo::make_spheres(), is_park ? 16 : 1, 48);
            check_volumes(sample);
            const auto found = Reference(sample).difference(demo::SceneOccluders(sample.scene));
            CHECK(found.mean < 1e-5);
            CHECK(found.rays == 0.0);
        }
    }
}

}  // namespace long_tests_scenes_test
