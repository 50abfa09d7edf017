// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/shadow_rays.hpp>
#include <lightmesh/tune/candidate.hpp>
#include <lightmesh/tune/frame_growth.hpp>
#include <lightmesh/tune/lamp_reference.hpp>
#include <lightmesh/tune/measure.hpp>
#include <lightmesh/tune/options.hpp>
#include <lightmesh/tune/subject.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <span>
#include <utility>
#include <variant>
#include <vector>

/// The time that a run will take, from a pilot of a few hundred points and a mesh in empty space.

namespace lightmesh::tune {

/// The time that measuring a candidate is expected to take, within a factor of about two: for a progress bar,
/// and for deciding whether to start at all.
struct Prediction {
    Candidate candidate;  ///< what is going to be measured
    /// Of a cache: records. An upper bound for `linked`, which leaves out what is behind walls.
    double light_points = 0.0;
    double bytes = 0.0;    ///< while it is measured; everything is freed afterwards
    double seconds = 0.0;  ///< to measure it
};

/// The time that a run is expected to take.
struct Forecast {
    std::vector<Prediction> candidates;  ///< in the order of the candidates
    double reference_seconds = 0.0;      ///< for all references, on the executor's threads
    double seconds = 0.0;                ///< for everything
};

namespace detail {

/// The cost of queries as a power of q, through two measured values.
struct PowerLaw {
    double quality = 1.0;
    double seconds = 0.0;
    double exponent = 0.0;

    PowerLaw() = default;
    PowerLaw(double q1, double t1, double q2, double t2)
        : quality(q1), seconds(t1),
          exponent(q2 > q1 && t1 > 0.0 && t2 > t1 ? std::log(t2 / t1) / std::log(q2 / q1) : 0.0) {}

    double at(double q) const { return seconds * std::pow(q / quality, exponent); }
};

/// A few blocks of the samples, spread evenly, as samples of their own.
class PilotSamples {
public:
    PilotSamples(const Samples& samples, std::size_t most_blocks) {
        const std::size_t count = samples.points.size();
        const std::size_t blocks = (count + block_size - 1) / block_size;
        const std::size_t chosen = (std::min)(most_blocks, blocks);
        for (std::size_t b = 0; b < chosen; ++b) {
            const std::size_t first = b * blocks / chosen * block_size;
            const std::size_t last = (std::min)(first + block_size, count);
            for (std::size_t i = first; i < last; ++i) {
                points_.push_back(samples.points[i]);
                normals_.push_back(samples.normals[i]);
                if (!samples.footprints.empty())
                    footprints_.push_back(samples.footprints[i]);
            }
        }
    }
    Samples samples() const {
        return {.points = points_,
                .normals = normals_,
                .points_per_frame = points_.size(),
                .footprints = footprints_};
    }

private:
    std::vector<glm::vec3> points_;
    std::vector<glm::vec3> normals_;
    std::vector<float> footprints_;
};

/// The measurements of a pilot with one mesh or cache.
struct PilotTiming {
    double setup_seconds = 0.0;  ///< making the mesh, and its shadow maps
    double fill_seconds = 0.0;   ///< per light point, or record
    double warm_seconds = 0.0;   ///< per surface point
    double light_points = 0.0;   ///< or records, per surface point
    double bytes = 0.0;          ///< per light point, or record
};

template <class... Adapters>
PilotTiming time_pilot(const Subject<Adapters...>& subject, const Samples& pilot, const Candidate& candidate,
                       const Options& options, Reporter& reporter) {
    PilotTiming result;
    RendererCost rendering;
    const Watch watch;
    const auto count = static_cast<double>(pilot.points.size());
    const auto time = [&](const auto& queries) {
        const double made = watch.seconds();
        const Timing timing = time_queries(queries, pilot.points.size(), rendering, 0.0, reporter);
        const auto held = static_cast<double>(timing.held.light_points);
        result.setup_seconds = made + timing.setup_seconds;
        result.warm_seconds = timing.warm_seconds / count;
        result.fill_seconds = timing.seconds_per_light_point;
        result.light_points = held / count;
        result.bytes = held > 0.0 ? static_cast<double>(timing.held.bytes) / held : 0.0;
    };
    if (is_cache(candidate))
        subject.with_cache(candidate, subject.lights().size(),
                           [&](const auto& cache) { time(CacheQueries(cache, pilot)); });
    else
        subject.with_mesh(candidate, options.base, rendering,
                          [&](const auto& mesh) { time(MeshQueries(mesh, pilot)); });
    return result;
}

/// Pictures that shadow maps of all lights consist of, at most.
inline double count_shadow_maps(std::span<const Light> lights) {
    double count = 0.0;
    for (const Light& light : lights)
        count +=
            std::holds_alternative<PointLight>(light) || std::holds_alternative<RectLight>(light) ? 6.0 : 1.0;
    return count;
}

/// Predicts candidates one by one; measures what it lacks when it is first needed.
template <class... Adapters>
class Predictor {
public:
    Predictor(const Subject<Adapters...>& subject, std::span<const Candidate> candidates,
              const Options& options, Reporter& reporter)
        : subject_(subject), options_(options), reporter_(reporter), pilot_(subject.samples(), 4) {
        bool is_first = true;
        for (const Candidate& candidate : candidates) {
            if (is_cache(candidate))
                continue;
            lowest_ = is_first ? candidate.quality : (std::min)(lowest_, candidate.quality);
            highest_ = is_first ? candidate.quality : (std::max)(highest_, candidate.quality);
            is_first = false;
        }
    }

