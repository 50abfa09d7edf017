// SPDX-License-Identifier: MIT
#include "render/commands.hpp"
#include "render/files.hpp"
#include "render/options.hpp"
#include "render/run.hpp"
#include "render/terminal.hpp"
#include "tune/options.hpp"
#include "tune/pictures.hpp"
#include "tune/report.hpp"
#include "tune/report_html.hpp"
#include "tune/sampling.hpp"
#include "tune/tuning.hpp"

#include <tbb/task_arena.h>

#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <vector>

namespace {

using namespace demo;

void print_recommendation(const Report& report) {
    const lightmesh::tune::Recommendation& recommended = report.recommended;
    if (recommended.choice)
        std::cout << "\n    " << lightmesh::tune::to_source(recommended.choice->candidate) << "\n\n";
    std::cout << recommended.reason << '\n';
}

/// The program's exit status.
int tune_and_report(const TuneOptions& options) {
    const Scene scene = show_scene(options);
    for (const float radius : options.radii)
        check_radius(radius, scene);
    const std::filesystem::path folder = options.output.empty() ? "tune-" + scene.name : options.output;
    const std::filesystem::path json_file = folder / "report.json";
    if (options.resume && !std::filesystem::exists(json_file))
        throw std::runtime_error("there is nothing to resume: no file " + json_file.string());
    prepare_folder(folder);
    const EmbreeScene embree(scene);
    const ShadingPoints samples = sample_shading_points(embree, options.render, options.points);

    Report report;
    report.scene = scene.name;
    report.triangle_count = scene.triangles.size();
    report.light_count = scene.lights.size();
    report.context = describe_context(embree, samples, options);
    report.threads =
        options.render.threads > 0 ? options.render.threads : tbb::this_task_arena::max_concurrency();
    report.wishes = options.wishes;
    std::vector<lightmesh::tune::Measurement> done;
    if (options.resume)
        done = measurements_from_json(json_file, report);
    const auto save = [&](const Tuning& tuning) {
        report.tuning = tuning;
        judge(report);
        write_file(json_file, to_json(report));
    };
    save(tune_scene(embree, samples, options, done, save));
    if (!report.tuning.finished) {
        std::cerr << "interrupted: " << report.tuning.measurements.size() << " measurements are in "
                  << json_file.string() << "; --resume takes them up\n";
        return exit_interrupted;
    }
    print_recommendation(report);
    std::optional<ReportPictures> pictures;
    if (options.picture_width > 0)
        pictures = render_pictures(embree, options, report, folder / "pictures");
    const std::filesystem::path html_file = folder / "report.html";
    write_file(html_file, to_html(report, pictures));
    std::cout << "report: " << html_file.string() << " and, for scripts, " << json_file.string() << '\n';
    return report.recommended.choice ? 0 : 3;
}

}  // namespace

int main(int argument_count, char** arguments) {
    CLI::App program(
        "Finds, by measuring, whether a light mesh or a visibility cache suits a scene, and its settings.",
        "lightmesh-tune");
    program.footer(
        "Where an option shows ..., its values have commas between them: -q 2,3,4.\n"
        "Exit status: 0, or 3 if no candidate keeps to the limits, 130 after Ctrl-C, 1 and 2 for errors.");
    TuneOptions options;
    add_tune_options(program, options);
    try {
        program.parse(argument_count, arguments);
        return tune_and_report(options);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0)
            return program.exit(error);
        std::cerr << "lightmesh-tune: " << error.what() << " (see --help)\n";
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "lightmesh-tune: " << error.what() << '\n';
        return interrupted() ? exit_interrupted : 1;
    }
}
