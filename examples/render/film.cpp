// SPDX-License-Identifier: MIT
#include "scene/film.hpp"

#include "render/commands.hpp"
#include "render/frame_folder.hpp"
#include "render/lamps.hpp"
#include "render/movie.hpp"
#include "render/options.hpp"
#include "render/run.hpp"
#include "render/saved_mesh.hpp"
#include "render/terminal.hpp"
#include "render/text_table.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace demo {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int most_frames = 1000000;

struct FilmOptions : CommonOptions {
    std::string algorithm = "cache";
    std::string output;
    std::string format = "png";
    std::optional<int> frames;
    double fps = 24.0;
    double from = 0.0;
    std::optional<double> to;
    std::vector<std::string> moving{"objects", "lights", "camera"};
    bool overwrite = false;
};

/// The times of the frames.
struct Schedule {
    double from;
    double step;  ///< between frames, in seconds of the scene
    int frames;

    double time(int frame) const { return from + step * (frame - 1); }
};

/// Where the frames go, and the film if one is wanted.
struct Output {
    std::filesystem::path frames;
    std::filesystem::path movie;  ///< empty: frames only
};

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string exactly(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
}

std::string exactly(const glm::vec3& v) {
    const auto text = [](float value) {
        return exactly(static_cast<double>(value));
    };
    return text(v.x) + "," + text(v.y) + "," + text(v.z);
}

/// Frames are 1 / fps apart, or spread evenly where both their number and the end are given.
Schedule schedule_of(const FilmOptions& options, double length) {
    const double to = options.to.value_or(length);
    if (options.frames && !options.to)
        return {options.from, 1.0 / options.fps, *options.frames};
    if (!(to > options.from))
        throw std::invalid_argument("--from " + exactly(options.from) + " is not before " +
                                    (options.to ? "--to " : "the end of the animation, ") + exactly(to));
    if (options.frames)
        return {options.from, (to - options.from) / *options.frames, *options.frames};
    const double frames = std::round((to - options.from) * options.fps);
    if (frames > most_frames)
        throw std::invalid_argument("a film of " + exactly(frames) +
                                    " frames is too long; at most there are " + std::to_string(most_frames));
    return {options.from, 1.0 / options.fps, (std::max)(1, static_cast<int>(frames))};
}

Output output_of(const FilmOptions& options) {
    const std::filesystem::path scene = options.scene;
    const std::filesystem::path output =
        options.output.empty() ? scene.stem().string() + "-film" : options.output;
    if (output.extension() == ".png" || output.extension() == ".exr")
        throw std::invalid_argument(
            "--output " + output.string() +
            " is one picture; a film goes into a folder, or a file that ends in .mp4");
    if (output.extension() != ".mp4")
        return {output, {}};
    if (options.format != "png")
        throw std::invalid_argument("an MP4 film is made of PNG files, not of " + options.format);
    require_ffmpeg();
    prepare_file(output);
    return {output.parent_path() / (output.stem().string() + "-frames"), output};
}

Moving moving_of(const FilmOptions& options) {
    const auto has = [&](const char* part) {
        return std::ranges::count(options.moving, part) > 0;
    };
    return {has("objects"), has("lights"), has("camera")};
}

/// All that decides how frames look: with the same of these, a frame is the same to the last bit. `film` is
/// at 0 s.
FilmTraits traits_of(const FilmOptions& options, const VisibilityOptions& visibility, const Film& film,
                     const Schedule& schedule) {
    const Scene& scene = film.scene();
    const RenderOptions& render = options.render;
    const lightmesh::CacheSettings cache = cache_settings_of(visibility);
    const auto number_of = [](float value) {
        return exactly(static_cast<double>(value));
    };
    char scene_sum[24];
    std::snprintf(scene_sum, sizeof scene_sum, "%016llx",
                  static_cast<unsigned long long>(look_fingerprint(scene)));
    std::string moves;
    for (const auto& [name, does] : {std::pair("objects", film.moving().objects),
                                     {"lights", film.moving().lights},
                                     {"camera", film.moving().camera}})
        moves += does ? (moves.empty() ? "" : ",") + std::string(name) : "";
    const bool by_maps = options.algorithm.starts_with("shadow-map") || options.algorithm.ends_with("+map");
    return {{"scene", scene.name + " " + scene_sum},
            {"animation", options.import.animation.empty() ? "the first" : options.import.animation},
            {"length", exactly(film.length())},
            {"moving", moves.empty() ? "nothing" : moves},
            {"from", exactly(schedule.from)},
            {"seconds between frames", exactly(schedule.step)},
            {"algorithm", options.algorithm},
            {"width", std::to_string(render.width)},
            {"height", std::to_string(render.height)},
            {"samples", std::to_string(render.samples)},
            {"depth limit", std::to_string(render.depth_limit)},
            {"format", options.format},
            {"tone", render.tone == Tone::filmic ? "filmic" : "linear"},
            {"exposure", number_of(scene.exposure)},
            {"ambient", exactly(scene.ambient)},
            {"eye at 0 s", exactly(scene.camera.eye)},
            {"target at 0 s", exactly(scene.camera.target)},
            {"up at 0 s", exactly(scene.camera.up)},
            {"angle of view", number_of(scene.camera.vertical_field_of_view)},
            {"radius", number_of(visibility.settings.radius)},
            {"quality", number_of(visibility.settings.quality)},
            {"short test", options.short_test},
            {"spacing", number_of(cache.spacing)},
            {"detail", std::to_string(cache.detail)},
            {"lamp rays", std::to_string(cache.lamp_rays)},
            {"light size", visibility.light_size > 0.0f ? number_of(visibility.light_size) : "the scene's"},
            {"area samples", std::to_string(visibility.area_samples)},
            {"map size", std::to_string(visibility.settings.shadow_map_size)},
            {"maps",
             by_maps ? options.depth + (visibility.settings.refine_shadow_maps ? ", refined" : "") : "none"}};
}