    Prediction predict(const Candidate& candidate) {
        return is_cache(candidate) ? predict_cache(candidate) : predict_mesh(candidate);
    }

    /// Of the rays to lamps.
    double lamp_reference_seconds() {
        const Samples pilot = pilot_.samples();
        const ShadowRays rays(subject_.lights(), subject_.resolution());
        const Watch watch;
        for (std::size_t i = 0; i < pilot.points.size(); ++i)
            rays.for_each(pilot.points[i], pilot.normals[i], [&](std::size_t, const Segment& segment) {
                static_cast<void>(subject_.tracer().occluded(segment));
            });
        const auto points =
            static_cast<double>((std::min)(options_.reference_points, subject_.samples().points.size()));
        return watch.seconds() / static_cast<double>(pilot.points.size()) * points *
               static_cast<double>(LampReference::ray_count) / static_cast<double>(options_.executor.threads);
    }
    /// Of a reference of meshes whose q reaches 2 * `quality`, at most 16.
    double reference_seconds(float radius, float quality) {
        const Samples& samples = subject_.samples();
        const auto points = static_cast<double>((std::min)(options_.reference_points, samples.points.size()));
        const double share = points / static_cast<double>(samples.points.size());
        const double coarse = (std::min)(static_cast<double>(quality), 8.0);
        double sum = 0.0;
        for (const double q : {coarse, 2.0 * coarse}) {
            // Hemispheres hardly share light points here: (2/3) pi q^3 each.
            const double light_points = points * 2.0944 * q * q * q;
            const Candidate rays{radius, quality, ShortTest::exact, LongTest::rays, 0};
            sum += light_points * long_test(rays).fill_seconds +
                   share * static_cast<double>(samples.points.size()) * warm(ShortTest::exact, radius).at(q);
        }
        return sum / static_cast<double>(options_.executor.threads);
    }

private:
    /// As if no two blocks shared a record, which few do. Counting the records of a frame takes as long as
    /// all of its points with four lights.
    Prediction predict_cache(const Candidate& candidate) {
        Prediction result{candidate};
        const PilotTiming pilot = time(candidate);
        const auto count = static_cast<double>(subject_.samples().points.size());
        result.light_points = pilot.light_points * count;
        result.bytes = pilot.bytes * result.light_points;
        const double pass = count * pilot.warm_seconds;
        const double warm_passes =
            (std::max)(1.0, std::ceil(options_.least_seconds / (std::max)(pass, 1e-9)));
        const double share = (std::min)(1.0, 4.0 / static_cast<double>(subject_.lights().size()));
        const auto frame = static_cast<double>(subject_.samples().frame_points.size());
        const double counting = share * (pilot.warm_seconds + pilot.fill_seconds) * frame;
        result.seconds = pilot.setup_seconds + result.light_points * pilot.fill_seconds +
                         pass * (1.0 + warm_passes) + counting;
        return result;
    }

