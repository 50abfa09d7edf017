// SPDX-License-Identifier: MIT
#include "scene/film.hpp"

#include "image/image.hpp"
#include "render/commands.hpp"
#include "render/files.hpp"
#include "render/film_maker.hpp"
#include "render/frame_folder.hpp"
#include "render/movie.hpp"
#include "render/on_gpu.hpp"
#include "render/options.hpp"
#include "render/ranks.hpp"
#include "render/run.hpp"
#include "render/runs.hpp"
#include "render/saved_mesh.hpp"
#include "render/share_out.hpp"
#include "render/stopwatch.hpp"
#include "render/terminal.hpp"
#include "render/text_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace demo {

namespace {

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
    std::optional<float> memory;  ///< of a mesh or a cache, in MB
    std::string on = "cpu";
};

/// The times of the frames.
struct Schedule {
    double from;
    double step;  ///< between frames, in seconds of the scene
    int frames;

    double time(int frame) const { return from + step * (frame - 1); }
};

/// Of so many MB; what is more than there can be is no limit.
std::size_t bytes_of_memory(float megabytes) {
    constexpr std::size_t most = (std::numeric_limits<std::size_t>::max)();
    const double bytes = 1e6 * static_cast<double>(megabytes);
    return bytes < static_cast<double>(most) ? static_cast<std::size_t>(bytes) : most;
}

/// The folder where the frames go, and the film if one is wanted.
struct Output {
    std::filesystem::path frames;
    std::filesystem::path movie;  ///< empty: frames only
};

