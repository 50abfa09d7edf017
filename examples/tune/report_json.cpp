// SPDX-License-Identifier: MIT
#include "render/files.hpp"
#include "tune/report.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

namespace demo {

namespace tune = lightmesh::tune;

namespace {

using Json = nlohmann::ordered_json;

/// Of this file's layout.
constexpr int format_number = 3;

constexpr std::array short_tests{lightmesh::ShortTest::none, lightmesh::ShortTest::linked,
                                 lightmesh::ShortTest::exact};
constexpr std::array long_tests{tune::LongTest::rays, tune::LongTest::shadow_maps,
                                tune::LongTest::refined_shadow_maps, tune::LongTest::shadow_volumes};

/// 0.3f as 0.3: the double that is nearest to the shortest text of the float gives the same float again.
double readable(float value) {
    return std::strtod(tune::shortest_text(value).c_str(), nullptr);
}

template <class Value, class Values>
Value named(const Json& name, const Values& values) {
    for (const Value value : values)
        if (name == tune::name_of(value))
            return value;
    throw std::runtime_error("unknown name " + name.dump());
}

Json to_json_value(const tune::Candidate& c) {
    return {{"radius", readable(c.radius)},
            {"quality", readable(c.quality)},
            {"short_test", tune::name_of(c.short_test)},
            {"long_test", tune::name_of(c.long_test)},
            {"shadow_map_size", c.shadow_map_size},
            {"spacing", readable(c.spacing)},
            {"detail", c.detail},
            {"lamp_rays", c.lamp_rays},
            {"shaft_rows", c.shaft_rows}};
}

tune::Candidate candidate_from(const Json& json) {
    return {json.at("radius").get<float>(),
            json.at("quality").get<float>(),
            named<lightmesh::ShortTest>(json.at("short_test"), short_tests),
            named<tune::LongTest>(json.at("long_test"), long_tests),
            json.at("shadow_map_size").get<int>(),
            json.at("spacing").get<float>(),
            json.at("detail").get<int>(),
            json.at("lamp_rays").get<int>(),
            json.at("shaft_rows").get<bool>()};
}

/// Calls visit(name, member) for all members of a measurement but candidate, reference and frame.
template <class Measurement, class Visitor>
void for_each_number(Measurement& m, Visitor&& visit) {
    visit("points", m.points);
    visit("points_per_frame", m.points_per_frame);
    visit("cold_ns_per_point", m.cold_ns_per_point);
    visit("warm_ns_per_point", m.warm_ns_per_point);
    visit("setup_seconds", m.setup_seconds);
    visit("short_rays_per_point", m.short_rays_per_point);
    visit("long_rays", m.long_rays);
    visit("link_rays", m.link_rays);
    visit("light_points", m.light_points);
    visit("bytes", m.bytes);
    visit("mean_absolute_error", m.mean_absolute_error);
    visit("rms_error", m.rms_error);
    visit("lamp_error", m.lamp_error);
}

template <class Measurement, class Visitor>
void for_each_reference_number(Measurement& m, Visitor&& visit) {
    visit("quality", m.reference.quality);
    visit("change", m.reference.change);
    visit("converged", m.reference.converged);
}

template <class Measurement, class Visitor>
void for_each_frame_number(Measurement& m, Visitor&& visit) {
    visit("light_points", m.frame.light_points);
    visit("bytes", m.frame.bytes);
    visit("cold_seconds", m.frame.cold_seconds);
    visit("warm_seconds", m.frame.warm_seconds);
}

Json to_json_value(const tune::Measurement& m) {
    Json json;
    json["candidate"] = to_json_value(m.candidate);
    const auto writer = [](Json& target) {
        return [&target](const char* name, const auto& value) {
            target[name] = value;
        };
    };
    for_each_number(m, writer(json));
    for_each_reference_number(m, writer(json["reference"]));
    for_each_frame_number(m, writer(json["frame"]));
    return json;
}

tune::Measurement measurement_from(const Json& json) {
    tune::Measurement m;
    m.candidate = candidate_from(json.at("candidate"));
    const auto reader = [](const Json& source) {
        return [&source](const char* name, auto& value) {
            const Json& number = source.at(name);
            number.get_to(value);
            if (number.is_number() && !(number.get<double>() >= 0.0))
                throw std::runtime_error(std::string(name) + " is " + number.dump() +
                                         "; it must not be negative");
        };
    };
    for_each_number(m, reader(json));
    for_each_reference_number(m, reader(json.at("reference")));
    for_each_frame_number(m, reader(json.at("frame")));
    return m;
}

Json context_of(const Report& report) {
    Json context;
    for (const auto& [name, value] : report.context)
        context[name] = value;
    return context;
}

Json to_json_value(const tune::Wishes& wishes) {
    return {{"ns_per_point", wishes.ns_per_point},
            {"seconds_per_frame", wishes.seconds_per_frame},
            {"mean_absolute_error", wishes.mean_absolute_error},
            {"bytes", wishes.bytes},
            {"frame", wishes.frame == tune::Frame::first ? "first" : "later"}};
}

Json to_json_value(const tune::Recommendation& recommendation) {
    Json json;
    json["reason"] = recommendation.reason;
    if (recommendation.choice) {
        json["candidate"] = to_json_value(recommendation.choice->candidate);
        json["settings"] = tune::to_source(recommendation.choice->candidate);
    }
    if (recommendation.other)
        json["held_against"] = to_json_value(recommendation.other->candidate);
    return json;
}

/// The library starts its messages with a tag in brackets.
std::string without_tag(const std::string& message) {
    const std::size_t end = message.starts_with("[json.") ? message.find("] ") : std::string::npos;
    return end == std::string::npos ? message : message.substr(end + 2);
}

/// Throws std::runtime_error that names the first difference.
void require_same(const Json& earlier, const Json& current) {
    for (const auto& [name, value] : current.items())
        if (!earlier.contains(name) || earlier.at(name) != value)
            throw std::runtime_error("its " + name + " was " +
                                     (earlier.contains(name) ? earlier.at(name).dump() : "not told") +
                                     " and is " + value.dump() + " now");
}

}  // namespace

std::string to_json(const Report& report) {
    Json json;
    json["format"] = format_number;
    json["finished"] = report.tuning.finished;
    json["context"] = context_of(report);
    json["threads"] = report.threads;
    json["wishes"] = to_json_value(report.wishes);
    if (const auto& advice = report.tuning.advice)
        json["radius_advice"] = {{"radius", readable(advice->radius)},
                                 {"penumbra_width", advice->penumbra_width},
                                 {"points", advice->points},
                                 {"pairs", advice->pairs},
                                 {"shadowed", advice->shadowed}};
    json["shadow_ray_ns_per_point"] = report.tuning.shadow_ray_ns_per_point;
    json["forecast_seconds"] = report.tuning.forecast_seconds;
    json["recommended"] = to_json_value(report.recommended);
    for (const tune::Recommendation& recommendation : report.by_radius)
        json["recommended_by_radius"].push_back(to_json_value(recommendation));
    json["measurements"] = Json::array();
    const auto& measurements = report.tuning.measurements;
    for (std::size_t i = 0; i < measurements.size(); ++i) {
        json["measurements"].push_back(to_json_value(measurements[i]));
        json["measurements"].back()["on_frontier"] =
            std::ranges::find(report.frontier, i) != report.frontier.end();
    }
    return json.dump(1) + "\n";
}

std::vector<tune::Measurement> measurements_from_json(const std::filesystem::path& file,
                                                      const Report& current) {
    const std::string text = read_file(file);
    try {
        const Json json = Json::parse(text);
        if (json.at("format") != format_number)
            throw std::runtime_error("it has format " + json.at("format").dump() + ", not " +
                                     std::to_string(format_number));
        require_same(json.at("context"), context_of(current));
        std::vector<tune::Measurement> measurements;
        for (const Json& one : json.at("measurements"))
            measurements.push_back(measurement_from(one));
        return measurements;
    } catch (const std::exception& error) {
        throw std::runtime_error("cannot resume from " + file.string() + ": " + without_tag(error.what()));
    }
}

}  // namespace demo
