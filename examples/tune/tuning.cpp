// SPDX-License-Identifier: MIT
#include "tune/tuning.hpp"

#include "render/depth_renderers.hpp"
#include "render/lamps.hpp"
#include "render/machine.hpp"
#include "render/scene_occluders.hpp"
#include "render/terminal.hpp"
#include "render/text_table.hpp"
#include "tune/plot.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <iostream>
#include <stdexcept>
#include <string>

namespace demo {

namespace tune = lightmesh::tune;

namespace {

tune::Options tuner_options(const TuneOptions& options) {
    tune::Options result;
    result.reference_points = options.reference_points;
    // Longer than the default: other programs may be running beside.
    result.least_seconds = 0.2;
    const int threads = options.render.threads;
    result.executor.threads =
        static_cast<std::size_t>(threads > 0 ? threads : tbb::this_task_arena::max_concurrency());
    result.executor.for_each = [threads](std::size_t count, const std::function<void(std::size_t)>& work) {
        tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
        arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, work); });
    };
    return result;
}

/// The least and the greatest of what candidates are predicted to take.
std::string range_text(const std::vector<tune::Prediction>& predictions,
                       const std::function<std::string(const tune::Prediction&)>& text,
                       double tune::Prediction::*member) {
    const auto [low, high] = std::ranges::minmax_element(predictions, {}, member);
    return text(*low) + " to " + text(*high);
}

std::string light_points_text(const tune::Prediction& p) {
    return grouped(static_cast<unsigned long long>(p.light_points));
}

std::string prediction_bytes_text(const tune::Prediction& p) {
    return megabytes_text(p.bytes);
}

void print_forecast(const tune::Forecast& forecast, std::size_t measured) {
    const std::vector<tune::Prediction>& all = forecast.candidates;
    if (measured > 0)
        std::cout << measured << (measured == 1 ? " candidate" : " candidates") << " measured before\n";
    if (all.empty())
        return;
    std::cout << all.size() << (all.size() == 1 ? " candidate" : " candidates")
              << " to measure, each predicted to hold "
              << range_text(all, light_points_text, &tune::Prediction::light_points)
              << " light points or records in "
              << range_text(all, prediction_bytes_text, &tune::Prediction::bytes) << "\n"
              << "predicted time: about " << fixed(forecast.seconds, 0)
              << " s, references included; Ctrl-C keeps what is done\n"
              << std::flush;
}

/// Leaves out what would not fit this machine, and says so.
void drop_too_big(std::vector<tune::Candidate>& candidates, const tune::Forecast& forecast) {
    for (const tune::Prediction& p : forecast.candidates) {
        if (p.bytes <= 0.5 * physical_memory())
            continue;
        std::erase(candidates, p.candidate);
        std::cout << "left out: " << tune::describe(p.candidate) << " would take " << prediction_bytes_text(p)
                  << ", more than half of this machine's memory\n";
    }
}

/// The share of a run that is done, by predicted seconds.
class Clock {
public:
    explicit Clock(const tune::Forecast& forecast) : forecast_(forecast) {}

    void add(const tune::Candidate& candidate) {
        const auto found = std::ranges::find(forecast_.candidates, candidate, &tune::Prediction::candidate);
        if (found != forecast_.candidates.end())
            seconds_ += found->seconds;
    }

    double share() const {
        const double all = forecast_.seconds - forecast_.reference_seconds;
        return all > 0.0 ? (std::min)(seconds_ / all, 1.0) : 1.0;
    }

private:
    const tune::Forecast& forecast_;
    double seconds_ = 0.0;
};