std::string coordinates(const glm::vec3& v) {
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
/// at 0 s; `gpu` may be null.
FilmTraits traits_of(const FilmOptions& options, const VisibilityOptions& visibility, const Film& film,
                     const Schedule& schedule, const GpuFrames* gpu) {
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
            {"rendered on", gpu != nullptr ? gpu->device() : "the CPU"},
            {"width", std::to_string(render.width)},
            {"height", std::to_string(render.height)},
            {"samples", std::to_string(render.samples)},
            {"depth limit", std::to_string(render.depth_limit)},
            {"format", options.format},
            {"tone", render.tone == Tone::filmic ? "filmic" : "linear"},
            {"exposure", number_of(scene.exposure)},
            {"ambient", coordinates(scene.ambient)},
            {"eye at 0 s", coordinates(scene.camera.eye)},
            {"target at 0 s", coordinates(scene.camera.target)},
            {"up at 0 s", coordinates(scene.camera.up)},
            {"angle of view", number_of(scene.camera.vertical_field_of_view)},
            {"radius", number_of(visibility.settings.radius)},
            {"quality", number_of(visibility.settings.quality)},
            {"short test", options.short_test},
            {"spacing", number_of(cache.spacing)},
            {"detail", std::to_string(cache.detail)},
            {"lamp rays", std::to_string(cache.lamp_rays)},
            {"shaft rows", cache.shaft_rows ? "yes" : "no"},
            {"exact edges", cache.exact_edges ? "yes" : "no"},
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

/// The progress of a film, on the screen of rank 0. May be used by several threads.
class FilmProgress {
public:
    /// `there`: how many frames are there already; `frames`: how many are missing.
    FilmProgress(const std::string& caption, std::size_t there, std::size_t frames,
                 ProgressBar::Elsewhere elsewhere)
        : bar_(caption, elsewhere), there_(there), frames_(frames) {}

    /// While a frame is rendered: the share of it that is done.
    void show(double part) {
        const std::scoped_lock lock(guard_);
        const double done = static_cast<double>(done_) + part;
        const double left = static_cast<double>(frames_) - done;
        const std::string place = "frame " + std::to_string(there_ + (std::min)(done_ + 1, frames_)) +
                                  " of " + std::to_string(there_ + frames_);
        bar_.show(done / static_cast<double>(frames_),
                  done_ == 0 ? place : place + ", " + duration_text(left * seconds_of_frame()) + " left");
    }
    void add_frame() {
        {
            const std::scoped_lock lock(guard_);
            if (++done_ == 1)
                seconds_of_first_ = watch_.seconds();
        }
        show(0.0);
    }

private:
    /// The first frame is the dearest: others are taken for a measure as soon as there are some.
    double seconds_of_frame() const {
        if (done_ == 1)
            return seconds_of_first_;
        return (watch_.seconds() - seconds_of_first_) / static_cast<double>(done_ - 1);
    }

    ProgressBar bar_;
    std::size_t there_;
    std::size_t frames_;
    std::size_t done_ = 0;
    std::mutex guard_;
    Stopwatch watch_;
    double seconds_of_first_ = 0.0;
};

/// Rank 0's, on all.
std::vector<int> shared(Ranks& ranks, const std::vector<int>& mine) {
    Bytes bytes(mine.size() * sizeof(int));
    std::memcpy(bytes.data(), mine.data(), bytes.size());
    bytes = ranks.broadcast(std::move(bytes));
    std::vector<int> numbers(bytes.size() / sizeof(int));
    std::memcpy(numbers.data(), bytes.data(), bytes.size());
    return numbers;
}

/// Makes the frames of a film that are not there yet, with all ranks.
class FilmJob {
public:
    /// `folder` and `progress` on rank 0 only.
    FilmJob(Ranks& ranks, const FilmOptions& options, const Schedule& schedule, FilmMaker& maker,
            const FrameFolder* folder, FilmProgress* progress)
        : ranks_(ranks), options_(options), schedule_(schedule), maker_(maker), folder_(folder),
          progress_(progress) {}

    /// In batches: what ranks find in one, all know in the next.
    void make(std::span<const int> frames) {
        const auto ranks = static_cast<std::size_t>(ranks_.size());
        const std::size_t most = ranks == 1 ? frames.size() : batch_per_rank * ranks;
        // All ranks make cold frames together, but not on GPUs: there each begins with one of its own.
        std::size_t size = ranks > 1 && maker_.is_on_gpu() ? (std::min)(most, ranks) : most;
        for (std::size_t first = 0; first < frames.size(); first += std::exchange(size, most)) {
            if (first > 0)
                maker_.merge_at(schedule_.time(frames[first]));
            make_batch(frames.subspan(first, (std::min)(size, frames.size() - first)));
        }
    }

private:
    static constexpr std::size_t batch_per_rank = 16;

    /// A frame that turns out to be cold although those around it were not, such as the first one after a
    /// cut, waits until the others are done: then all ranks make it together, as the key frame of a batch.
    void make_batch(std::span<const int> frames) {
        std::vector<int> others(frames.begin(), frames.end());
        bool may_wait = false;
        if (ranks_.size() > 1 && !maker_.is_on_gpu()) {
            const KeyFrames keys = make_key_frames(frames);
            for (const int frame : keys.made)
                std::erase(others, frame);
            may_wait = !keys.are_cold;
        }
        const auto show_alone = [&](double part) {
            if (ranks_.size() == 1)
                show(part);
        };
        const auto work = [&](std::size_t i, WorkWatch& watch) {
            auto made = maker_.frame(schedule_.time(others[i]), watch, may_wait, show_alone);
            return made ? encode(std::move(*made)) : Bytes{};
        };
        std::vector<int> waiting;
        share_out(ranks_, others.size(), work, [&](std::size_t i, int, const Bytes& file) {
            if (file.empty())
                waiting.push_back(others[i]);
            else
                write(others[i], file);
        });
        if (!may_wait)
            return;
        std::ranges::sort(waiting);
        waiting = shared(ranks_, waiting);
        if (waiting.empty())
            return;
        maker_.merge_at(schedule_.time(waiting.front()));
        make_batch(waiting);
    }

    struct KeyFrames {
        std::vector<int> made;
        bool are_cold;  ///< the last ones still
    };

    /// Frames that are far from each other, each by all ranks together, until none of a step is cold: so all
    /// ranks begin warm where they go on alone, and nobody traces what another one traces.
    KeyFrames make_key_frames(std::span<const int> frames) {
        std::vector<int> made;
        for (const std::vector<std::size_t>& step : key_steps(frames.size(), ranks_.size())) {
            bool is_cold = false;
            for (const std::size_t i : step) {
                const double time = schedule_.time(frames[i]);
                FilmMaker::TogetherMade frame = maker_.frame_together(time, [&](double part) { show(part); });
                if (ranks_.is_first())
                    write(frames[i], encode({std::move(frame.image), {}}));
                is_cold = is_cold || frame.is_cold;
                made.push_back(frames[i]);
            }
            if (!is_cold)
                return {made, false};
        }
        return {made, true};
    }

    /// The rank where the frame was rendered: rank 0 has enough to do with files.
    Bytes encode(FilmMaker::Made made) const {
        if (options_.format != "png")
            return bytes_of_text(encoded(made.linear, ".exr"));
        if (made.toned.pixels.empty())
            made.toned = toned(std::move(made.linear), options_.render.tone);
        return bytes_of_text(encoded(made.toned, ".png"));
    }

    void write(int frame, const Bytes& file) {
        write_file(folder_->frame(frame), text_in(file));
        progress_->add_frame();
    }

    void show(double part) {
        if (progress_ != nullptr)
            progress_->show(part);
    }

    Ranks& ranks_;
    const FilmOptions& options_;
    const Schedule& schedule_;
    FilmMaker& maker_;
    const FrameFolder* folder_;
    FilmProgress* progress_;
};

std::vector<int> missing_frames(const FrameFolder& folder, const Schedule& schedule) {
    std::vector<int> missing;
    for (int number = 1; number <= schedule.frames; ++number)
        if (!folder.has(number))
            missing.push_back(number);
    const int kept = schedule.frames - static_cast<int>(missing.size());
    if (kept > 0)
        std::cout << kept << " of " << schedule.frames << " frames are there already and stay\n"
                  << std::flush;
    return missing;
}

/// Throws std::runtime_error if another rank would render other frames: of another file, say.
void check_same_film(Ranks& ranks, const FilmTraits& traits) {
    const std::vector<Bytes> texts = ranks.gather(bytes_of_text(text_of(traits)));
    for (std::size_t rank = 1; rank < texts.size(); ++rank)
        if (const std::string differing = differences(text_in(texts[rank]), traits); !differing.empty())
            throw std::runtime_error("rank " + std::to_string(rank) + " of " + std::to_string(texts.size()) +
                                     " has another film than rank 0: " + differing);
}

int make_film(const FilmOptions& options, Ranks& ranks) {
    static_cast<void>(interrupted());  // from now on Ctrl-C lets a frame be written
    check_on_options(options.on, options.visibility);
    const bool is_first = ranks.is_first();
    const Output output = is_first ? output_of(options) : Output{};
    Film film = open_film(options, moving_of(options));
    if (is_first)
        for (const std::string& remark : film.scene().remarks)
            std::cout << "note: " << remark << '\n';
    const Schedule schedule = schedule_of(options, film.length());
    VisibilityOptions visibility = visibility_options(options, film.scene());
    if (options.memory)
        visibility.settings.memory_budget = visibility.cache.memory_budget = bytes_of_memory(*options.memory);
    std::unique_ptr<GpuFrames> gpu;
    if (options.on == "gpu")
        gpu = std::make_unique<GpuFrames>(options.algorithm, visibility, options.render);
    const FilmTraits traits = traits_of(options, visibility, film, schedule, gpu.get());
    check_same_film(ranks, traits);
    std::optional<FrameFolder> folder;
    std::vector<int> missing;
    if (is_first) {
        folder.emplace(output.frames, "." + options.format, options.render.width, options.render.height);
        folder->claim(traits, options.overwrite);
        missing = missing_frames(*folder, schedule);
    }
    missing = shared(ranks, missing);
    FilmMaker maker(ranks, options.algorithm, options.render, std::move(film), visibility, std::move(gpu));
    std::optional<std::string> why_not_whole;
    try {
        std::optional<FilmProgress> progress;
        if (is_first)
            progress.emplace(options.algorithm, static_cast<std::size_t>(schedule.frames) - missing.size(),
                             missing.size(), progress_elsewhere(ranks));
        FilmJob(ranks, options, schedule, maker, folder ? &*folder : nullptr, progress ? &*progress : nullptr)
            .make(missing);
    } catch (const Interrupted& interrupt) {
        if (!is_first)
            throw;
        why_not_whole = interrupt.what();
    }
    const std::string report = maker.report(!why_not_whole);
    if (!is_first)
        return 0;
    if (why_not_whole) {
        // At once: who has started the ranks gives them a second to end.
        std::cerr << "interrupted: whole frames stay; the same command goes on with the others"
                  << (ranks.size() > 1 ? " (" + *why_not_whole + ")" : "") << std::endl;
    }
    std::cout << report;
    if (!why_not_whole && !output.movie.empty())
        write_movie(folder->pattern(), schedule.frames, options.fps, output.movie);
    std::cout << "frames: " << output.frames.string() << '\n';
    if (why_not_whole)
        return exit_interrupted;
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

void add_film_command(CLI::App& program, Ranks& ranks, int& status) {
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
    command
        ->add_option("--memory", options->memory,
                     "MB that the cache, or the mesh, of each rank may take: what has gone unused the "
                     "longest is forgotten between frames; default: no limit")
        ->check(finite_positive);
    add_on_options(*command, options->on, options->visibility);
    command->add_flag("--overwrite", options->overwrite,
                      "render all frames, where otherwise those of the same film that are there stay");
    add_render_options(*command, *options);
    add_tone_option(*command, *options);
    command->callback([options, &ranks, &status] { status = make_film(*options, ranks); });
}

}  // namespace demo
