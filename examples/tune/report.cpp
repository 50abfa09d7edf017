// SPDX-License-Identifier: MIT
#include "tune/report.hpp"

#include "render/lamps.hpp"
#include "render/machine.hpp"
#include "render/text_table.hpp"

#include <algorithm>
#include <iterator>

namespace demo {

namespace tune = lightmesh::tune;

std::vector<std::pair<std::string, std::string>>
describe_context(const EmbreeScene& scene, const ShadingPoints& samples, const TuneOptions& options) {
    std::vector<std::pair<std::string, std::string>> context{
        {"scene", scene.scene().name},
        {"triangles", grouped(scene.scene().triangles.size())},
        {"lights", grouped(scene.scene().lights.size())},
        {"lamp radius", lamp_size_text(lamps_of(scene, lamp_options(scene, options)))},
        {"frame", std::to_string(options.render.width) + " x " + std::to_string(options.render.height)},
        {"points per frame", grouped(samples.all_positions.size())},
        {"points measured", grouped(samples.positions.size())},
        {"points for the error", grouped((std::min)(options.reference_points, samples.positions.size()))},
        {"shadow maps", options.visibility.depth == DepthSource::vulkan ? "Vulkan" : "Embree"}};
    for (auto& line : describe_machine())
        context.push_back(std::move(line));
    return context;
}

std::vector<float> radii_of(const Report& report) {
    std::vector<float> radii;
    for (const tune::Measurement& m : report.tuning.measurements)
        if (std::ranges::find(radii, tune::radius_of(m.candidate)) == radii.end())
            radii.push_back(tune::radius_of(m.candidate));
    return radii;
}

void judge(Report& report) {
    const auto& measurements = report.tuning.measurements;
    tune::Wishes wishes = report.wishes;
    wishes.threads = report.threads;
    report.frontier = tune::pareto_frontier(measurements, wishes.frame);
    wishes.radius = report.tuning.middle_radius;
    report.recommended = tune::recommend(measurements, wishes);
    report.by_radius.clear();
    wishes.radius.reset();
    for (const float radius : radii_of(report)) {
        std::vector<tune::Measurement> of_radius;
        std::ranges::copy_if(
            measurements, std::back_inserter(of_radius),
            [radius](const tune::Measurement& m) { return tune::radius_of(m.candidate) == radius; });
        report.by_radius.push_back(tune::recommend(of_radius, wishes));
    }
}

}  // namespace demo
