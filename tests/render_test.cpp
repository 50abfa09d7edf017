// SPDX-License-Identifier: MIT

// The renderer: pictures of the built-in scenes against stored ones, and what a picture must not depend on.

#include "image/image.hpp"
#include "render/embree_scene.hpp"
#include "render/illumination.hpp"
#include "render/renderer.hpp"
#include "render/shading.hpp"
#include "render/visibility.hpp"
#include "scene/scene.hpp"

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace render_test {

namespace {

using demo::Image;

/// A scene with its BVH.
struct Stage {
    explicit Stage(const std::string& name) : scene(demo::load_scene(name)), embree(scene) {}

    demo::Scene scene;
    demo::EmbreeScene embree;
};

demo::RenderOptions small_picture() {
    demo::RenderOptions options;
    options.width = 160;
    options.height = 120;
    return options;
}

std::unique_ptr<demo::Visibility> visibility_in(const Stage& stage, const std::string& algorithm) {
    demo::VisibilityOptions options = demo::options_of(stage.scene);
    options.settings.short_test = lightmesh::ShortTest::exact;
    options.settings.shadow_map_size = 256;
    options.settings.footprint_scale = 0.0f;  // The pixels of so small pictures are as wide as steps.
    options.depth = demo::DepthSource::embree;
    return demo::make_visibility(algorithm, stage.embree, options);
}

Image picture_of(const Stage& stage, const std::string& algorithm, const demo::RenderOptions& options) {
    demo::RenderStatistics statistics;
    return demo::render(stage.embree, *visibility_in(stage, algorithm), options, statistics);
}

/// The share of pixels with a channel that differs by more than 0.05.
double share_of_other_pixels(const Image& a, const Image& b) {
    std::size_t other = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        const glm::vec3 difference = glm::abs(a.pixels[i] - b.pixels[i]);
        if (std::max({difference.x, difference.y, difference.z}) > 0.05f)
            ++other;
    }
    return static_cast<double>(other) / static_cast<double>(a.pixels.size());
}

/// All light, and what it was told of pixels.
class SeenFootprints : public demo::Visibility {
public:
    struct Seen {
        glm::vec3 position;
        float footprint;
    };

    void find(const demo::SurfacePoints& points, std::span<float> lit, demo::VisibilityCost&) const override {
        std::ranges::fill(lit, 1.0f);
        const std::scoped_lock lock(one_at_a_time_);
        for (const lightmesh::SurfacePoint& point : points.points)
            all_.push_back({point.position, point.footprint});
    }
    void update(const demo::EmbreeScene&, const demo::SceneChange&) override {}

    const std::vector<Seen>& all() const { return all_; }

private:
    mutable std::mutex one_at_a_time_;
    mutable std::vector<Seen> all_;
};

/// Whether it shows penumbrae of lamps, or a cache.
bool is_of_lamps(const std::string& algorithm) {
    return algorithm == "area" || algorithm == "cache" || algorithm == "blur-cache";
}

Image as_stored(Image image) {
    for (glm::vec3& pixel : image.pixels)
        for (int c = 0; c < 3; ++c)
            pixel[c] = demo::from_srgb(std::round(demo::to_srgb(pixel[c]) * 255.0f) / 255.0f);
    return image;
}

}  // namespace

// With LIGHTMESH_RENEW_PICTURES set in the environment, the pictures are written instead. Look at them then.
TEST_CASE("pictures of the built-in scenes are the stored ones") {
    for (const std::string scene : {"park", "spheres", "rooms"}) {
        const Stage stage(scene);
        for (const std::string algorithm :
             {"whitted", "lmm", "linked", "express", "linked+map", "area", "cache", "blur-cache"}) {
            // In foliage a cache is slow, and as slow is what its picture would be compared with.
            if (scene == "park" && is_of_lamps(algorithm))
                continue;
            CAPTURE(scene);
            CAPTURE(algorithm);
            const std::filesystem::path file =
                std::filesystem::path(LIGHTMESH_PICTURES) / (scene + "-" + algorithm + ".png");
            const Image picture = as_stored(picture_of(stage, algorithm, small_picture()));
            if (std::getenv("LIGHTMESH_RENEW_PICTURES") != nullptr) {
                demo::write_png(picture, file);
                continue;
            }
            const Image stored = demo::read_png(file);
            REQUIRE(stored.width == picture.width);
            REQUIRE(stored.height == picture.height);
            CHECK(demo::mean_absolute_difference(picture, stored) < 0.001);
            CHECK(share_of_other_pixels(picture, stored) < 0.004);
        }
    }
}

