// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/tune/candidate.hpp>
#include <lightmesh/tune/lamp_reference.hpp>
#include <lightmesh/tune/measure.hpp>
#include <lightmesh/tune/options.hpp>
#include <lightmesh/tune/predict.hpp>
#include <lightmesh/tune/radius.hpp>
#include <lightmesh/tune/recommend.hpp>
#include <lightmesh/tune/reference.hpp>
#include <lightmesh/tune/subject.hpp>

#include <algorithm>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

/// A light mesh of which radius, quality and tests? Or a visibility cache, of which spacing, detail and
/// number of rays? Measured with the user's own tracer, lights and shading points, since what a ray costs
/// decides. Not part of `lightmesh.hpp`.
///
///     using namespace lightmesh;
///     tune::Subject subject{Tracer{...}, lights, tune::Samples{points, normals, points_per_frame}};
///     const tune::RadiusAdvice r = tune::suggest_radii(subject);
///     const auto candidates = tune::make_candidates({.radii = r.radii, .spacings = {0.25f * r.radius}});
///     const tune::Forecast forecast = tune::predict(subject, candidates);        // how long will it take?
///     const tune::Outcome outcome = tune::run(subject, candidates);
///     const auto advice = tune::recommend(outcome.measurements, {.seconds_per_frame = 0.5, .threads = 8});
///     // advice.choice->candidate, tune::to_source(...), advice.reason
///
/// All but times is the same in every run. Nothing here is safe to be used from several threads at once, but
/// the tracer is: the reference may be computed by an `Executor`.

namespace lightmesh::tune {

/// All that a run has measured.
struct Outcome {
    std::vector<Measurement> measurements;  ///< in the order of the candidates
    bool finished = true;                   ///< false if it was cancelled: some are missing
};

namespace detail {

/// Without duplicates, in the same order.
inline std::vector<Candidate> unique_candidates(std::span<const Candidate> candidates) {
    std::vector<Candidate> unique;
    for (const Candidate& candidate : candidates)
        if (std::find(unique.begin(), unique.end(), candidate) == unique.end())
            unique.push_back(candidate);
    return unique;
}

/// As they first appear; caches have 0.
inline std::vector<float> radii_of(std::span<const Candidate> candidates) {
    std::vector<float> radii;
    for (const Candidate& candidate : candidates)
        if (std::find(radii.begin(), radii.end(), radius_of(candidate)) == radii.end())
            radii.push_back(radius_of(candidate));
    return radii;
}

inline float largest_quality(std::span<const Candidate> candidates, float radius) {
    float largest = 1.0f;
    for (const Candidate& candidate : candidates)
        if (!is_cache(candidate) && candidate.radius == radius)
            largest = (std::max)(largest, candidate.quality);
    return largest;
}

/// Throws what `Subject::check` throws, before anything has been measured.
template <class... Adapters>
void check_all(const Subject<Adapters...>& subject, std::span<const Candidate> candidates,
               const Options& options) {
    check_options(options);
    for (const Candidate& candidate : candidates)
        subject.check(candidate, options.base);
}

/// Measures candidates radius by radius, caches by themselves, and adds them to what is measured already.
template <class... Adapters>
class Runner {
public:
    /// Computes nothing yet. `measured` has what is done before.
    Runner(const Subject<Adapters...>& subject, std::span<const Candidate> candidates, const Options& options,
           Reporter& reporter, std::vector<Measurement>& measured)
        : subject_(subject), candidates_(candidates), options_(options), reporter_(reporter),
          measured_(measured) {}

    /// Throws `Cancelled`.
    void run() {
        if (std::ranges::all_of(candidates_, [this](const Candidate& c) { return is_measured(c); }))
            return;
        const ErrorPoints points(subject_, options_.reference_points);
        begin_task("rays to lamps");
        const LampReference lamps(points, subject_, options_, reporter_);
        for (const float radius : radii_of(candidates_)) {
            std::vector<Candidate> missing;
            for (const Candidate& candidate : candidates_)
                if (radius_of(candidate) == radius && !is_measured(candidate))
                    missing.push_back(candidate);
            if (missing.empty())
                continue;
            if (is_cache(missing.front()))
                run_caches(missing, {points, lamps, nullptr});
            else
                run_meshes(missing, radius, points, lamps);
        }
    }

private:
    bool is_measured(const Candidate& candidate) const {
        return std::ranges::find(measured_, candidate, &Measurement::candidate) != measured_.end();
    }

    void begin_task(const std::string& task) {
        reporter_.progress.task = task;
        reporter_.report();
    }