    Prediction predict_mesh(const Candidate& candidate) {
        Prediction result{candidate};
        const DryRun& dry = open_space(candidate.radius, candidate.quality);
        const double scale =
            std::pow(static_cast<double>(candidate.quality) / dry_quality(candidate.quality), 3.0);
        result.light_points = static_cast<double>(dry.light_points) * scale;
        result.bytes = static_cast<double>(dry.bytes) * scale;
        if (uses_shadow_maps(candidate.long_test))
            result.bytes += count_shadow_maps(subject_.lights()) * sizeof(float) *
                            std::pow(static_cast<double>(candidate.shadow_map_size), 2.0);
        const PilotTiming& filling = long_test(candidate);
        const double pass =
            static_cast<double>(subject_.samples().points.size()) *
            warm(candidate.short_test, candidate.radius).at(static_cast<double>(candidate.quality));
        const double warm_passes =
            (std::max)(1.0, std::ceil(options_.least_seconds / (std::max)(pass, 1e-9)));
        result.seconds =
            filling.setup_seconds + result.light_points * filling.fill_seconds + pass * (1.0 + warm_passes);
        return result;
    }

    /// The quality that stands for another in empty space: light points fill a volume.
    static double dry_quality(float quality) { return (std::min)(static_cast<double>(quality), 4.0); }

    const DryRun& open_space(float radius, float quality) {
        const double q = dry_quality(quality);
        const auto key = std::pair(radius, q);
        auto found = open_space_.find(key);
        if (found == open_space_.end()) {
            reporter_.report();
            const Candidate candidate{radius, static_cast<float>(q), ShortTest::none, LongTest::rays, 0};
            found =
                open_space_
                    .emplace(key, dry_run(subject_.lights(), subject_.samples().points,
                                          subject_.samples().normals, settings_of(candidate, options_.base)))
                    .first;
        }
        return found->second;
    }

    const PilotTiming& long_test(const Candidate& candidate) {
        const auto key = std::pair(candidate.long_test, candidate.shadow_map_size);
        auto found = long_tests_.find(key);
        if (found == long_tests_.end()) {
            Candidate pilot = candidate;
            pilot.quality = lowest_;
            pilot.short_test = ShortTest::none;
            found = long_tests_.emplace(key, time(pilot)).first;
        }
        return found->second;
    }

    const PowerLaw& warm(ShortTest short_test, float radius) {
        auto found = warm_.find(short_test);
        if (found == warm_.end()) {
            const Candidate low{radius, lowest_, short_test, LongTest::rays, 0};
            const Candidate high{radius, highest_, short_test, LongTest::rays, 0};
            const double low_seconds = time(low).warm_seconds;
            const double high_seconds = highest_ > lowest_ ? time(high).warm_seconds : low_seconds;
            PowerLaw law(static_cast<double>(lowest_), low_seconds, static_cast<double>(highest_),
                         high_seconds);
            // One quality alone says nothing about others: rays go with the light points.
            if (highest_ == lowest_ && short_test == ShortTest::exact)
                law.exponent = 3.0;
            found = warm_.emplace(short_test, law).first;
        }
        return found->second;
    }

    PilotTiming time(const Candidate& candidate) {
        reporter_.report();
        return time_pilot(subject_, pilot_.samples(), candidate, options_, reporter_);
    }

    const Subject<Adapters...>& subject_;
    const Options& options_;
    Reporter& reporter_;
    PilotSamples pilot_;
    float lowest_ = 1.0f;
    float highest_ = 1.0f;
    std::map<std::pair<float, double>, DryRun> open_space_;
    std::map<std::pair<LongTest, int>, PilotTiming> long_tests_;
    std::map<ShortTest, PowerLaw> warm_;
};

}  // namespace detail

}  // namespace lightmesh::tune
