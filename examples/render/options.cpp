// SPDX-License-Identifier: MIT
#include "render/options.hpp"

#include "render/run.hpp"
#include "render/text_table.hpp"
#include "scene/boxes.hpp"

#include <cmath>
#include <iostream>
#include <sstream>
#include <stdexcept>

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

/// Three numbers with commas between them, or the name of an axis.
glm::vec3 vector_of(const std::string& option, const std::string& text) {
    if (text == "x" || text == "y" || text == "z")
        return {text == "x" ? 1.0f : 0.0f, text == "y" ? 1.0f : 0.0f, text == "z" ? 1.0f : 0.0f};
    std::istringstream words(text);
    glm::vec3 value{0.0f};
    std::string word;
    int count = 0;
    bool fits = true;
    for (; std::getline(words, word, ','); ++count)
        fits =
            fits && count < 3 && CLI::detail::lexical_cast(word, value[count]) && std::isfinite(value[count]);
    if (!fits || count != 3)
        throw CLI::ValidationError(option, "'" + text + "' is not x,y,z");
    if (option == "--up" && value == glm::vec3(0.0f))
        throw CLI::ValidationError(option, "0,0,0 is no direction");
    return value;
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
        .add_option(
            "--light-size", visibility.light_size,
            "radius of the lamps of 'area' and 'cache', in the scene's units; default: the file's, else a "
            "third of --radius, and the sun's angle for directional lights")
        ->check(finite_positive);
    command.add_option("--depth", options.depth, "what renders shadow maps")
        ->check(CLI::IsMember({"vulkan", "embree"}))
        ->capture_default_str();
    command.add_option("--device", visibility.device, "of Vulkan: its number or a part of its name");
}

void add_on_options(CLI::App& command, std::string& on, VisibilityOptions& visibility) {
    command.add_option("--on", on, "what renders: the CPU, or compute shaders on --device")
        ->check(CLI::IsMember({"cpu", "gpu"}))
        ->capture_default_str();
    command
        .add_option_function<std::string>(
            "--gpu-rays",
            [&visibility](const std::string& how) { visibility.ray_queries = how == "queries"; },
            "how shaders of --on gpu trace rays: by ray queries, or through a BVH of their own; default: by "
            "queries on a GPU that has them")
        ->check(CLI::IsMember({"queries", "bvh"}));
}

void check_on_options(const std::string& on, const VisibilityOptions& visibility) {
    if (on != "gpu" && visibility.ray_queries)
        throw std::invalid_argument("--gpu-rays is for --on gpu, not for --on " + on);
}

void add_tone_option(CLI::App& command, CommonOptions& options) {
    command
        .add_option_function<std::string>(
            "--tone",
            [&options](const std::string& name) {
                options.render.tone = name == "filmic" ? Tone::filmic : Tone::linear;
            },
            "curve of PNG files: linear (default), white at 1, or filmic, which keeps what is brighter apart")
        ->check(CLI::IsMember({"linear", "filmic"}));
}

CLI::Validator finite_range(float low, float high) {
    const auto check = [low, high](const std::string& text) {
        float value = 0.0f;
        const bool fits = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
        return fits ? std::string()
                    : text + " is not a number from " + fixed(static_cast<double>(low), 0) + " to " +
                          fixed(static_cast<double>(high), 0);
    };
    return {check,
            "[" + fixed(static_cast<double>(low), 0) + " - " + fixed(static_cast<double>(high), 0) + "]"};
}

