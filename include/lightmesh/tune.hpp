// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/tune/candidate.hpp>
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
#include <vector>

/// Which radius, which quality, which tests? Measured with the user's own tracer, lights and shading points,
/// since what a ray costs decides. Not part of `lightmesh.hpp`.
///
///     using namespace lightmesh;
///     tune::Subject subject{Tracer{...}, lights, tune::Samples{points, normals, points_per_frame}};
///     const auto candidates = tune::make_candidates({.radii = tune::suggest_radii(subject).radii});
///     const tune::Forecast forecast = tune::predict(subject, candidates);        // how long will it take?
///     const tune::Outcome outcome = tune::run(subject, candidates);
///     const auto advice = tune::recommend(outcome.measurements, {.seconds_per_frame = 0.5, .threads = 8});
///     // advice.choice->candidate, tune::to_source(...), advice.reason
///
/// All but times is the same in every run. Nothing here is safe to be used from several threads at once, but
/// the tracer is: the reference may be computed by an `Executor`.

namespace lightmesh::tune {

/// What a run has measured.
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

inline std::vector<float> radii_of(std::span<const Candidate> candidates) {
    std::vector<float> radii;
    for (const Candidate& candidate : candidates)
        if (std::find(radii.begin(), radii.end(), candidate.radius) == radii.end())
            radii.push_back(candidate.radius);
    return radii;
}

inline float largest_quality(std::span<const Candidate> candidates, float radius) {
    float largest = 1.0f;
    for (const Candidate& candidate : candidates)
        if (candidate.radius == radius)
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

/// Measures the candidates of one radius that are not measured yet, and adds them. Throws `Cancelled`.
template <class... Adapters>
void run_radius(const Subject<Adapters...>& subject, std::span<const Candidate> candidates, float radius,
                const Options& options, Reporter& reporter, std::vector<Measurement>& measured) {
    std::vector<Candidate> missing;
    for (const Candidate& candidate : candidates)
        if (candidate.radius == radius &&
            std::ranges::find(measured, candidate, &Measurement::candidate) == measured.end())
            missing.push_back(candidate);
    if (missing.empty())
        return;
    reporter.progress.task = "r " + shortest(radius) + ", reference";
    reporter.report();
    const Reference reference(subject, radius, largest_quality(candidates, radius), options, reporter);
    Candidate sparse = missing.front();
    // Few light points to count, and yet enough to a hemisphere.
    sparse.quality = (std::min)(largest_quality(candidates, radius), 2.0f);
    const double growth =
        frame_growth(subject.lights(), subject.samples(), settings_of(sparse, options.base));
    for (const Candidate& candidate : missing) {
        reporter.progress.task = describe(candidate);
        reporter.report();
        measured.push_back(measure(subject, candidate, reference, growth, options, reporter));
        ++reporter.progress.done;
        reporter.progress.latest = &measured.back();
        reporter.report();
        reporter.progress.latest = nullptr;
    }
}

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

/// What `run` will take for these candidates. It runs a pilot: four blocks of the samples with each short and
/// each long test, and a mesh in empty space for each radius and quality. Light points and bytes follow from
/// the latter (above q = 4 by q^3); seconds from the former, as a power of q. The reference is assumed to
/// converge at the first try.
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
        for (const float radius : detail::radii_of(candidates))
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
/// Radius by radius: errors are held against a reference of the same radius, since a radius is a wish and not
/// an error. Candidates that appear twice are measured once. Exceptions of the adapters are passed on.
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
        for (const float radius : detail::radii_of(wanted))
            detail::run_radius(subject, wanted, radius, options, reporter, measured);
    } catch (const detail::Cancelled&) {
        outcome.finished = false;
    }
    outcome.measurements = detail::in_order(wanted, measured);
    return outcome;
}

}  // namespace lightmesh::tune