TEST_CASE("the stored pictures tell the algorithms apart") {
    for (const std::string scene : {"park", "spheres", "rooms"}) {
        const auto stored = [&](const std::string& algorithm) {
            return demo::read_png(std::filesystem::path(LIGHTMESH_PICTURES) /
                                  (scene + "-" + algorithm + ".png"));
        };
        const Image lmm = stored("lmm");
        CHECK(demo::mean_absolute_difference(stored("whitted"), lmm) > 0.004);
        CHECK(demo::mean_absolute_difference(stored("express"), lmm) > 0.002);
        CHECK(demo::mean_absolute_difference(stored("linked"), lmm) <
              0.7 * demo::mean_absolute_difference(stored("express"), lmm));
    }
}

TEST_CASE("a light mesh is told how wide pixels are") {
    const Stage stage("street");
    demo::VisibilityOptions options;
    options.settings.radius = 2.0f;
    demo::RenderOptions small;
    small.width = 64;
    small.height = 48;
    for (const float scale : {0.0f, 1.0f}) {
        options.settings.footprint_scale = scale;
        const auto visibility = demo::make_visibility("express", stage.embree, options);
        demo::RenderStatistics statistics;
        demo::render(stage.embree, *visibility, small, statistics);
        const std::optional<lightmesh::MeshStatistics> held = visibility->mesh();
        REQUIRE(held.has_value());
        CHECK((held->light_points_of_level[1] > 0) == (scale > 0.0f));
        CHECK(held->light_points_of_level[0] > 0);
    }
}

TEST_CASE("pixels are as wide in mirrors and behind glass as the whole path makes them") {
    // A pane across the view at a distance of 1, a mirror or clear; the floor of its side at 3 from there.
    for (const bool is_mirror : {true, false}) {
        CAPTURE(is_mirror);
        demo::Scene scene;
        scene.materials.resize(2);
        scene.materials[1].k_s = is_mirror ? 0.5f : 0.0f;
        scene.materials[1].k_t = is_mirror ? 0.0f : 0.5f;
        scene.materials[1].refraction_index = 1.0f;
        const float wall = is_mirror ? -2.0f : 4.0f;
        scene.positions = {{-9, 1, -9},    {9, 1, -9},    {9, 1, 9},    {-9, 1, 9},
                           {-9, wall, -9}, {9, wall, -9}, {9, wall, 9}, {-9, wall, 9}};
        scene.normals.assign(8, {0.0f, -1.0f, 0.0f});
        scene.triangles = {{{0, 1, 2}, 1}, {{0, 2, 3}, 1}, {{4, 5, 6}, 0}, {{4, 6, 7}, 0}};
        scene.lights.push_back({.shape = lightmesh::PointLight{.position = {0.0f, 0.0f, 0.5f}}});
        scene.camera = {
            .eye = {0.0f, 0.0f, 0.0f}, .target = {0.0f, 1.0f, 0.0f}, .vertical_field_of_view = 0.5f};
        const demo::EmbreeScene traced(scene);
        demo::RenderOptions options;
        options.width = 32;
        options.height = 24;
        options.depth_limit = 1;
        const SeenFootprints seen;
        demo::RenderStatistics statistics;
        demo::render(traced, seen, options, statistics);
        const float angle = 2.0f * std::tan(0.25f) / 24.0f;
        std::size_t on_pane = 0;
        std::size_t on_wall = 0;
        for (const auto& [position, footprint] : seen.all()) {
            // Seen from the eye, or from its mirror image.
            const bool is_on_pane = std::abs(position.y - 1.0f) < 0.01f;
            const glm::vec3 eye{0.0f, is_mirror && !is_on_pane ? 2.0f : 0.0f, 0.0f};
            CHECK(footprint ==
                  doctest::Approx(static_cast<double>(angle * glm::distance(eye, position))).epsilon(1e-3));
            ++(is_on_pane ? on_pane : on_wall);
        }
        CHECK(on_pane == 32 * 24);
        CHECK(on_wall == 32 * 24);
    }
}

TEST_CASE("a picture is the same to the last bit for any number of threads") {
    const Stage stage("spheres");
    for (const std::string algorithm :
         {"cache", "blur-cache", "whitted", "area", "lmm", "linked", "express+map", "shadow-volume"}) {
        CAPTURE(algorithm);
        demo::RenderOptions options = small_picture();
        options.width = 80;
        options.height = 60;
        options.samples = 2;
        options.threads = 1;
        const Image alone = picture_of(stage, algorithm, options);
        for (const int threads : {2, 4}) {
            options.threads = threads;
            CHECK(picture_of(stage, algorithm, options).pixels == alone.pixels);
        }
    }
}

