// SPDX-License-Identifier: MIT

// Files that users have, each the smallest of its kind: field/README.md lists what is right.

#include "../examples/render/open_scene.hpp"
#include "../examples/render/renderer.hpp"
#include "../examples/render/visibility.hpp"
#include "../examples/scene/boxes.hpp"
#include "../examples/scene/scene.hpp"
#include "../examples/scene/surface.hpp"
#include "render/illumination.hpp"
#include "render/view.hpp"
#include "run_command.hpp"
#include "temporary_folder.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <variant>

namespace field_test {

namespace {

const std::filesystem::path field = LIGHTMESH_FIELD;

bool has_remark(const demo::Scene& scene, const std::string& text) {
    return std::ranges::any_of(
        scene.remarks, [&](const std::string& remark) { return remark.find(text) != std::string::npos; });
}

/// A file with the values that it has.
demo::Scene as_is(const std::string& name) {
    demo::SceneOptions options;
    options.scene = (field / name).string();
    options.exposure = 0.0f;
    return demo::open_scene(options);
}

demo::Scene exposed(const std::string& name) {
    demo::SceneOptions options;
    options.scene = (field / name).string();
    return demo::open_scene(options);
}

/// A small picture by one algorithm.
demo::Image picture(const demo::Scene& scene, const std::string& algorithm, int width = 64, int height = 48) {
    const demo::EmbreeScene embree(scene);
    demo::VisibilityOptions options = demo::options_of(scene);
    options.depth = demo::DepthSource::embree;
    options.settings.shadow_map_size = 256;
    demo::RenderOptions render;
    render.width = width;
    render.height = height;
    demo::RenderStatistics statistics;
    return demo::render(embree, *demo::make_visibility(algorithm, embree, options), render, statistics);
}

/// The value that a picture shows of a point in the scene.
glm::vec3 seen_at(const demo::Scene& scene, const demo::Image& image, const glm::vec3& point) {
    const demo::Camera& camera = scene.camera;
    const glm::vec3 ahead = glm::normalize(camera.target - camera.eye);
    const glm::vec3 right = glm::normalize(glm::cross(ahead, camera.up));
    const glm::vec3 up = glm::cross(right, ahead);
    const glm::vec3 way = point - camera.eye;
    const float half = std::tan(0.5f * camera.vertical_field_of_view) * glm::dot(way, ahead);
    const float aspect = static_cast<float>(image.width) / static_cast<float>(image.height);
    const float x = 0.5f + 0.5f * glm::dot(way, right) / (half * aspect);
    const float y = 0.5f - 0.5f * glm::dot(way, up) / half;
    REQUIRE(x >= 0.0f);
    REQUIRE(x < 1.0f);
    REQUIRE(y >= 0.0f);
    REQUIRE(y < 1.0f);
    return image.at(static_cast<int>(x * static_cast<float>(image.width)),
                    static_cast<int>(y * static_cast<float>(image.height)));
}

float mean_green(const demo::Image& image) {
    double sum = 0.0;
    for (const glm::vec3& pixel : image.pixels)
        sum += static_cast<double>(pixel.g);
    return static_cast<float>(sum / static_cast<double>(image.pixels.size()));
}

/// The one line of error of a command, which must end with status 1.
std::string refusal(const std::string& arguments) {
    const test::TemporaryFolder folder;
    const test::Finished ran =
        test::run(folder, LIGHTMESH_RENDER " " + arguments + " -o " + (folder / "p.png").string());
    CHECK(ran.status == 1);
    CHECK(std::ranges::count(ran.errors, '\n') == 1);
    return ran.errors;
}

float max_height(const demo::Scene& scene) {
    return demo::bounds_of(scene).high.y;
}

}  // namespace

TEST_CASE("field: a lamp in the plane of the ceiling lights the room by all algorithms") {
    const demo::Scene scene = as_is("lamp-on-ceiling/lamp-on-ceiling.gltf");
    const float linked = mean_green(picture(scene, "linked"));
    CHECK(linked > 0.5f);
    for (const std::string algorithm : {"whitted", "shadow-map", "express"}) {
        CAPTURE(algorithm);
        CHECK(std::abs(mean_green(picture(scene, algorithm)) - linked) < 0.04f);
    }
}

TEST_CASE("field: exposure by what the camera sees") {
    for (const std::string file : {"lamp-holder", "spot"}) {
        CAPTURE(file);
        const demo::Scene scene = exposed("exposure/" + file + ".gltf");
        const demo::Image image = picture(scene, "whitted", 160, 120);
        std::size_t white = 0;
        std::size_t surface = 0;
        double sum = 0.0;
        const demo::EmbreeScene embree(scene);
        const demo::View view(scene.camera, 160, 120);
        for (int row = 0; row < 120; ++row)
            for (int column = 0; column < 160; ++column) {
                const float x = static_cast<float>(column) + 0.5f;
                const float y = static_cast<float>(row) + 0.5f;
                if (!embree.trace(view.origin(x, y), view.direction(x, y)))
                    continue;
                ++surface;
                white += image.at(column, row).g >= 1.0f ? 1 : 0;
                sum += static_cast<double>((glm::min)(image.at(column, row).g, 1.0f));
            }
        CHECK(static_cast<double>(white) < 0.02 * static_cast<double>(surface));
        // The spot alone is so small and bright that 2 % of white end the exposure before.
        CHECK(sum / static_cast<double>(surface) > (file == "spot" ? 0.06 : 0.1));
        CHECK(sum / static_cast<double>(surface) < 0.5);
    }
    const demo::Scene spot = as_is("exposure/spot.gltf");
    CHECK(seen_at(spot, picture(spot, "whitted"), {0, 0, 0}).g == doctest::Approx(0.53).epsilon(0.03));
}

TEST_CASE("field: an emissive texture dims the factor") {
    const demo::Scene scene = as_is("emissive-texture/emissive-texture.gltf");
    const glm::vec3 floor = seen_at(scene, picture(scene, "whitted"), {-2.5f, 0, 2});
    CHECK(floor.g > 0.1f);
    CHECK(floor.g < 0.33f);
    CHECK(scene.lights.size() == 1);
}

TEST_CASE("field: the radius suits what the camera looks at, whatever lies behind") {
    for (const std::string file : {"ground-20m", "ground-100m", "ground-1km"}) {
        CAPTURE(file);
        const demo::Scene scene = exposed("default-radius/" + file + ".gltf");
        CHECK(scene.radius > 0.1f);
        CHECK(scene.radius < 0.4f);
        // The middle of the hard shadow on the ground: away from the sun by half of what the box throws.
        const auto& sun = std::get<lightmesh::DirectionalLight>(scene.lights[0].shape);
        const glm::vec3 way = glm::normalize(sun.direction);
        const demo::EmbreeScene embree(scene);
        const glm::vec3 top = glm::vec3(0, 0.5f, 0);
        const glm::vec3 point =
            top + way * (0.5f / -way.y) + 0.3f * glm::normalize(glm::vec3(way.x, 0, way.z));
        lightmesh::Settings settings;
        settings.radius = scene.radius;
        const lightmesh::LightMesh mesh{embree.intersector(), demo::shapes_of_lights(scene), settings};
        CHECK(mesh.visibility(point, {0, 1, 0}, 0) < 0.3f);
    }
}

TEST_CASE("field: a closer view of a built-in scene has a smaller radius") {
    demo::SceneOptions options;
    options.scene = "rooms";
    CHECK(demo::open_scene(options).radius == 1.0f);
    options.eye = glm::vec3(-4, -21, 17.5f);
    options.target = glm::vec3(-3.4f, -8.6f, 0.3f);
    options.field_of_view = 5.0f;
    const float close = demo::open_scene(options).radius;
    CHECK(close > 0.05f);
    CHECK(close < 0.15f);
}

TEST_CASE("field: the radius of a view of sky with little before it is measured on a fine grid") {
    // Poles that fit between the rays of 96 x 72, before a wall behind that fills a thirteenth of the
    // picture.
    const test::TemporaryFolder folder;
    std::string text;
    int vertices = 0;
    const auto add_quad = [&](float x0, float x1, float y0, float y1, float z) {
        for (const auto& [x, y] : {std::pair(x0, y0), {x1, y0}, {x1, y1}, {x0, y1}})
            text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
        text += "f";
        for (int i = 1; i <= 4; ++i)
            text += " " + std::to_string(vertices + i);
        text += "\n";
        vertices += 4;
    };
    constexpr float half = 10.0f;  // of the picture's height where the poles stand
    const float pixel = 2.0f * half / 72.0f;
    for (int pole = 0; pole < 40; ++pole) {
        // Beside the middles of the pixels of 96 x 72.
        const float x = pixel * (static_cast<float>(pole - 20) + 0.1f);
        add_quad(x, x + 0.2f * pixel, -half, half, 0.0f);
    }
    add_quad(-40.0f, 40.0f, 8.0f, 11.0f, -10.0f);
    demo::SceneOptions options;
    options.scene = folder.write("poles.obj", text).string();
    options.eye = glm::vec3(0, 0, 10);
    options.target = glm::vec3(0, 0, 0);
    options.field_of_view = 90.0f;
    const float near_height = 2.0f * half;
    CHECK(demo::open_scene(options).radius == doctest::Approx(0.045 * near_height).epsilon(0.01));
}

TEST_CASE("field: vertex colours multiply, mesh by mesh") {
    const demo::Scene tiles = as_is("vertex-colours/vertex-colours.gltf");
    const demo::Image image = picture(tiles, "whitted");
    for (int tile = 0; tile < 3; ++tile) {
        const glm::vec3 colour = seen_at(tiles, image, {2.0f * static_cast<float>(tile - 1), 0, 0});
        for (int channel = 0; channel < 3; ++channel) {
            CAPTURE(tile);
            CAPTURE(channel);
            CHECK((colour[channel] > 0.5f) == (channel == tile));
        }
    }
    const demo::Scene red = as_is("vertex-colours/white-vertex-colours.gltf");
    const glm::vec3 colour = seen_at(red, picture(red, "whitted"), {0, 0, 0});
    CHECK(colour.r > 0.7f);
    CHECK(colour.g < 0.01f);
}

TEST_CASE("field: a camera is found by its number, not by its name") {
    const demo::Scene scene = as_is("same-name-camera/same-name-camera.gltf");
    CHECK(glm::length(scene.camera.eye - glm::vec3(0, 4, 8)) < 1e-4f);
    CHECK(seen_at(scene, picture(scene, "whitted"), {3, 1, 0}).g < 0.3f);  // the box is red
}

TEST_CASE("field: --camera takes a name or a number, and says which there are") {
    const std::string file = (field / "same-name-camera/same-name-camera.gltf").string();
    demo::ImportOptions options;
    options.camera = "0";
    CHECK(demo::import_scene(file, options).cameras.size() == 1);
    options.camera = "Camera";
    CHECK_NOTHROW(demo::import_scene(file, options));
    options.camera = "gone";
    CHECK_THROWS_WITH(demo::import_scene(file, options),
                      (file + ": there is no camera 'gone'; there are 0 'Camera'").c_str());
}

TEST_CASE("field: hidden nodes, instances, skins and morph targets") {
    const demo::Scene hidden = as_is("silently-ignored/hidden-nodes.gltf");
    REQUIRE(hidden.lights.size() == 1);
    CHECK(hidden.lights[0].name == "green");
    CHECK(hidden.mesh_count == 1);
    CHECK(has_remark(hidden, "1 meshes and 1 lights are hidden"));
    CHECK(as_is("silently-ignored/instancing.gltf").mesh_count == 6);
    CHECK(max_height(as_is("silently-ignored/morph.gltf")) > 1.4f);

    const demo::Scene skin = as_is("silently-ignored/skin.gltf");
    glm::vec3 low{std::numeric_limits<float>::max()};
    glm::vec3 high{std::numeric_limits<float>::lowest()};
    for (const glm::vec3& p : skin.positions)
        if (p.y > 0.01f) {
            low = (glm::min)(low, p);
            high = (glm::max)(high, p);
        }
    CHECK(low.x == doctest::Approx(-0.5f).epsilon(0.3));
    CHECK(low.y == doctest::Approx(1.5f).epsilon(0.01));
    CHECK(high.x < 1.0f);
}

TEST_CASE("field: what is required and not supported is refused by name") {
    CHECK(refusal("picture " + (field / "silently-ignored/required-unknown.gltf").string())
              .find("KHR_made_up") != std::string::npos);
}

TEST_CASE("field: a skin without bind matrices") {
    const demo::Scene scene = as_is("skin-crash/skin-without-bind-matrices.gltf");
    CHECK(scene.lights.size() == 2);
    CHECK(max_height(scene) > 2.0f);
}

TEST_CASE("field: percent-encoded names of files") {
    CHECK(as_is("percent-uri/percent.gltf").triangles.size() > 0);
}

TEST_CASE("field: range and cone as KHR_lights_punctual recommends") {
    const demo::Scene scene = as_is("range-and-cone/range.gltf");
    REQUIRE(scene.lights.size() == 1);
    for (const float d : {1.0f, 2.6f, 3.2f, 3.9f}) {
        const glm::vec3 point =
            std::get<lightmesh::PointLight>(scene.lights[0].shape).position + glm::vec3(0, -d, 0);
        const float expected = (1.0f - std::pow(d / 4.0f, 4.0f)) / (d * d);
        CHECK(demo::illuminate(scene.lights[0], point).irradiance.g ==
              doctest::Approx(expected).epsilon(1e-4));
    }
    demo::SceneLight spot;
    spot.shape = lightmesh::SpotLight{{0, 0, 0}, {0, 0, -1}, 0.9f};
    spot.inner_cone = 0.3f;
    for (const float angle : {0.2f, 0.5f, 0.8f, 0.88f}) {
        const float share =
            std::clamp((std::cos(angle) - std::cos(0.9f)) / (std::cos(0.3f) - std::cos(0.9f)), 0.0f, 1.0f);
        const glm::vec3 point{std::sin(angle), 0, -std::cos(angle)};
        CHECK(demo::illuminate(spot, point).irradiance.g == doctest::Approx(share * share).epsilon(1e-3));
    }
}

TEST_CASE("field: odd lamps are mended or left out, with a note") {
    const demo::Scene endless = as_is("range-and-cone/L-range0.gltf");
    REQUIRE(endless.lights.size() == 1);
    CHECK(std::isinf(std::get<lightmesh::PointLight>(endless.lights[0].shape).range));
    CHECK(has_remark(endless, "range 0"));
    CHECK(has_remark(as_is("range-and-cone/L-cone0.gltf"), "cone of 0"));
    CHECK(as_is("range-and-cone/L-nospot.gltf").lights.size() == 1);
    CHECK(as_is("range-and-cone/L-sun-scale0.gltf").lights.size() == 1);
    const demo::Scene dark = as_is("range-and-cone/L-zeroint.gltf");
    CHECK(dark.lights.empty());
    CHECK(has_remark(dark, "all 1 lights of the file are switched off"));
}

TEST_CASE("field: a lamp shines through its bulb") {
    for (const std::string file : {"bulb-emissive", "bulb-glass"})
        for (const std::string algorithm : {"whitted", "linked", "shadow-map", "shadow-volume"}) {
            CAPTURE(file);
            CAPTURE(algorithm);
            const demo::Scene scene = as_is("bulb-pane-mask/" + file + ".gltf");
            CHECK(seen_at(scene, picture(scene, algorithm), {0, 0, 0.5f}).g > 0.5f);
        }
}

TEST_CASE("field: a pane lets light through by its opacity") {
    const demo::Scene scene = as_is("bulb-pane-mask/pane.gltf");
    const demo::EmbreeScene embree(scene);
    const lightmesh::SurfacePoint point{{0.2f, 0, 0.3f}, {0, 1, 0}};
    const std::uint32_t seed = 1;
    const demo::SurfacePoints points{{&point, 1}, {&seed, 1}};
    demo::VisibilityCost cost;
    float lit = 0.0f;
    demo::make_hard_shadows(embree)->find(points, {&lit, 1}, cost);
    CHECK(lit == doctest::Approx(0.64f));

    // A light mesh decides by chance: right in the mean, and alike in both directions.
    const demo::EmbreeIntersector tracer = embree.intersector();
    int open = 0;
    const int count = 4000;
    for (int i = 0; i < count; ++i) {
        const float x = static_cast<float>(i) / static_cast<float>(count) - 0.5f;
        const lightmesh::Segment segment{{x, 0.01f, 0.4f * x}, {0, 3, 0}};
        const bool is_open = !tracer.occluded(segment);
        open += is_open ? 1 : 0;
        CHECK(is_open == !tracer.occluded(lightmesh::Segment{segment.target, segment.origin}));
    }
    CHECK(static_cast<double>(open) / count == doctest::Approx(0.64).epsilon(0.05));
}

TEST_CASE("field: OBJ: textures are drawn, and their holes let light through in every algorithm") {
    // A sheet over a floor; the left half of its texture is red, the right half is not there.
    const test::TemporaryFolder folder;
    std::string tga(18, '\0');
    tga[2] = 2;
    tga[12] = 8;
    tga[14] = 1;
    tga[16] = 32;
    tga[17] = 8;
    for (int i = 0; i < 8; ++i)
        tga += i < 4 ? std::string("\x00\x00\xff\xff", 4) : std::string("\x00\x00\xff\x00", 4);
    folder.write("leaf.tga", tga);
    folder.write("leaf.mtl", "newmtl leaf\nKd 1 1 1\nmap_Kd leaf.tga\nnewmtl floor\nKd .8 .8 .8\n");
    const auto file = folder.write("leaf.obj", "mtllib leaf.mtl\nv -2 1 2\nv 2 1 2\nv 2 1 -2\nv -2 1 -2\n"
                                               "v -9 0 9\nv 9 0 9\nv 9 0 -9\nv -9 0 -9\n"
                                               "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                                               "usemtl leaf\nf 1/1 2/2 3/3 4/4\nusemtl floor\nf 5 6 7 8\n");
    demo::Scene scene = demo::import_scene(file);
    scene.lights = {{lightmesh::DirectionalLight{{0, -1, 0}}, glm::vec3(1.0f)}};
    scene.ambient = glm::vec3(0.0f);
    scene.radius = 0.3f;
    scene.camera.eye = {0, 8, 0.1f};
    scene.camera.target = {0, 0, 0};
    const demo::EmbreeScene embree(scene);
    const auto left = embree.trace({-1, 5, 0}, {0, -1, 0});
    const auto right = embree.trace({1, 5, 0}, {0, -1, 0});
    REQUIRE(left.has_value());
    REQUIRE(right.has_value());
    CHECK(left->position.y == doctest::Approx(1.0f));
    CHECK(right->position.y == doctest::Approx(0.0f));
    scene.camera.eye = {5, 0.5f, 0};  // below the sheet
    scene.camera.target = {0, 0, 0};
    for (const std::string algorithm : {"whitted", "area", "shadow-map", "shadow-volume", "lmm", "linked",
                                        "express", "linked+map", "linked+volume"}) {
        CAPTURE(algorithm);
        const demo::Image image = picture(scene, algorithm, 96, 72);
        CHECK(seen_at(scene, image, {1, 0, 0}).g > 0.6f);
        CHECK(seen_at(scene, image, {-1, 0, 0}).g < 0.2f);
    }
}

TEST_CASE("field: surfaces that shine become lamps of their power, unless they are not to") {
    const test::TemporaryFolder folder;
    folder.write("box.mtl", "newmtl lamp\nKd 0 0 0\nKe 10 10 10\nnewmtl floor\nKd .8 .8 .8\n");
    const std::string file =
        folder
            .write("box.obj", "mtllib box.mtl\nv -.1 2 -.1\nv .1 2 -.1\nv .1 2 .1\nv -.1 2 .1\n"
                              "v -9 0 9\nv 9 0 9\nv 9 0 -9\nv -9 0 -9\n"
                              "usemtl lamp\nf 1 2 3 4\nusemtl floor\nf 5 6 7 8\n")
            .string();
    const demo::Scene scene = demo::import_scene(file);
    REQUIRE(scene.lights.size() == 2);  // one to each side
    // On the axis of a small patch: L A / d^2, over pi, since surfaces here reflect all of their colour.
    const float expected = 10.0f * 0.04f / 4.0f / 3.14159265f;
    const glm::vec3 below = demo::illuminate(scene.lights[0], {0, 0, 0}).irradiance +
                            demo::illuminate(scene.lights[1], {0, 0, 0}).irradiance;
    const glm::vec3 above = demo::illuminate(scene.lights[0], {0, 4, 0}).irradiance +
                            demo::illuminate(scene.lights[1], {0, 4, 0}).irradiance;
    CHECK(below.g == doctest::Approx(expected).epsilon(0.01));
    CHECK(above.g == doctest::Approx(expected).epsilon(0.01));
    const demo::EmbreeScene embree(scene);
    for (const demo::SceneLight& light : scene.lights) {
        const auto& pane = std::get<lightmesh::RectLight>(light.shape);
        CHECK(glm::length(pane.half_u) == doctest::Approx(0.1f));
        CHECK(glm::length(pane.half_v) == doctest::Approx(0.1f));
        CHECK_FALSE(embree.intersector().occluded(
            demo::shadow_segment(light, {0.5f, 0, 0}, {0, 1, 0}, embree.offset(), embree.far_away())));
    }
    demo::ImportOptions without;
    without.emitters = false;
    CHECK(demo::import_scene(file, without).lights.size() == 6);
}

TEST_CASE("field: boxes that shine light outwards, large panes are quarters, other forms are points") {
    const test::TemporaryFolder folder;
    folder.write("a.mtl", "newmtl lamp\nKe 1 1 1\nnewmtl floor\nKd .8 .8 .8\n");
    const auto lights_of = [&](const std::string& lamp) {
        return demo::import_scene(
                   folder.write("a.obj", "mtllib a.mtl\nv -9 0 9\nv 9 0 9\nv 9 0 -9\nv -9 0 -9\n"
                                         "usemtl floor\nf 1 2 3 4\nusemtl lamp\n" +
                                             lamp))
            .lights;
    };
    const auto sum_of = [](const std::vector<demo::SceneLight>& lights) {
        float sum = 0.0f;
        for (const demo::SceneLight& light : lights)
            sum += light.intensity.g;
        return sum;
    };
    const float pi = 3.14159265f;
    const auto box = lights_of("v 0 1 0\nv .1 1 0\nv .1 1.1 0\nv 0 1.1 0\nv 0 1 .1\nv .1 1 .1\nv .1 1.1 .1\n"
                               "v 0 1.1 .1\nf 5 6 7 8\nf 6 5 9 10\nf 7 6 10 11\nf 8 7 11 12\nf 5 8 12 9\n"
                               "f 9 12 11 10\n");
    REQUIRE(box.size() == 6);
    CHECK(sum_of(box) == doctest::Approx(6 * 0.01f / pi));
    for (const demo::SceneLight& light : box) {
        const auto& pane = std::get<lightmesh::RectLight>(light.shape);
        CHECK(glm::dot(glm::cross(pane.half_u, pane.half_v), pane.position - glm::vec3(0.05f, 1.05f, 0.05f)) >
              0.0f);
    }
    const auto large = lights_of("v -2 3 -1\nv 2 3 -1\nv 2 3 1\nv -2 3 1\nf 5 6 7 8\n");
    REQUIRE(large.size() == 8);
    CHECK(sum_of(large) == doctest::Approx(2 * 8.0f / pi));
    for (const demo::SceneLight& light : large) {
        const auto& pane = std::get<lightmesh::RectLight>(light.shape);
        CHECK(glm::length(glm::cross(pane.half_u, pane.half_v)) == doctest::Approx(0.5f));
        CHECK(std::abs(pane.position.x) == doctest::Approx(1.0f));
        CHECK(std::abs(pane.position.z) == doctest::Approx(0.5f));
    }
    const auto triangle = lights_of("v 0 3 0\nv .1 3 0\nv 0 3 .1\nf 5 6 7\n");
    REQUIRE(triangle.size() == 1);
    // As large as a disc of the same area.
    CHECK(std::get<lightmesh::PointLight>(triangle[0].shape).radius ==
          doctest::Approx(std::sqrt(0.005f / pi)));
    CHECK(sum_of(triangle) == doctest::Approx(0.005f / pi));
}

TEST_CASE("field: a pane lights a box alike by all algorithms, with soft edges where its size counts") {
    // A Cornell box: a pane just below the ceiling, a block on the floor.
    const test::TemporaryFolder folder;
    folder.write("c.mtl", "newmtl wall\nKd .75 .75 .75\nnewmtl lamp\nKd 0 0 0\nKe 9 9 9\n");
    const auto file = folder.write(
        "c.obj", "mtllib c.mtl\nv 0 0 0\nv 2 0 0\nv 2 0 2\nv 0 0 2\nv 0 2 0\nv 2 2 0\nv 2 2 2\nv 0 2 2\n"
                 "v .7 1.98 .7\nv 1.3 1.98 .7\nv 1.3 1.98 1.3\nv .7 1.98 1.3\n"
                 "v .8 .8 .8\nv 1.2 .8 .8\nv 1.2 .8 1.2\nv .8 .8 1.2\nusemtl wall\nf 4 3 2 1\nf 5 6 7 8\n"
                 "f 1 2 6 5\nf 1 5 8 4\nf 2 3 7 6\nf 13 14 15 16\nusemtl lamp\nf 9 10 11 12\n");
    demo::SceneOptions options;
    options.scene = file.string();
    options.eye = glm::vec3(1, 1, 5.5f);
    options.target = glm::vec3(1, 1, 0);
    const demo::Scene scene = demo::open_scene(options);
    const float linked = mean_green(picture(scene, "linked"));
    CHECK(linked > 0.1f);
    CHECK(linked < 0.5f);
    for (const std::string algorithm : {"whitted", "area", "cache", "shadow-map"}) {
        CAPTURE(algorithm);
        CHECK(std::abs(mean_green(picture(scene, algorithm)) - linked) < 0.03f);
    }
    // At the edge of what the block hides some of the pane is seen.
    const demo::Image area = picture(scene, "area", 128, 96);
    const float dark = seen_at(scene, area, {1, 0, 1.0f}).g;
    const float edge = seen_at(scene, area, {1, 0, 1.35f}).g;
    const float open = seen_at(scene, area, {1, 0, 1.8f}).g;
    CHECK(dark < 0.75f * edge);
    CHECK(edge < 0.95f * open);
}

TEST_CASE("field: signs that shine are no lamps to see by") {
    const test::TemporaryFolder folder;
    folder.write("a.mtl", "newmtl sign\nKe 1 1 1\nnewmtl floor\nKd .8 .8 .8\n");
    demo::SceneOptions options;
    options.scene = folder
                        .write("a.obj", "mtllib a.mtl\nv -9 0 9\nv 9 0 9\nv 9 0 -9\nv -9 0 -9\n"
                                        "v 0 1 0\nv .1 1 0\nv .1 1.1 0\nv 0 1.1 0\n"
                                        "usemtl floor\nf 1 2 3 4\nusemtl sign\nf 5 6 7 8\n")
                        .string();
    const demo::Scene scene = demo::open_scene(options);
    CHECK(has_remark(scene, "too little light to see by"));
    CHECK(scene.lights.size() == 8);
    CHECK(scene.exposure < 8.0f);
}

TEST_CASE("field: a building without camera and lights is seen from inside, and lit there") {
    // Two closed rooms with a door between them.
    const test::TemporaryFolder folder;
    std::string obj;
    int corners = 0;
    const auto quad = [&](glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) {
        for (const glm::vec3& p : {a, b, c, d})
            obj += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
        obj += "f " + std::to_string(corners + 1) + " " + std::to_string(corners + 2) + " " +
               std::to_string(corners + 3) + " " + std::to_string(corners + 4) + "\n";
        corners += 4;
    };
    quad({0, 0, 0}, {0, 0, 4}, {10, 0, 4}, {10, 0, 0});
    quad({0, 3, 0}, {10, 3, 0}, {10, 3, 4}, {0, 3, 4});
    quad({0, 0, 0}, {10, 0, 0}, {10, 3, 0}, {0, 3, 0});
    quad({0, 0, 4}, {0, 3, 4}, {10, 3, 4}, {10, 0, 4});
    quad({0, 0, 0}, {0, 3, 0}, {0, 3, 4}, {0, 0, 4});
    quad({10, 0, 0}, {10, 0, 4}, {10, 3, 4}, {10, 3, 0});
    quad({5, 0, 0}, {5, 0, 2.5f}, {5, 3, 2.5f}, {5, 3, 0});
    demo::SceneOptions options;
    options.scene = folder.write("house.obj", obj).string();
    const demo::Scene scene = demo::open_scene(options);
    CHECK(has_remark(scene, "no camera, but rooms: seen from inside"));
    CHECK(has_remark(scene, "4 point lights added where the camera looks"));
    for (int axis = 0; axis < 3; ++axis) {
        CHECK(scene.camera.eye[axis] > 0.0f);
        CHECK(scene.camera.eye[axis] < glm::vec3(10, 3, 4)[axis]);
    }
    for (const demo::SceneLight& light : scene.lights) {
        const glm::vec3 place = std::get<lightmesh::PointLight>(light.shape).position;
        CHECK(place.y > 1.0f);
        CHECK(place.y < 3.0f);
    }
    const float mean = mean_green(picture(scene, "whitted"));
    CHECK(mean > 0.1f);
    CHECK(mean < 0.6f);
}

TEST_CASE("field: a lamp in a closed box is named") {
    const test::TemporaryFolder folder;
    const std::string json =
        R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1,2]}],
        "extensionsUsed":["KHR_lights_punctual"],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":5}]}},
        "nodes":[{"mesh":0,"scale":[0.01,0.01,0.01]},{"mesh":0,"translation":[0,-3,0]},
            {"name":"bulb","extensions":{"KHR_lights_punctual":{"light":0}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
            {"bufferView":1,"componentType":5121,"count":12,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],
        "buffers":[{"byteLength":60,"uri":"closed%20box.bin"}]})";
    std::string bytes;
    for (const float value : {1.f, 1.f, 1.f, -1.f, -1.f, 1.f, -1.f, 1.f, -1.f, 1.f, -1.f, -1.f})
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    for (const char index : {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2})
        bytes.push_back(index);
    folder.write("closed box.bin", bytes);
    demo::SceneOptions options;
    options.scene = folder.write("closed.gltf", json).string();
    CHECK(has_remark(demo::open_scene(options), "lamp 'bulb' is inside a closed surface: it lights nothing"));
}

