// SPDX-License-Identifier: MIT
#include "render/commands.hpp"
#include "render/files.hpp"
#include "render/options.hpp"
#include "render/run.hpp"
#include "render/text_table.hpp"

#include <algorithm>
#include <iostream>
#include <memory>

namespace demo {

namespace {

struct CompareOptions : CommonOptions {
    std::vector<std::string> algorithms{"cache", "whitted", "area", "linked"};
    std::string reference = "area";
    std::string output;
    float amplification = 8.0f;
    bool exr = false;
};

std::vector<std::string> with_reference(const CompareOptions& options) {
    std::vector<std::string> names;
    for (const std::string& name : options.algorithms)
        if (std::ranges::find(names, name) == names.end())
            names.push_back(name);
    if (std::ranges::find(names, options.reference) == names.end())
        names.push_back(options.reference);
    return names;
}

/// Rays whose results are kept for other points.
std::string rays_that_stay(const Run& made) {
    if (made.mesh)
        return grouped(made.mesh->kept_rays());
    if (made.cache)
        return grouped(made.cache->kept_rays());
    return "-";
}

std::string comparison_table(const std::vector<Run>& runs, const Run& reference, const EmbreeScene& scene) {
    TextTable table;
    table.add_row({"algorithm", "seconds", "shadows: s of all threads", "ns per point and light",
                   "rays from points", "rays kept", "memory", "mean abs. difference", "RMS difference"});
    table.add_rule();
    for (const Run& made : runs) {
        const VisibilityCost& cost = made.statistics.visibility;
        const auto pairs = static_cast<double>(made.statistics.shading_points) *
                           static_cast<double>(scene.scene().lights.size());
        table.add_row({made.algorithm, fixed(made.seconds(), 2), fixed(cost.seconds, 2),
                       pairs > 0.0 ? fixed(1e9 * cost.seconds / pairs, 2) : "-",
                       grouped(made.cache ? made.cache->point_rays : cost.shadow_rays + cost.short_rays),
                       rays_that_stay(made), bytes_text(made.bytes),
                       fixed(mean_absolute_difference(made.image, reference.image), 5),
                       fixed(rms_difference(made.image, reference.image), 5)});
    }
    return "scene " + scene.scene().name + ": " + grouped(scene.scene().triangles.size()) + " triangles, " +
           grouped(scene.scene().lights.size()) + " lights, r " + number(reference.settings.radius) + ", q " +
           number(reference.settings.quality) + ", g " + number(reference.spacing) +
           (reference.shaft_rows ? "" : " without shaft rows") + ", lamp radius " + reference.lamp_sizes +
           ", " + grouped(reference.statistics.shading_points) + " surface points; BVH in " +
           fixed(scene.seconds_building(), 2) + " s; differences are to " + reference.algorithm + "\n" +
           table.text();
}

std::string caption_of(const Run& made, const Run& reference) {
    return made.algorithm + ": " + fixed(made.seconds(), 2) + " s, shadows " +
           fixed(made.statistics.visibility.seconds, 2) + " s of all threads\ndifference to " +
           reference.algorithm + " " + fixed(mean_absolute_difference(made.image, reference.image), 5);
}

/// Writes all pictures, their differences and a sheet of them.
void write_comparison(const std::vector<Run>& runs, const Run& reference, const CompareOptions& options) {
    const std::filesystem::path folder = options.output;
    std::vector<CaptionedImage> pictures;
    std::vector<CaptionedImage> differences;
    for (const Run& made : runs) {
        const Image picture = toned(made.image, options.render.tone);
        write_png(picture, folder / (made.algorithm + ".png"));
        if (options.exr)
            write_exr(made.image, folder / (made.algorithm + ".exr"));
        pictures.push_back({picture, caption_of(made, reference)});
        if (&made == &reference)
            continue;
        Image difference =
            difference_picture(picture, toned(reference.image, options.render.tone), options.amplification);
        write_png(difference, folder / (made.algorithm + "-difference.png"));
        differences.push_back(
            {std::move(difference), made.algorithm + " - " + reference.algorithm + ", times " +
                                        fixed(static_cast<double>(options.amplification), 0) + ", negated"});
    }
    write_png(side_by_side(pictures), folder / "sheet.png");
    if (!differences.empty())
        write_png(side_by_side(differences), folder / "differences.png");
}

int compare(const CompareOptions& options) {
    prepare_folder(options.output);
    const Scene scene = show_scene(options);
    const EmbreeScene embree(scene);
    const VisibilityOptions visibility = visibility_options(options, scene);
    std::vector<Run> runs;
    for (const std::string& name : with_reference(options)) {
        runs.push_back(run(name, embree, visibility, options.render));
        if (!runs.back().statistics.finished) {
            for (const Run& made : runs)
                if (made.statistics.finished)
                    write_png(toned(made.image, options.render.tone),
                              std::filesystem::path(options.output) / (made.algorithm + ".png"));
            std::cerr << "interrupted: the " << runs.size() - 1 << " pictures that were finished are in "
                      << options.output << '\n';
            return exit_interrupted;
        }
    }
    const Run& reference = *std::ranges::find(runs, options.reference, &Run::algorithm);
    write_comparison(runs, reference, options);
    const std::string table = comparison_table(runs, reference, embree);
    write_file(std::filesystem::path(options.output) / "table.txt", table);
    std::cout << table << "pictures: " << options.output << "/sheet.png, differences.png and one by one\n";
    return 0;
}

}  // namespace

void add_compare_command(CLI::App& program, int& status) {
    const auto options = std::make_shared<CompareOptions>();
    CLI::App* command = program.add_subcommand("compare", "render one view by several algorithms");
    add_scene_options(*command, *options);
    const CLI::IsMember known(algorithm_names());
    command->add_option("-a,--algorithms", options->algorithms, "with commas between them")
        ->delimiter(',')
        ->check(known)
        ->capture_default_str();
    command->add_option("--reference", options->reference, "what the others are compared with")
        ->check(known)
        ->capture_default_str();
    command->add_option("-o,--output", options->output, "folder for all files")->required();
    command->add_option("--amplify", options->amplification, "how much differences are amplified")
        ->check(CLI::Range(1.0f, 1000.0f))
        ->capture_default_str();
    command->add_flag("--exr", options->exr, "also write the linear values as EXR files");
    add_render_options(*command, *options);
    add_tone_option(*command, *options);
    command->callback([options, &status] { status = compare(*options); });
}

}  // namespace demo