/// "2 min 10 s"
std::string duration_text(double seconds) {
    const auto whole = static_cast<long long>(std::ceil(seconds));
    if (whole < 60)
        return std::to_string(whole) + " s";
    if (whole < 3600)
        return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
    return std::to_string(whole / 3600) + " h " + std::to_string(whole % 3600 / 60) + " min";
}

/// Renders frames of a film one after another, and keeps count.
class FilmMaker {
public:
    FilmMaker(const FilmOptions& options, Film film, const VisibilityOptions& visibility)
        : options_(options), film_(std::move(film)), visibility_(visibility),
          // Built at 0 s, so that the tree is one and the same wherever a film begins.
          embree_(film_.scene(),
                  film_.moving().objects ? EmbreeScene::For::films : EmbreeScene::For::stills) {}

    /// The frame at a time; nothing if the user has stopped it.
    std::optional<Image> frame(double time, const Progress& progress) {
        const auto start = Clock::now();
        go_to(time);
        seconds_between_ += seconds_since(start);
        RenderStatistics spent;
        Image image = render(embree_, *shadows_, options_.render, spent, progress, &interrupted());
        if (!spent.finished)
            return std::nullopt;
        spent_ += spent;
        last_seconds_ = seconds_since(start);
        (made_ == 0 ? first_seconds_ : later_seconds_) += last_seconds_;
        ++made_;
        return image;
    }

    double last_seconds() const { return last_seconds_; }

    std::string report() const {
        const Scene& scene = film_.scene();
        TextTable table;
        table.add_row({"algorithm", options_.algorithm});
        table.add_row({"triangles", grouped(scene.triangles.size())});
        table.add_row({"lights", grouped(scene.lights.size())});
        table.add_row({"radius r", number(visibility_.settings.radius)});
        table.add_row({"quality q", number(visibility_.settings.quality)});
        table.add_row({"spacing g", number(cache_settings_of(visibility_).spacing)});
        table.add_row({"lamp radius", lamp_size_text(lamps_of(embree_, visibility_))});
        table.add_row({"frames rendered", grouped(static_cast<unsigned long long>(made_))});
        if (made_ == 0)
            return table.text();
        table.add_rule();
        table.add_row({"seconds: BVH", fixed(embree_.seconds_building(), 3)});
        table.add_row({"seconds: first frame", fixed(first_seconds_, 3)});
        table.add_row(
            {"seconds: each frame after it", made_ > 1 ? fixed(later_seconds_ / (made_ - 1), 3) : "-"});
        table.add_row({"seconds: poses and updates, each frame", fixed(seconds_between_ / made_, 3)});
        table.add_row({"  of all threads: rays to surfaces", fixed(spent_.seconds_tracing, 3)});
        table.add_row({"  of all threads: shadows", fixed(spent_.visibility.seconds, 3)});
        table.add_row({"  of all threads: shading", fixed(spent_.seconds_shading, 3)});
        return table.text();
    }

private:
    void go_to(double time) {
        const SceneChange change = film_.go_to(time);
        embree_.update(change);
        if (shadows_)
            shadows_->update(embree_, change);
        else
            shadows_ = make_visibility(options_.algorithm, embree_, visibility_);
    }

    const FilmOptions& options_;
    Film film_;
    VisibilityOptions visibility_;
    EmbreeScene embree_;
    std::unique_ptr<Visibility> shadows_;
    RenderStatistics spent_;
    int made_ = 0;
    double first_seconds_ = 0.0;
    double later_seconds_ = 0.0;
    double last_seconds_ = 0.0;
    double seconds_between_ = 0.0;
};

