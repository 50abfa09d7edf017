// SPDX-License-Identifier: MIT
#include "render/commands.hpp"
#include "render/on_gpu.hpp"
#include "render/open_scene.hpp"
#include "render/options.hpp"
#include "render/ranks.hpp"
#include "render/run.hpp"
#include "render/saved_mesh.hpp"

#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace demo {

namespace {

struct PictureOptions : CommonOptions {
    std::string algorithm = "cache";
    std::string output;
    std::string exr;
    std::string mesh;
    std::string saved_mesh;
    std::string on = "cpu";
};

/// Says which option of meshes does not fit the algorithm.
void check_mesh_options(const PictureOptions& options) {
    for (const auto& [name, file] : {std::pair("--mesh", options.mesh), {"--save-mesh", options.saved_mesh}})
        if (!file.empty() && !keeps_snapshot(options.algorithm))
            throw std::invalid_argument(
                std::string(name) + " is for cache, lmm, linked and express, not for " + options.algorithm);
}

void prepare_files(const PictureOptions& options, const std::filesystem::path& output) {
    prepare_picture(output);
    if (!options.exr.empty())
        prepare_file(options.exr);
    if (!options.saved_mesh.empty())
        prepare_file(options.saved_mesh);
}

/// Throws std::runtime_error if another rank would render another picture: of another file, say.
void check_same_scene(Ranks& ranks, const Scene& scene) {
    const std::vector<Bytes> sums = ranks.gather(bytes_of(look_fingerprint(scene)));
    for (std::size_t rank = 1; rank < sums.size(); ++rank)
        if (sums[rank] != sums[0])
            throw std::runtime_error("rank " + std::to_string(rank) + " of " + std::to_string(sums.size()) +
                                     " has another scene than rank 0");
}

int make_picture(const PictureOptions& options, Ranks& ranks) {
    const std::filesystem::path scene_name = options.scene;
    const std::filesystem::path output =
        options.output.empty() ? scene_name.stem().string() + ".png" : options.output;
    check_mesh_options(options);
    check_on_options(options.on, options.visibility);
    if (ranks.is_first())
        prepare_files(options, output);
    const Scene scene = ranks.is_first() ? show_scene(options) : open_scene(options);
    check_same_scene(ranks, scene);
    VisibilityOptions visibility = visibility_options(options, scene);
    if (!options.mesh.empty())
        visibility.known = load_mesh(options.mesh, scene);
    visibility.keep_snapshot = !options.saved_mesh.empty();
    const EmbreeScene embree(scene);
    const Run made = options.on == "gpu"
                         ? run_on_gpu(options.algorithm, embree, visibility, options.render, ranks)
                         : run(options.algorithm, embree, visibility, options.render, ranks);
    if (!ranks.is_first())
        return 0;
    // Also of a picture that is not finished: what was found is worth as much.
    if (!options.saved_mesh.empty())
        save_mesh(options.saved_mesh, made.snapshot, scene);
    if (!made.statistics.finished && std::filesystem::exists(output)) {
        std::cerr << "interrupted: " << output.string() << " stays as it was\n";
        return exit_interrupted;
    }
    if (output.extension() != ".png")
        write_image(made.image, output);
    else
        write_image(options.on == "gpu" ? made.toned : toned(made.image, options.render.tone), output);
    std::cout << report(made, embree) << "picture: " << output.string() << '\n';
    if (!options.saved_mesh.empty())
        std::cout << "saved: " << options.saved_mesh << '\n';
    if (!options.exr.empty() && made.statistics.finished) {
        write_exr(made.image, options.exr);
        std::cout << "picture: " << options.exr << '\n';
    }
    if (!made.statistics.finished)
        std::cerr << "interrupted: the picture is not finished\n";
    return made.statistics.finished ? 0 : exit_interrupted;
}

}  // namespace

void add_picture_command(CLI::App& program, Ranks& ranks, int& status) {
    const auto options = std::make_shared<PictureOptions>();
    CLI::App* command = program.add_subcommand("picture", "render one picture");
    add_scene_options(*command, *options);
    command->add_option("-a,--algorithm", options->algorithm, "how shadows are found")
        ->check(CLI::IsMember(algorithm_names()))
        ->capture_default_str();
    command->add_option("-o,--output", options->output, "PNG or EXR; default: the scene's name and .png");
    command->add_option("--exr", options->exr, "also write the linear values as an EXR file");
    command->add_option(
        "--mesh", options->mesh,
        "begin with what --save-mesh has written, of the same algorithm, scene, lamps, r, q and g");
    command->add_option("--save-mesh", options->saved_mesh,
                        "write the cache or the light mesh to a file (cache, lmm, linked, express)");
    add_on_options(*command, options->on, options->visibility);
    add_render_options(*command, *options);
    add_tone_option(*command, *options);
    command->callback([options, &ranks, &status] { status = make_picture(*options, ranks); });
}

}  // namespace demo