TEST_CASE("field: a scene far from the origin is as one that is near") {
    const demo::Scene near_one = exposed("far-from-origin/near.obj");
    const demo::Scene far_one = exposed("far-from-origin/utm.obj");
    CHECK(has_remark(far_one, "far from the origin"));
    CHECK(demo::mean_absolute_difference(picture(near_one, "whitted"), picture(far_one, "whitted")) < 0.002);
}

TEST_CASE("field: hostile files get one line and status 1") {
    CHECK(refusal("picture " + (field / "hostile/two-corner.obj").string())
              .find("line 5: a face of 2 corners") != std::string::npos);
    CHECK(refusal("picture " + (field / "hostile/backslash.obj").string()).find("line 15") !=
          std::string::npos);
    CHECK(refusal("picture " + (field / "hostile/header.ply").string()).find("no end") != std::string::npos);
    CHECK(refusal("picture " + (field / "hostile/cam-scale0.gltf").string()).find("node 1") !=
          std::string::npos);
    CHECK(refusal("picture " + (field / "hostile/badchunk.glb").string()).find("4294967280") !=
          std::string::npos);
    const test::TemporaryFolder folder;
    const std::string deep = std::string(100000, '[') + std::string(100000, ']');
    CHECK(refusal("picture " +
                  folder.write("deep.gltf", R"({"asset":{"version":"2.0"},"extras":)" + deep + "}").string())
              .find("nested deeper") != std::string::npos);
    const std::string ply =
        "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n";
    CHECK(refusal("picture " + folder.write("many.ply", ply).string()).find("4000000000") !=
          std::string::npos);
}

