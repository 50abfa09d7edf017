// SPDX-License-Identifier: MIT
#include "tune/options.hpp"

#include "render/options.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace demo {

namespace tune = lightmesh::tune;

namespace {

constexpr std::array short_test_names{std::pair{"none", lightmesh::ShortTest::none},
                                      std::pair{"linked", lightmesh::ShortTest::linked},
                                      std::pair{"exact", lightmesh::ShortTest::exact}};

constexpr std::array shaft_row_names{std::pair{"on", true}, std::pair{"off", false}};

constexpr std::array long_test_names{std::pair{"rays", tune::LongTest::rays},
                                     std::pair{"maps", tune::LongTest::shadow_maps},
                                     std::pair{"refined-maps", tune::LongTest::refined_shadow_maps},
                                     std::pair{"volumes", tune::LongTest::shadow_volumes}};

template <class Names>
std::vector<std::string> all_names(const Names& names) {
    std::vector<std::string> all;
    for (const auto& [name, value] : names)
        all.emplace_back(name);
    return all;
}

/// The values of names that CLI11 has checked.
template <class Value, class Names>
std::vector<Value> values_of(const std::vector<std::string>& chosen, const Names& names) {
    std::vector<Value> values;
    for (const std::string& one : chosen)
        for (const auto& [name, value] : names)
            if (one == name)
                values.push_back(value);
    return values;
}

/// A number and what follows it. Throws std::invalid_argument.
std::pair<double, std::string> number_and_unit(const std::string& text) {
    std::size_t end = 0;
    const double number = std::stod(text, &end);
    return {number, text.substr(end)};
}

/// Runs `read`; what it throws becomes CLI11's own error.
template <class Read>
void validated(const std::string& option, Read&& read) {
    try {
        read();
    } catch (const std::invalid_argument& error) {
        throw CLI::ValidationError(option, error.what());
    }
}

void add_wishes(CLI::App& program, TuneOptions& options) {
    program.add_option_function<std::string>(
        "--budget",
        [&options](const std::string& text) {
            validated("--budget", [&] { read_budget(text, options.wishes); });
        },
        "at most so much time: 200ns a point, or 0.5s a frame");
    program.add_option_function<std::string>(
        "--error",
        [&options](const std::string& text) {
            validated("--error", [&] { options.wishes.mean_absolute_error = read_share(text); });
        },
        "at most this mean absolute error, of meshes to a converged one, of caches to lamps of 256 rays: "
        "0.01 or 1%");
    program
        .add_option_function<std::uint64_t>(
            "--memory",
            [&options](std::uint64_t bytes) {
                if (bytes == 0)
                    throw CLI::ValidationError("--memory", "0 leaves no room for a mesh");
                options.wishes.bytes = static_cast<double>(bytes);
            },
            "at most so much for the mesh or cache of a frame: 500MB")
        ->transform(CLI::Validator(
            [](const std::string& text) {
                return text.find('-') == std::string::npos ? std::string() : text + " is no amount of memory";
            },
            ""))
        ->transform(CLI::AsSizeValue(true));
    program.add_flag_callback(
        "--warm", [&options] { options.wishes.frame = tune::Frame::later; },
        "choose for a frame that finds mesh or cache filled (a moving camera), not for the first one");
}

void add_choices(CLI::App& program, TuneOptions& options) {
    program
        .add_option("-r,--radius", options.radii,
                    "radii to try, in the scene's units; default: from its penumbrae")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(finite_positive);
    program.add_option("-q,--quality", options.qualities, "qualities to try; default: 2,3,4,6")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(finite_range(1.0f, 16.0f));
    program.add_option("--short-test", options.short_tests, "short tests to try; default: all")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember(all_names(short_test_names)));
    program
        .add_option("--long-test", options.long_tests,
                    "long tests to try; default: rays everywhere, and maps of 512 with the middle radius")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember(all_names(long_test_names)));
    program
        .add_option("--map-size", options.map_sizes,
                    "sides of shadow maps to try, in texels; default: 512,1024")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::Range(1, 16384));
    const auto add_list = [&program](const char* name, auto& values, const char* what) {
        return program.add_option(name, values, what)->delimiter(',')->allow_extra_args(false);
    };
    add_list("-g,--spacing", options.spacings,
             "g of caches to try, in the scene's units; default: a half and a quarter of the middle radius")
        ->check(finite_positive);
    add_list("--detail", options.details, "how often caches halve g; default: 2,3")->check(CLI::Range(0, 6));
    add_list("--lamp-rays", options.lamp_rays, "rays of caches to a lamp to try; default: 16,64")
        ->check(CLI::Range(1, 256));
    add_list("--shaft-rows", options.shaft_rows,
             "whether records of caches look around themselves; default: on,off")
        ->check(CLI::IsMember(all_names(shaft_row_names)));
    program
        .add_option_function<std::string>(
            "--caches", [&options](const std::string& text) { options.caches = text == "on"; },
            "whether visibility caches are tried beside light meshes: on (default) or off")
        ->check(CLI::IsMember({"on", "off"}));
    program
        .add_option("--light-size", options.visibility.light_size,
                    "radius of the lamps, in the scene's units; default: the file's, else a third of the "
                    "scene's radius, and the sun's angle for directional lights")
        ->check(finite_positive);
    program
        .add_option("--lamp-angle", options.lamp_angle,
                    "radius of a lamp as seen from what it lights, in radians: radii are suggested for it")
        ->check(finite_positive)
        ->check(CLI::Range(0.0, 1000.0))
        ->capture_default_str();
}

