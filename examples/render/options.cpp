// SPDX-License-Identifier: MIT
#include "render/options.hpp"

#include <cmath>
#include <iostream>

namespace demo {

const CLI::Validator finite_positive(
    [](const std::string& text) {
        float value = 0.0f;
        const bool fits = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value > 0.0f;
        return fits ? std::string() : text + " is not a finite number above 0";
    },
    "POSITIVE");

namespace {

lightmesh::ShortTest short_test_named(const std::string& name) {
    if (name == "none")
        return lightmesh::ShortTest::none;
    return name == "linked" ? lightmesh::ShortTest::linked : lightmesh::ShortTest::exact;
}

}  // namespace

std::vector<std::string> algorithm_names() {
    std::vector<std::string> names;
    for (const Algorithm& algorithm : algorithms())
        names.push_back(algorithm.name);
    return names;
}

void add_render_options(CLI::App& command, CommonOptions& options) {
    RenderOptions& render = options.render;
    command.add_option("--width", render.width, "of the picture in pixels")->capture_default_str();
    command.add_option("--height", render.height, "of the picture in pixels")->capture_default_str();
    command.add_option("--samples", render.samples, "rays per pixel")->capture_default_str();
    command.add_option("--depth-limit", render.depth_limit, "mirrored and refracted rays after each other")
        ->capture_default_str();
    command.add_option("--threads", render.threads, "0: all cores")->capture_default_str();
    VisibilityOptions& visibility = options.visibility;
    command.add_option("--area-samples", visibility.area_samples, "rays of 'area' to each light")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    command
        .add_option("--light-size", visibility.light_size,
                    "radius of the lamps of 'area' and 'cache'; default: a tenth of --radius")
        ->check(finite_positive);
    command.add_option("--depth", options.depth, "what renders shadow maps")
        ->check(CLI::IsMember({"vulkan", "embree"}))
        ->capture_default_str();
    command.add_option("--device", visibility.device, "of Vulkan: its number or a part of its name");
}

void add_scene_options(CLI::App& command, CommonOptions& options) {
    command.add_option("scene", options.scene, "park, spheres, rooms, or a file: OBJ, glTF, GLB, PLY")
        ->required();
    command.add_option("--lights", options.lights, "spread so many point lights over the scene, for its own")
        ->check(CLI::Range(1, 1000000));
    command
        .add_option("-r,--radius", options.radius,
                    "r, of the blur, in the scene's units; default: the scene's")
        ->check(finite_positive);
    command
        .add_option("-q,--quality", options.quality,
                    "q, light points per radius, 1 to 16; default: the scene's")
        ->check(CLI::Range(1.0f, 16.0f));
    command.add_option("--short-test", options.short_test, "of lmm: does a surface point see a light point?")
        ->check(CLI::IsMember({"exact", "linked", "none"}))
        ->capture_default_str();
    command
        .add_option("--map-size", options.visibility.settings.shadow_map_size,
                    "side of a shadow map in texels")
        ->check(CLI::Range(1, 16384))
        ->capture_default_str();
    command.add_flag("--refine-maps", options.visibility.settings.refine_shadow_maps,
                     "let rays decide where a shadow map cannot");
}

Scene load_scene(const std::string& name_or_file, std::size_t lights) {
    Scene scene = load_scene(name_or_file);
    if (lights > 0)
        spread_lights(scene, lights);
    for (const std::string& remark : scene.remarks)
        std::cout << "note: " << remark << '\n';
    return scene;
}

VisibilityOptions visibility_options(const CommonOptions& options, const Scene& scene) {
    VisibilityOptions visibility = options.visibility;
    visibility.settings.radius = options.radius.value_or(scene.radius);
    visibility.settings.quality = options.quality.value_or(scene.quality);
    visibility.settings.short_test = short_test_named(options.short_test);
    visibility.depth = options.depth == "embree" ? DepthSource::embree : DepthSource::vulkan;
    return visibility;
}

}  // namespace demo