void write_frame(const FilmOptions& options, Image image, const std::filesystem::path& file) {
    write_image(options.format == "png" ? toned(std::move(image), options.render.tone) : image, file);
}

/// Renders the frames that are not there; false if the user has stopped it.
bool make_frames(const FilmOptions& options, const Schedule& schedule, const FrameFolder& folder,
                 FilmMaker& maker) {
    std::vector<int> missing;
    for (int number = 1; number <= schedule.frames; ++number)
        if (!folder.has(number))
            missing.push_back(number);
    const int kept = schedule.frames - static_cast<int>(missing.size());
    if (kept > 0)
        std::cout << kept << " of " << schedule.frames << " frames are there already and stay\n"
                  << std::flush;
    ProgressBar bar(options.algorithm);
    for (std::size_t i = 0; i < missing.size(); ++i) {
        const auto show = [&](double done) {
            const double frames_left = static_cast<double>(missing.size() - i) - done;
            const std::string place =
                "frame " + std::to_string(missing[i]) + " of " + std::to_string(schedule.frames);
            bar.show(1.0 - frames_left / static_cast<double>(missing.size()),
                     i == 0 ? place
                            : place + ", " + duration_text(frames_left * maker.last_seconds()) + " left");
        };
        std::optional<Image> image = maker.frame(schedule.time(missing[i]), show);
        if (!image)
            return false;
        write_frame(options, std::move(*image), folder.frame(missing[i]));
    }
    return true;
}

int make_film(const FilmOptions& options) {
    static_cast<void>(interrupted());  // from now on Ctrl-C lets a frame be written
    const Output output = output_of(options);
    Film film = open_film(options, moving_of(options));
    for (const std::string& remark : film.scene().remarks)
        std::cout << "note: " << remark << '\n';
    const Schedule schedule = schedule_of(options, film.length());
    const VisibilityOptions visibility = visibility_options(options, film.scene());
    const FrameFolder folder(output.frames, "." + options.format, options.render.width,
                             options.render.height);
    folder.claim(traits_of(options, visibility, film, schedule), options.overwrite);
    FilmMaker maker(options, std::move(film), visibility);
    const bool is_whole = make_frames(options, schedule, folder, maker);
    std::cout << maker.report();
    if (is_whole && !output.movie.empty())
        write_movie(folder.pattern(), schedule.frames, options.fps, output.movie);
    std::cout << "frames: " << output.frames.string() << '\n';
    if (!is_whole) {
        std::cerr << "interrupted: whole frames stay; the same command goes on with the others\n";
        return exit_interrupted;
    }
    if (!output.movie.empty())
        std::cout << "film: " << output.movie.string() << '\n';
    return 0;
}

void add_time_options(CLI::App& command, FilmOptions& options) {
    command.add_option("--frames", options.frames, "how many; default: up to --to")
        ->check(CLI::Range(1, most_frames));
    command.add_option("--fps", options.fps, "frames a second")
        ->check(finite_range(0.0f, 1000.0f))
        ->check(finite_positive)
        ->capture_default_str();
    command.add_option("--from", options.from, "where the film begins, in seconds of the scene")
        ->check(finite_range(0.0f, 1e9f))
        ->capture_default_str();
    command
        .add_option("--to", options.to,
                    "where it ends; default: with the animation, or after --frames; with --frames these are "
                    "spread over the time, faster or slower than it")
        ->check(finite_range(0.0f, 1e9f));
    command.add_option("--moving", options.moving, "what moves: objects, lights, camera; default: all")
        ->delimiter(',')
        ->check(CLI::IsMember({"objects", "lights", "camera"}));
}

}  // namespace

void add_film_command(CLI::App& program, int& status) {
    const auto options = std::make_shared<FilmOptions>();
    CLI::App* command = program.add_subcommand(
        "film", "render a film of park, rooms, spheres, or of a glTF file with an animation");
    // What rays miss flickers where something moves, as it does not in a still picture.
    options->visibility.cache.lamp_rays = 256;
    add_scene_options(*command, *options);
    command->add_option("-a,--algorithm", options->algorithm, "how shadows are found")
        ->check(CLI::IsMember(algorithm_names()))
        ->capture_default_str();
    add_time_options(*command, *options);
    command->add_option(
        "-o,--output", options->output,
        "a folder for numbered frames, or an MP4 file, with its frames in a folder beside it; "
        "default: the scene's name and -film");
    command->add_option("--format", options->format, "of the frames: png, or exr with linear values")
        ->check(CLI::IsMember({"png", "exr"}))
        ->capture_default_str();
    command->add_flag("--overwrite", options->overwrite,
                      "render all frames, where otherwise those of the same film that are there stay");
    add_render_options(*command, *options);
    add_tone_option(*command, *options);
    command->callback([options, &status] { status = make_film(*options); });
}

}  // namespace demo