void add_file_options(CLI::App& command, SceneOptions& options) {
    command
        .add_option("scene", options.scene, "park, spheres, rooms, street, or a file: OBJ, glTF, GLB, PLY")
        ->required();
    command.add_option("--lights", options.lights, "spread so many point lights over the scene, for its own")
        ->check(CLI::Range(1, 1000000));
    command.add_option("--camera", options.import.camera, "of the file: its name, or its number from 0");
    command
        .add_option_function<double>(
            "--time", [&options](double seconds) { options.import.time = seconds; },
            "of an animation of glTF, in seconds: nodes, skins and morph targets; default: the file's pose")
        ->check(finite_range(0.0f, 1e9f));
    command.add_option("--animation", options.import.animation,
                       "the one of --time: its name, or its number from 0; default: the first one");
    const auto add_place = [&command](const char* name, std::optional<glm::vec3>& value, const char* what) {
        command.add_option_function<std::string>(
            name, [&value, name](const std::string& text) { value = vector_of(name, text); }, what);
    };
    add_place("--eye", options.eye, "where the camera is: x,y,z as in the file");
    add_place("--target", options.target, "where it looks; default: the middle of the scene");
    command.add_option_function<std::string>(
        "--up",
        [&options](const std::string& text) {
            options.up = vector_of("--up", text);
            options.import.z_is_up = *options.up == glm::vec3(0, 0, 1);
        },
        "y, z, or x,y,z: what is up in the picture, and in OBJ and PLY");
    command.add_option("--fov", options.field_of_view, "vertical angle of the view in degrees")
        ->check(finite_range(1.0f, 170.0f));
    command.add_option_function<std::string>(
        "--exposure",
        [&options](const std::string& text) {
            float value = 0.0f;
            if (text == "auto")
                options.exposure.reset();
            else if (CLI::detail::lexical_cast(text, value) && std::abs(value) <= 64.0f)
                options.exposure = value;
            else
                throw CLI::ValidationError("--exposure",
                                           text + " is neither auto nor a number from -64 to 64");
        },
        "of the picture: auto (files), or the power of two that its values are multiplied by");
    command
        .add_option_function<std::string>(
            "--emitters", [&options](const std::string& text) { options.import.emitters = text == "on"; },
            "whether surfaces of a file that shine become lights: on (default) or off")
        ->check(CLI::IsMember({"on", "off"}));
}

void add_scene_options(CLI::App& command, CommonOptions& options) {
    add_file_options(command, options);
    command
        .add_option("-r,--radius", options.radius,
                    "r, of the blur, in the scene's units; default: the scene's")
        ->check(finite_positive);
    command
        .add_option("-q,--quality", options.quality,
                    "q, light points per radius, 1 to 16; default: the scene's")
        ->check(finite_range(1.0f, 16.0f));
    lightmesh::CacheSettings& cache = options.visibility.cache;
    command
        .add_option("-g,--spacing", cache.spacing,
                    "g, of a cache's coarsest records, in the scene's units; default: a quarter of --radius")
        ->check(finite_positive);
    command.add_option("--detail", cache.detail, "how often a cache halves g along penumbrae, 0 to 6")
        ->check(CLI::Range(0, 6))
        ->capture_default_str();
    command.add_option("--lamp-rays", cache.lamp_rays, "rays of 'cache' from a record to a lamp, at most")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    command.add_flag(
        "!--no-shaft-rows", cache.shaft_rows,
        "of 'cache': records do not look around themselves, and miss contact shadows of thin things");
    command.add_flag("--exact-edges", cache.exact_edges,
                     "of 'cache': rays from points decide where the finest records of a view disagree; for "
                     "small stills, at ten times the rays of a filled cache or more");
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

Scene show_scene(const SceneOptions& options) {
    Scene scene = open_scene(options);
    for (const std::string& remark : scene.remarks)
        std::cout << "note: " << remark << '\n';
    return scene;
}

void check_radius(float radius, const Scene& scene) {
    constexpr float most = 1000.0f;
    const float size = diagonal_of(bounds_of(scene));
    if (!(radius <= most * size))
        throw std::invalid_argument("--radius " + number(radius) +
                                    " is more than 1000 times the size of the scene, " + number(size));
}

VisibilityOptions visibility_options(const CommonOptions& options, const Scene& scene) {
    VisibilityOptions visibility = options.visibility;
    visibility.settings.radius = options.radius.value_or(scene.radius);
    check_radius(visibility.settings.radius, scene);
    visibility.settings.quality = options.quality.value_or(scene.quality);
    visibility.settings.short_test = short_test_named(options.short_test);
    visibility.depth = options.depth == "embree" ? DepthSource::embree : DepthSource::vulkan;
    return visibility;
}

}  // namespace demo