void add_measurement(CLI::App& program, TuneOptions& options) {
    program.add_option("--width", options.render.width, "of a frame in pixels")
        ->check(CLI::Range(1, 65536))
        ->capture_default_str();
    program.add_option("--height", options.render.height, "of a frame in pixels")
        ->check(CLI::Range(1, 65536))
        ->capture_default_str();
    program.add_option("--points", options.points, "shading points to measure with")
        ->check(CLI::Range(1, 10000000))
        ->capture_default_str();
    program
        .add_option("--reference-points", options.reference_points, "those of them whose error is measured")
        ->check(CLI::Range(1, 10000000))
        ->capture_default_str();
    program.add_option("--threads", options.render.threads, "that a frame is shared among; 0: all cores")
        ->check(CLI::Range(0, 4096))
        ->capture_default_str();
    program.add_option("--depth", options.visibility.depth, "what renders shadow maps: vulkan or embree")
        ->transform(CLI::CheckedTransformer(std::vector<std::pair<std::string, DepthSource>>{
            {"vulkan", DepthSource::vulkan}, {"embree", DepthSource::embree}}));
    program.add_option("--device", options.visibility.device, "of Vulkan: its number or a part of its name");
}

}  // namespace

void read_budget(const std::string& text, tune::Wishes& wishes) {
    const auto fail = [&] {
        throw std::invalid_argument("'" + text +
                                    "' is no budget: write 200ns (a point), or 0.5s or 500ms (a frame)");
    };
    double number = 0.0;
    std::string unit;
    try {
        std::tie(number, unit) = number_and_unit(text);
    } catch (const std::logic_error&) {
        fail();
    }
    if (!std::isfinite(number) || number <= 0.0)
        fail();
    if (unit.empty() || unit == "ns")
        wishes.ns_per_point = number;
    else if (unit == "s")
        wishes.seconds_per_frame = number;
    else if (unit == "ms")
        wishes.seconds_per_frame = 1e-3 * number;
    else
        fail();
}

double read_share(const std::string& text) {
    double number = -1.0;
    std::string unit;
    try {
        std::tie(number, unit) = number_and_unit(text);
    } catch (const std::logic_error&) {
        number = -1.0;
    }
    if (unit == "%")
        number /= 100.0;
    if (!(number >= 0.0 && number <= 1.0) || !(unit.empty() || unit == "%"))
        throw std::invalid_argument("'" + text + "' is no error: write 0.01 or 1%");
    return number;
}

std::vector<tune::Candidate> choose_candidates(const TuneOptions& options, const std::vector<float>& radii,
                                               float middle_radius) {
    tune::Choices choices;
    choices.radii = radii;
    if (!options.qualities.empty())
        choices.qualities = options.qualities;
    if (!options.short_tests.empty())
        choices.short_tests = values_of<lightmesh::ShortTest>(options.short_tests, short_test_names);
    if (!options.map_sizes.empty())
        choices.shadow_map_sizes = options.map_sizes;
    const bool maps_by_default = options.long_tests.empty() && options.map_sizes.empty();
    if (!options.long_tests.empty())
        choices.long_tests = values_of<tune::LongTest>(options.long_tests, long_test_names);
    else if (!options.map_sizes.empty())
        choices.long_tests = {tune::LongTest::rays, tune::LongTest::shadow_maps};
    std::vector<tune::Candidate> candidates = tune::make_candidates(choices);
    if (maps_by_default) {
        choices.radii = {middle_radius};
        choices.long_tests = {tune::LongTest::shadow_maps};
        choices.shadow_map_sizes = {512};
        if (options.short_tests.empty())
            choices.short_tests = {lightmesh::ShortTest::linked};
        const std::vector<tune::Candidate> with_maps = tune::make_candidates(choices);
        candidates.insert(candidates.end(), with_maps.begin(), with_maps.end());
    }
    if (options.caches) {
        tune::Choices caches{.spacings = {0.5f * middle_radius, 0.25f * middle_radius},
                             .shaft_rows = {true, false}};
        if (!options.spacings.empty())
            caches.spacings = options.spacings;
        if (!options.details.empty())
            caches.details = options.details;
        if (!options.lamp_rays.empty())
            caches.lamp_rays = options.lamp_rays;
        if (!options.shaft_rows.empty())
            caches.shaft_rows = values_of<bool>(options.shaft_rows, shaft_row_names);
        const std::vector<tune::Candidate> more = tune::make_candidates(caches);
        candidates.insert(candidates.end(), more.begin(), more.end());
    }
    return candidates;
}

void add_tune_options(CLI::App& program, TuneOptions& options) {
    add_file_options(program, options);
    add_wishes(program, options);
    add_choices(program, options);
    add_measurement(program, options);
    program
        .add_option("--picture-width", options.picture_width, "of the report's pictures in pixels; 0: none")
        ->check(CLI::Range(0, 4096))
        ->capture_default_str();
    program.add_option("-o,--output", options.output,
                       "folder for the report; default: tune- and the scene's name");
    program.add_flag("--resume", options.resume, "take up an interrupted run from the report in the folder");
}

}  // namespace demo