TEST_CASE("field: a chain of 100,000 nodes") {
    std::string nodes = R"({"mesh":0})";
    for (int i = 1; i < 100000; ++i)
        nodes += R"(,{"children":[)" + std::to_string(i - 1) + R"(],"translation":[0.5,0,0]})";
    const std::string file = R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[99999]}],"nodes":[)" + nodes +
                             R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
           "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
           "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
    const test::TemporaryFolder folder;
    const demo::Scene scene = demo::import_scene(folder.write("chain.gltf", file));
    CHECK(scene.triangles.size() == 1);
    CHECK(scene.origin.x + static_cast<double>(scene.positions[0].x) == doctest::Approx(49999.5));
}

TEST_CASE("field: a radius that dwarfs the scene is refused") {
    const test::TemporaryFolder folder;
    const test::Finished ran =
        test::run(folder, LIGHTMESH_TUNE " " + (field / "hostile/ok.glb").string() +
                              " -r 1e30 -q 2 --short-test none "
                              "--long-test rays --points 200 --reference-points 50 -o " +
                              (folder / "out").string());
    CHECK(ran.status == 1);
    CHECK(ran.errors.find("1e+30") != std::string::npos);
}

TEST_CASE("lightmesh-render info: text and JSON") {
    const test::TemporaryFolder folder;
    const std::string file = (field / "bulb-pane-mask/pane.gltf").string();
    const test::Finished text = test::run(folder, LIGHTMESH_RENDER " info " + file);
    CHECK(text.status == 0);
    CHECK(text.output.find("triangles: 14") != std::string::npos);
    const test::Finished json = test::run(folder, LIGHTMESH_RENDER " info --json " + file);
    CHECK(json.status == 0);
    CHECK(json.output.find("\"alpha\": \"blend\"") != std::string::npos);
}