    void run_meshes(std::span<const Candidate> missing, float radius, const ErrorPoints& points,
                    const LampReference& lamps) {
        begin_task("r " + shortest_text(radius) + ", reference");
        const float quality = largest_quality(candidates_, radius);
        const Reference reference(points, subject_, radius, quality, options_, reporter_);
        Candidate sparse = missing.front();
        // Few light points to count, and yet enough to a hemisphere.
        sparse.quality = (std::min)(quality, 2.0f);
        const double growth =
            frame_growth(subject_.lights(), subject_.samples(), settings_of(sparse, options_.base));
        for (const Candidate& candidate : missing)
            add(candidate, {points, lamps, &reference}, growth);
    }

    void run_caches(std::span<const Candidate> missing, const References& references) {
        for (const Candidate& candidate : missing) {
            begin_task(describe(candidate));
            add(candidate, references, record_growth(subject_, candidate, reporter_));
        }
    }

    void add(const Candidate& candidate, const References& references, double growth) {
        begin_task(describe(candidate));
        measured_.push_back(measure(subject_, candidate, references, growth, options_, reporter_));
        ++reporter_.progress.done;
        reporter_.progress.latest = &measured_.back();
        reporter_.report();
        reporter_.progress.latest = nullptr;
    }

    const Subject<Adapters...>& subject_;
    std::span<const Candidate> candidates_;
    const Options& options_;
    Reporter& reporter_;
    std::vector<Measurement>& measured_;
};

/// The measurements of the candidates, in their order.
inline std::vector<Measurement> in_order(std::span<const Candidate> candidates,
                                         std::span<const Measurement> measured) {
    std::vector<Measurement> sorted;
    for (const Candidate& candidate : candidates) {
        const auto found = std::ranges::find(measured, candidate, &Measurement::candidate);
        if (found != measured.end())
            sorted.push_back(*found);
    }
    return sorted;
}

}  // namespace detail

/// The time that `run` will take for these candidates. It runs a pilot: four blocks of the samples with each
/// short and each long test, and a mesh in empty space for each radius and quality. Light points and bytes
/// follow from the latter (above q = 4 by q^3); seconds from the former, as a power of q. The reference is
/// assumed to converge at the first try. Each cache has a pilot of its own.
///
/// Throws what `run` throws, and std::runtime_error if `progress` returns false: then there is no forecast.
template <class... Adapters>
Forecast predict(const Subject<Adapters...>& subject, std::span<const Candidate> candidates,
                 const Options& options = {}, const ProgressCallback& progress = {}) {
    detail::check_all(subject, candidates, options);
    Forecast forecast;
    if (candidates.empty())
        return forecast;
    detail::Reporter reporter(progress);
    reporter.progress.total = candidates.size();
    try {
        detail::Predictor predictor(subject, candidates, options, reporter);
        for (const Candidate& candidate : candidates) {
            reporter.progress.task = "prediction";
            forecast.candidates.push_back(predictor.predict(candidate));
            forecast.seconds += forecast.candidates.back().seconds;
            ++reporter.progress.done;
        }
        forecast.reference_seconds = predictor.lamp_reference_seconds();
        for (const float radius : detail::radii_of(candidates))
            if (radius > 0.0f)
                forecast.reference_seconds +=
                    predictor.reference_seconds(radius, detail::largest_quality(candidates, radius));
    } catch (const detail::Cancelled&) {
        throw std::runtime_error("lightmesh: the prediction was cancelled");
    }
    forecast.seconds += forecast.reference_seconds;
    return forecast;
}

/// Measures every candidate, but those that `done` has already: pass what an earlier run has found (its
/// outcome, or what its callback was shown) to take it up again. A measurement belongs to a candidate if the
/// settings are equal; that subject and options are the same is the caller's business.
///
/// Radius by radius: errors of meshes are held against a reference of the same radius, since a radius is a
/// wish and not an error; those of caches against lamps of 256 rays, and so are those of meshes besides. Give
/// lights their sizes, or the lamps are points. Candidates that appear twice are measured once. Exceptions of
/// the adapters are passed on.
///
/// Throws std::invalid_argument that names the value for options and candidates out of range, and for a
/// candidate that wants a source that the subject does not have; std::out_of_range for samples outside a
/// candidate's grid: all of it before anything is measured.
template <class... Adapters>
Outcome run(const Subject<Adapters...>& subject, std::span<const Candidate> candidates,
            const Options& options = {}, std::span<const Measurement> done = {},
            const ProgressCallback& progress = {}) {
    detail::check_all(subject, candidates, options);
    const std::vector<Candidate> wanted = detail::unique_candidates(candidates);
    std::vector<Measurement> measured = detail::in_order(wanted, done);
    detail::Reporter reporter(progress);
    reporter.progress.done = measured.size();
    reporter.progress.total = wanted.size();
    Outcome outcome;
    try {
        detail::Runner(subject, wanted, options, reporter, measured).run();
    } catch (const detail::Cancelled&) {
        outcome.finished = false;
    }
    outcome.measurements = detail::in_order(wanted, measured);
    return outcome;
}

}  // namespace lightmesh::tune