TEST_CASE("a picture that is cancelled is told to be, and has what was done by then") {
    const Stage stage("spheres");
    std::atomic<bool> cancel{false};
    demo::RenderOptions options = small_picture();
    options.threads = 1;
    demo::RenderStatistics statistics;
    const auto visibility = visibility_in(stage, "whitted");
    const Image picture = demo::render(
        stage.embree, *visibility, options, statistics,
        [&](double done) {
            if (done > 0.3)
                cancel = true;
        },
        &cancel);
    CHECK_FALSE(statistics.finished);
    const auto black = static_cast<double>(std::ranges::count(picture.pixels, glm::vec3(0.0f)));
    const double share = black / static_cast<double>(picture.pixels.size());
    CHECK(share > 0.1);
    CHECK(share < 0.8);
}

TEST_CASE("mirrors and glass end at the depth limit") {
    const Stage stage("spheres");
    std::uint64_t before = 0;
    for (const int limit : {0, 1, 2, 5}) {
        demo::RenderOptions options = small_picture();
        options.depth_limit = limit;
        demo::RenderStatistics statistics;
        demo::render(stage.embree, *visibility_in(stage, "whitted"), options, statistics);
        CHECK(statistics.primary_rays == 160 * 120);
        if (limit == 0)
            CHECK(statistics.secondary_rays == 0);
        else
            CHECK(statistics.secondary_rays > before);
        before = statistics.secondary_rays;
    }
}

TEST_CASE("options of a picture are checked") {
    const Stage stage("spheres");
    const auto visibility = visibility_in(stage, "whitted");
    demo::RenderStatistics statistics;
    const auto refuses = [&](auto change) {
        demo::RenderOptions options = small_picture();
        change(options);
        CHECK_THROWS_AS(demo::render(stage.embree, *visibility, options, statistics), std::invalid_argument);
    };
    refuses([](demo::RenderOptions& o) { o.width = 0; });
    refuses([](demo::RenderOptions& o) { o.height = -1; });
    refuses([](demo::RenderOptions& o) { o.samples = 0; });
    refuses([](demo::RenderOptions& o) { o.depth_limit = -1; });
    refuses([](demo::RenderOptions& o) { o.threads = -1; });
    CHECK_THROWS_WITH_AS(visibility_in(stage, "radiosity"), doctest::Contains("radiosity"),
                         std::runtime_error);
}

TEST_CASE("shading is ambient light, Lambert and Blinn-Phong, times visibility") {
    demo::Scene scene;
    scene.ambient = glm::vec3(0.1f);
    demo::Material material;
    material.diffuse = glm::vec3(0.5f, 0.25f, 0.0f);
    scene.materials = {material};
    // Straight above at a distance of 2, of intensity 8: an irradiance of 2.
    scene.lights = {{lightmesh::PointLight{{0, 0, 2}}, glm::vec3(8.0f)}};
    demo::Hit hit{};
    hit.position = glm::vec3(0.0f);
    hit.geometric_normal = hit.shading_normal = glm::vec3(0, 0, 1);
    const glm::vec3 down(0, 0, -1);
    for (const float lit : {0.0f, 0.5f, 1.0f}) {
        const glm::vec3 expected = (0.1f + 2.0f * lit) * scene.materials[0].diffuse;
        CHECK(glm::distance(demo::shade(scene, demo::LightTable(scene.lights), hit, down, std::span(&lit, 1)),
                            expected) < 1e-6f);
    }
    // The highlight is full where the light is mirrored to the eye, and falls with the angle to halfway.
    scene.materials[0].specular = glm::vec3(0.3f);
    scene.materials[0].shininess = 16.0f;
    const float lit = 1.0f;
    const glm::vec3 matt = 2.1f * scene.materials[0].diffuse;
    const glm::vec3 mirrored =
        demo::shade(scene, demo::LightTable(scene.lights), hit, down, std::span(&lit, 1)) - matt;
    CHECK(mirrored.x == doctest::Approx(0.6));
    const glm::vec3 aslant = glm::normalize(glm::vec3(1, 0, -1));
    const glm::vec3 beside =
        demo::shade(scene, demo::LightTable(scene.lights), hit, aslant, std::span(&lit, 1)) - matt;
    const double halfway = std::cos(std::numbers::pi / 8.0);
    CHECK(beside.x == doctest::Approx(0.6 * std::pow(halfway, 16.0)));
    // From below nothing arrives.
    hit.shading_normal = -hit.shading_normal;
    CHECK(demo::shade(scene, demo::LightTable(scene.lights), hit, -down, std::span(&lit, 1)) ==
          0.1f * scene.materials[0].diffuse);
}