TEST_CASE("lightmesh-render: outputs that cannot be written are found before rendering") {
    const test::TemporaryFolder folder;
    const std::string size = " --width 4096 --height 4096 --samples 1024 ";
    for (const std::string& output :
         {std::string("/dev/full"), std::string("p.jpg"), (folder / "").string()}) {
        CAPTURE(output);
        const test::Finished ran =
            test::run(folder, LIGHTMESH_RENDER " picture spheres" + size + "-o " + output);
        CHECK(ran.status == 1);
        CHECK(ran.errors.find("cannot write") != std::string::npos);
    }
    const test::Finished exr = test::run(folder, LIGHTMESH_RENDER " picture spheres" + size + "-o " +
                                                     (folder / "a.png").string() + " --exr /dev/full");
    CHECK(exr.status == 1);
    const test::Finished full = test::run(folder, LIGHTMESH_RENDER " info spheres > /dev/full");
    CHECK(full.status == 1);
}

TEST_CASE("lightmesh-render: SIGTERM ends it as Ctrl-C does, and keeps a finished picture") {
    const test::TemporaryFolder folder;
    const std::string before = folder.write("p.png", "a finished picture").string();
    const test::Finished ran =
        test::run(folder, "timeout -s TERM 1 " LIGHTMESH_RENDER
                          " picture park -a area --samples 64 --width 1920 --height 1440 -o " +
                              before + "; test $? = 124");
    CHECK(ran.status == 0);
    CHECK(demo::read_file(before) == "a finished picture");
    CHECK(folder.file_count() == 3);  // the picture, and what the command printed
}

