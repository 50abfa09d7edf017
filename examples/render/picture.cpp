// SPDX-License-Identifier: MIT
#include "render/commands.hpp"
#include "render/options.hpp"
#include "render/run.hpp"

#include <iostream>
#include <memory>

namespace demo {

namespace {

struct PictureOptions : CommonOptions {
    std::string algorithm = "linked";
    std::string output;
    std::string exr;
};

int make_picture(const PictureOptions& options) {
    const std::filesystem::path scene_name = options.scene;
    const std::filesystem::path output =
        options.output.empty() ? scene_name.stem().string() + ".png" : options.output;
    prepare_picture(output);
    if (!options.exr.empty())
        prepare_file(options.exr);
    const Scene scene = show_scene(options);
    const EmbreeScene embree(scene);
    const Run made = run(options.algorithm, embree, visibility_options(options, scene), options.render);
    if (!made.statistics.finished && std::filesystem::exists(output)) {
        std::cerr << "interrupted: " << output.string() << " stays as it was\n";
        return exit_interrupted;
    }
    write_image(made.image, output);
    std::cout << report(made, embree) << "picture: " << output.string() << '\n';
    if (!options.exr.empty() && made.statistics.finished) {
        write_exr(made.image, options.exr);
        std::cout << "picture: " << options.exr << '\n';
    }
    if (!made.statistics.finished)
        std::cerr << "interrupted: the picture is not finished\n";
    return made.statistics.finished ? 0 : exit_interrupted;
}

}  // namespace

void add_picture_command(CLI::App& program, int& status) {
    const auto options = std::make_shared<PictureOptions>();
    CLI::App* command = program.add_subcommand("picture", "render one picture");
    add_scene_options(*command, *options);
    command->add_option("-a,--algorithm", options->algorithm, "how shadows are found")
        ->check(CLI::IsMember(algorithm_names()))
        ->capture_default_str();
    command->add_option("-o,--output", options->output, "PNG or EXR; default: the scene's name and .png");
    command->add_option("--exr", options->exr, "also write the linear values as an EXR file");
    add_render_options(*command, *options);
    command->callback([options, &status] { status = make_picture(*options); });
}

}  // namespace demo