/// The share of a light that a surface reflects: Lambert's with Blinn's highlight, or by facets as GGX
/// spreads them (Walter and others, 2007) above Burley's diffuse lobe (2012), times pi.
glm::dvec3 plain_reflection(const demo::Material& material, const glm::dvec3& normal,
                            const glm::dvec3& to_eye, const glm::dvec3& to_light) {
    const double to_n = glm::dot(normal, to_light);
    const double from_n = (std::max)(glm::dot(normal, to_eye), 1e-4);
    const glm::dvec3 halfway = glm::normalize(to_light + to_eye);
    const double half_n = (std::max)(glm::dot(normal, halfway), 0.0);
    const double half_to = (std::max)(glm::dot(to_light, halfway), 0.0);
    const glm::dvec3 diffuse(material.diffuse);
    const glm::dvec3 specular(material.specular);
    if (material.highlight != demo::Highlight::ggx)
        return to_n * diffuse + std::pow(half_n, static_cast<double>(material.shininess)) * specular;
    const auto roughness = static_cast<double>(material.roughness);
    const double alpha = (std::max)(roughness * roughness, 0.01);
    const auto masked = [&](double cosine) {
        return std::sqrt(alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine);
    };
    const double facets = std::pow(alpha / (half_n * half_n * (alpha * alpha - 1.0) + 1.0), 2.0);
    const double masking = 0.5 / (to_n * masked(from_n) + from_n * masked(to_n));
    const glm::dvec3 fresnel =
        specular + (glm::clamp(50.0 * specular, 0.0, 1.0) - specular) * std::pow(1.0 - half_to, 5.0);
    const double edge = 2.0 * half_to * half_to * roughness - 0.5;
    const double matt = (1.0 + edge * std::pow(1.0 - to_n, 5.0)) * (1.0 + edge * std::pow(1.0 - from_n, 5.0));
    return to_n * (matt * diffuse + facets * masking * fresnel);
}

TEST_CASE("shading by many lights is the sum over them, of whichever kind each is") {
    demo::Scene scene;
    demo::Material material;
    material.diffuse = glm::vec3(0.5f, 0.25f, 1.0f);
    SUBCASE("matt") {}
    SUBCASE("with Blinn's highlight") {
        material.specular = glm::vec3(0.3f, 0.2f, 0.1f);
        material.shininess = 16.0f;
    }
    SUBCASE("rough") {
        material.highlight = demo::Highlight::ggx;
        material.specular = glm::vec3(0.04f, 0.3f, 0.0f);
        material.roughness = 0.4f;
    }
    scene.materials = {material};
    demo::Hit hit{};
    hit.position = glm::vec3(0.2f, -0.1f, 0.3f);
    hit.geometric_normal = hit.shading_normal = glm::normalize(glm::vec3(0.2f, 0.1f, 1.0f));
    const glm::vec3 down = glm::normalize(glm::vec3(0.3f, 0.2f, -1.0f));
    for (int i = 0; i < 53; ++i) {
        const auto at = [i](float speed) {
            return 3.0f * std::sin(speed * static_cast<float>(i + 1));
        };
        const glm::vec3 place(at(1.0f), at(2.3f), at(0.7f));
        demo::SceneLight light{lightmesh::PointLight{.position = place, .radius = 0.2f}, {3.0f, 2.0f, 1.0f}};
        if (i % 3 == 1)
            std::get<lightmesh::PointLight>(light.shape).range = 3.0f;
        if (i % 11 == 5)
            light.facing = glm::vec3(0, 0, 1);
        if (i == 17)
            std::get<lightmesh::PointLight>(light.shape).position = hit.position;
        if (i % 7 == 2)
            light.shape = lightmesh::SpotLight{.position = place, .axis = -place, .cone = 0.9f};
        if (i % 7 == 4)
            light.shape = lightmesh::DirectionalLight{.direction = -place};
        if (i % 7 == 6)
            light.shape = lightmesh::RectLight{.position = place};
        light.fall_off = i % 2 == 0 ? demo::FallOff::points : demo::FallOff::lamps;
        scene.lights.push_back(light);
    }
    for (const std::size_t count : {scene.lights.size(), std::size_t{9}, std::size_t{8}, std::size_t{1}}) {
        CAPTURE(count);
        scene.lights.resize(count);
        glm::dvec3 expected = scene.ambient * material.diffuse;
        std::vector<float> lit;
        for (std::size_t l = 0; l < count; ++l) {
            lit.push_back(static_cast<float>(l % 5) / 4.0f);
            const demo::Illumination light = demo::illuminate(scene.lights[l], hit.position);
            if (glm::dot(hit.shading_normal, light.to_light) > 0.0f)
                expected += static_cast<double>(lit[l]) * glm::dvec3(light.irradiance) *
                            plain_reflection(material, glm::dvec3(hit.shading_normal), -glm::dvec3(down),
                                             glm::dvec3(light.to_light));
        }
        const glm::dvec3 sum(demo::shade(scene, demo::LightTable(scene.lights), hit, down, lit));
        CHECK(glm::distance(sum, expected) <= 5e-6 * glm::length(expected));
    }
}

}  // namespace render_test