TEST_CASE("field: glTF: textures of all wraps, drawn in linear light") {
    const test::TemporaryFolder folder;
    std::string tga(18, '\0');  // two texels: black, and the sRGB value 188, which is half of full light
    tga[2] = 2;
    tga[12] = 2;
    tga[14] = 1;
    tga[16] = 24;
    tga += std::string("\x00\x00\x00\xbc\xbc\xbc", 6);
    folder.write("two.tga", tga);
    std::string bytes;
    for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 4.f, 0.f, 0.f, 1.f})
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    folder.write("mesh.bin", bytes);
    const std::string start = R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "extensionsUsed":["KHR_texture_transform"],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
            {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
        "buffers":[{"byteLength":60,"uri":"mesh.bin"}],"images":[{"uri":"two.tga"}],
        "textures":[{"source":0,"sampler":0}],"materials":[{"pbrMetallicRoughness":{"metallicFactor":0,
        "baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[)";
    const auto value_at = [&](const std::string& offset, const std::string& wrap, float u) {
        const std::string json = start + offset + R"(,0]}}}}}],"samplers":[{"wrapS":)" + wrap + "}]}";
        return demo::surface_at(demo::import_scene(folder.write("a.gltf", json)), 0, u, 0.0f).diffuse.g;
    };
    const float half = 0.503f;
    CHECK(value_at("0", "10497", 0.1875f) ==
          doctest::Approx(half).epsilon(0.02));                       // u = 0.75: the second texel
    CHECK(value_at("0", "10497", 0.3125f) == doctest::Approx(0.0f));  // 1.25: the first, again
    CHECK(value_at("0", "33648", 0.3125f) == doctest::Approx(half).epsilon(0.02));  // mirrored: the second
    CHECK(value_at("0", "33071", 0.9f) == doctest::Approx(half).epsilon(0.02));     // clamped
    CHECK(value_at("0.5", "10497", 0.1875f) == doctest::Approx(0.0f));              // moved by one texel
    CHECK(value_at("0", "10497", 0.125f) == doctest::Approx(0.5f * half).epsilon(0.02));  // between: linear
}

}  // namespace field_test