template <class Subject>
void choose_radii(const Subject& subject, const TuneOptions& options, Tuning& tuning,
                  std::vector<float>& radii) {
    radii = options.radii;
    if (!radii.empty()) {
        tuning.middle_radius = radii[radii.size() / 2];
        return;
    }
    tuning.advice = tune::suggest_radii(subject, options.lamp_angle);
    radii = tuning.advice->radii;
    tuning.middle_radius = tuning.advice->radius;
    std::cout << "radius: at " << grouped(tuning.advice->points) << " points "
              << grouped(tuning.advice->shadowed) << " of " << grouped(tuning.advice->pairs)
              << " pairs of a point and a light are in shadow; lamps of " << options.lamp_angle
              << " rad would throw penumbrae " << fixed(tuning.advice->penumbra_width, 2)
              << " wide: r = " << tune::shortest_text(tuning.middle_radius) << "\n";
    if (tuning.advice->shadowed == 0)
        std::cout << "warning: nothing that this view shows was found in shadow: the radius is a guess, and "
                     "errors say little; --radius sets another one\n";
}

template <class Subject>
Tuning tune_subject(const Subject& subject, const TuneOptions& options,
                    std::span<const tune::Measurement> done, const std::function<void(const Tuning&)>& save) {
    Tuning tuning;
    const tune::Options settings = tuner_options(options);
    std::vector<float> radii;
    choose_radii(subject, options, tuning, radii);
    tuning.shadow_ray_ns_per_point = tune::time_shadow_rays(subject);

    const auto go_on = [](const tune::Progress&) {
        return !interrupted();
    };
    std::vector<tune::Candidate> candidates = choose_candidates(options, radii, tuning.middle_radius);
    std::vector<tune::Candidate> missing;
    for (const tune::Candidate& candidate : candidates) {
        const auto found = std::ranges::find(done, candidate, &tune::Measurement::candidate);
        if (found != done.end())
            tuning.measurements.push_back(*found);
        else
            missing.push_back(candidate);
    }
    const tune::Forecast forecast = tune::predict(subject, missing, settings, go_on);
    tuning.forecast_seconds = forecast.seconds;
    print_forecast(forecast, tuning.measurements.size());
    drop_too_big(candidates, forecast);

    Clock clock(forecast);
    ProgressBar bar("measuring");
    const auto show = [&](const tune::Progress& progress) {
        if (progress.latest != nullptr) {
            clock.add(progress.latest->candidate);
            tuning.measurements.push_back(*progress.latest);
            save(tuning);
        }
        bar.show(clock.share());
        return !interrupted();
    };
    const std::vector<tune::Measurement> before = tuning.measurements;
    tune::Outcome outcome = tune::run(subject, candidates, settings, before, show);
    tuning.measurements = std::move(outcome.measurements);
    tuning.finished = outcome.finished;
    return tuning;
}

bool wants_maps(const TuneOptions& options) {
    return options.long_tests.empty() || std::ranges::any_of(options.long_tests, [](const std::string& name) {
               return name == "maps" || name == "refined-maps";
           });
}

}  // namespace

VisibilityOptions lamp_options(const EmbreeScene& scene, const TuneOptions& options) {
    VisibilityOptions visibility = options.visibility;
    visibility.settings.radius = scene.scene().radius;
    return visibility;
}

Tuning tune_scene(const EmbreeScene& scene, const ShadingPoints& samples, const TuneOptions& options,
                  std::span<const tune::Measurement> done, const std::function<void(const Tuning&)>& save) {
    const std::vector<lightmesh::Light> lights = lamps_of(scene, lamp_options(scene, options));
    std::cout << "lamp radius: " << lamp_size_text(lights) << '\n';
    const tune::Samples points{.points = samples.positions,
                               .normals = samples.normals,
                               .frame_points = samples.all_positions,
                               .frame_normals = samples.all_normals,
                               .footprints = samples.footprints,
                               .frame_footprints = samples.all_footprints};
    const SceneOccluders triangles(scene.scene());
    if (!wants_maps(options))
        return tune_subject(tune::Subject{scene.intersector(), lights, points, triangles}, options, done,
                            save);
    return with_depth_renderer(scene, options.visibility, [&](auto renderer) {
        return tune_subject(
            tune::Subject{scene.intersector(), lights, points, std::move(renderer), triangles}, options, done,
            save);
    });
}

}  // namespace demo
