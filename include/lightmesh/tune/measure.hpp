// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/shadow_rays.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/tune/candidate.hpp>
#include <lightmesh/tune/frame_growth.hpp>
#include <lightmesh/tune/lamp_reference.hpp>
#include <lightmesh/tune/options.hpp>
#include <lightmesh/tune/reference.hpp>
#include <lightmesh/tune/subject.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace lightmesh::tune {

/// The time that a whole frame would take, from the samples: one thread, `Samples::points_per_frame` points.
/// An estimate.
///
/// What is paid per surface point grows with their number, what is paid per light point with the number of
/// light points, and shadow maps are rendered once. Light points grow slower than surface points, since
/// neighbours share them: by as much as is counted in empty space with `Samples::frame_points`, at a q of 2
/// at most; without these as max * n / (n + half), which is fitted to a half and all of the samples. Of a
/// cache the same holds for records, which are counted with four of the lights.
struct FrameEstimate {
    double light_points = 0.0;  ///< that the mesh holds; of a cache: records
    double bytes = 0.0;         ///< mesh and shadow maps, or cache
    double cold_seconds = 0.0;  ///< the first frame, which fills the mesh or the cache
    double warm_seconds = 0.0;  ///< a frame that finds all it needs there
};

/// The cost of a candidate, and its error. Times are of one thread, but that a `DepthRenderer` may use
/// more.
struct Measurement {
    Candidate candidate;               ///< what was measured
    std::size_t points = 0;            ///< surface points queried, each once in each pass
    std::size_t points_per_frame = 0;  ///< as the samples had it
    double cold_ns_per_point = 0.0;    ///< from an empty mesh, all that fills it included
    double warm_ns_per_point = 0.0;    ///< all lights, the mesh being filled
    double setup_seconds = 0.0;        ///< of the cold time what is paid once: mostly shadow maps
    /// From points, which nothing keeps: to light points or lattice points, and to lights where these say
    /// nothing. Of the pass that fills mesh or cache.
    double short_rays_per_point = 0.0;
    std::uint64_t long_rays = 0;   ///< for V(L, x), or from records to lamps; all samples together
    std::uint64_t link_rays = 0;   ///< between light points, or lattice points, and to find records; the same
    std::size_t light_points = 0;  ///< that the mesh holds in the end; of a cache: records
    std::size_t bytes = 0;         ///< of the mesh or the cache in the end
    /// Mean absolute difference of S to the reference, over pairs of a point and a light that can reach it:
    /// of a mesh to a converged one of the same radius, of a cache to lamps of 256 rays.
    double mean_absolute_error = 0.0;
    double rms_error = 0.0;  ///< root mean square of the same
    /// Mean absolute difference of S to lamps of 256 rays, also of a mesh: what tells mesh and cache apart.
    double lamp_error = 0.0;
    Convergence reference;  ///< what the first two errors are held against
    FrameEstimate frame;    ///< the same for a whole frame
};

namespace detail {

/// The contents of a mesh or a cache, and the rays that it took.
struct Held {
    std::size_t light_points = 0;  ///< of a cache: records
    std::size_t bytes = 0;
    std::uint64_t long_rays = 0;
    std::uint64_t link_rays = 0;
    std::uint64_t point_rays = 0;  ///< of a cache; those of meshes are in `QueryStatistics`
};

/// The samples, as a light mesh is asked for them.
template <class Mesh>
class MeshQueries {
public:
    MeshQueries(const Mesh& mesh, const Samples& samples) : mesh_(mesh), samples_(samples) {}

    std::size_t light_count() const { return mesh_.light_count(); }
    /// All lights at `size` points from the `first` on. Rays from points count in `cost`, if it is not null.
    void query(std::size_t first, std::size_t size, std::span<float> all, QueryStatistics* cost) const {
        mesh_.visibility(samples_.points.subspan(first, size), samples_.normals.subspan(first, size), all,
                         cost);
    }
    Held held() const {
        const MeshStatistics now = mesh_.statistics();
        return {now.light_points, now.bytes, now.long_rays, now.link_rays, 0};
    }

private:
    const Mesh& mesh_;
    const Samples& samples_;
};

/// The same of a cache.
template <class Cache>
class CacheQueries {
public:
    CacheQueries(const Cache& cache, const Samples& samples)
        : CacheQueries(cache, samples.points, samples.normals, samples.footprints) {}
    CacheQueries(const Cache& cache, std::span<const glm::vec3> points, std::span<const glm::vec3> normals,
                 std::span<const float> footprints)
        : cache_(cache), points_(surface_points(points, normals, footprints)) {}

    std::size_t light_count() const { return cache_.light_count(); }
    void query(std::size_t first, std::size_t size, std::span<float> all, QueryStatistics*) const {
        cache_.visibility(std::span(points_).subspan(first, size), all);
    }
    Held held() const {
        const CacheStatistics now = cache_.statistics();
        return {now.records, now.bytes, now.lamp_rays, now.drop_rays + now.link_rays, now.point_rays};
    }

private:
    const Cache& cache_;
    std::vector<SurfacePoint> points_;
};

/// One query of every `stride`-th block of `count` points.
template <class Queries>
double timed_pass(const Queries& queries, std::size_t count, std::size_t first_block, std::size_t stride,
                  QueryStatistics* cost, Reporter& reporter) {
    std::vector<float> row(block_size * queries.light_count());
    double seconds = 0.0;
    for (std::size_t i = first_block * block_size; i < count; i += stride * block_size) {
        const std::size_t size = (std::min)(block_size, count - i);
        const Watch watch;
        queries.query(i, size, std::span(row).first(size * queries.light_count()), cost);
        seconds += watch.seconds();
        reporter.poll();
    }
    return seconds;
}

/// By which factor the records of a cache grow from the samples to a frame. Counted with four of the lights
/// where the samples have all points of one, else as light points in `frame_growth`.
template <class... Adapters>
double record_growth(const Subject<Adapters...>& subject, const Candidate& candidate, Reporter& reporter) {
    constexpr std::size_t most_lights = 4;
    const Samples& samples = subject.samples();
    double factor = 1.0;
    subject.with_cache(candidate, most_lights, [&](const auto& cache) {
        const CacheQueries few(cache, samples);
        const std::size_t count = samples.points.size();
        timed_pass(few, count, 0, 2, nullptr, reporter);
        const std::size_t half = few.held().light_points;
        timed_pass(few, count, 1, 2, nullptr, reporter);
        const std::size_t held = few.held().light_points;
        if (samples.frame_points.empty()) {
            factor = Growth(count, half, held).factor(count, samples.points_per_frame);
        } else if (held > 0) {
            const CacheQueries all(cache, samples.frame_points, samples.frame_normals,
                                   samples.frame_footprints);
            timed_pass(all, samples.frame_points.size(), 0, 1, nullptr, reporter);
            factor = static_cast<double>(all.held().light_points) / static_cast<double>(held);
        }
    });
    return factor;
}

/// Times of a mesh or a cache, and what they are made of.
struct Timing {
    double cold_seconds = 0.0;
    double warm_seconds = 0.0;             ///< the fastest pass
    double seconds_per_light_point = 0.0;  ///< to fill it
    double setup_seconds = 0.0;            ///< of the cold time what is neither warm time nor filling
    QueryStatistics cost;                  ///< of the cold pass
    Held held;                             ///< after it
};

/// Fills a mesh or a cache with every second block of the samples, and then with the others. By then all that
/// is done once is done: the second half tells what a light point costs, and so the first what comes on top
/// of it.
template <class Queries>
Timing time_queries(const Queries& queries, std::size_t count, const RendererCost& rendering,
                    double least_seconds, Reporter& reporter) {
    Timing timing;
    const double first = timed_pass(queries, count, 0, 2, &timing.cost, reporter);
    const auto half = static_cast<double>(queries.held().light_points);
    const double rendered = rendering.seconds;
    const double second = timed_pass(queries, count, 1, 2, &timing.cost, reporter);
    const double rendered_late = rendering.seconds - rendered;
    timing.held = queries.held();
    timing.cold_seconds = first + second;
    timing.warm_seconds = timed_pass(queries, count, 0, 1, nullptr, reporter);
    for (double sum = timing.warm_seconds; sum < least_seconds;) {
        const double seconds = timed_pass(queries, count, 0, 1, nullptr, reporter);
        timing.warm_seconds = (std::min)(timing.warm_seconds, seconds);
        sum += (std::max)(seconds, 1e-6);
    }
    const auto all = static_cast<double>(timing.held.light_points);
    const double filling = timing.cold_seconds - timing.warm_seconds;
    const double filling_late = second - rendered_late - 0.5 * timing.warm_seconds;
    // A single block has no second half.
    timing.seconds_per_light_point = all > half  ? (std::max)(filling_late, 0.0) / (all - half)
                                     : all > 0.0 ? (std::max)(filling - rendering.seconds, 0.0) / all
                                                 : 0.0;
    timing.setup_seconds = (std::max)(filling - timing.seconds_per_light_point * all, 0.0);
    return timing;
}

inline FrameEstimate estimate_frame(const Measurement& m, const Timing& timing, double grown,
                                    double fixed_bytes) {
    FrameEstimate frame;
    frame.light_points = static_cast<double>(m.light_points) * grown;
    frame.bytes = fixed_bytes + (static_cast<double>(m.bytes) - fixed_bytes) * grown;
    frame.warm_seconds = 1e-9 * m.warm_ns_per_point * static_cast<double>(m.points_per_frame);
    frame.cold_seconds =
        m.setup_seconds + timing.seconds_per_light_point * frame.light_points + frame.warm_seconds;
    return frame;
}

/// The references that measurements are held against.
struct References {
    const ErrorPoints& points;
    const LampReference& lamps;
    const Reference* mesh;  ///< of the candidate's radius; null for caches
};

/// The cost of making a mesh or a cache, and what it holds before the first query.
struct Making {
    double seconds = 0.0;
    std::size_t bytes = 0;
};

/// Measures times and what is held. `growth` is that of light points or records from samples to frame.
template <class Queries>
void measure_times(const Queries& queries, const Making& making, const RendererCost& rendering, double growth,
                   const Options& options, Reporter& reporter, Measurement& m) {
    const Timing timing = time_queries(queries, m.points, rendering, options.least_seconds, reporter);
    const double ns = 1e9 / static_cast<double>(m.points);
    m.cold_ns_per_point = (making.seconds + timing.cold_seconds) * ns;
    m.warm_ns_per_point = timing.warm_seconds * ns;
    m.setup_seconds = making.seconds + timing.setup_seconds;
    m.short_rays_per_point =
        static_cast<double>(timing.cost.short_rays + timing.cost.shadow_rays + timing.held.point_rays) /
        static_cast<double>(m.points);
    m.long_rays = timing.held.long_rays;
    m.link_rays = timing.held.link_rays;
    m.light_points = timing.held.light_points;
    m.bytes = timing.held.bytes;
    m.frame = estimate_frame(m, timing, growth,
                             static_cast<double>(making.bytes + rendering.texels * sizeof(float)));
}

/// Adds the errors of S at the points of the references, a row of lights for each.
inline void add_errors(std::span<const float> values, const References& references, Measurement& m) {
    const std::span<const float> lamps = references.lamps.values();
    const bool is_mesh = references.mesh != nullptr;
    const Difference error =
        references.points.difference(values, is_mesh ? references.mesh->values() : lamps);
    m.mean_absolute_error = error.mean_absolute;
    m.rms_error = error.root_mean_square;
    m.lamp_error = references.points.difference(values, lamps).mean_absolute;
    m.reference = is_mesh ? references.mesh->convergence() : references.lamps.convergence();
}

/// Measures one candidate that has passed `Subject::check`. Throws `Cancelled`.
template <class... Adapters>
Measurement measure(const Subject<Adapters...>& subject, const Candidate& candidate,
                    const References& references, double growth, const Options& options, Reporter& reporter) {
    const Samples& samples = subject.samples();
    const ErrorPoints& at = references.points;
    Measurement m;
    m.candidate = candidate;
    m.points = samples.points.size();
    m.points_per_frame = samples.points_per_frame;
    std::vector<float> values(at.value_count());
    RendererCost rendering;
    const Watch watch;
    if (is_cache(candidate)) {
        subject.with_cache(candidate, subject.lights().size(), [&](const auto& cache) {
            const Making making{watch.seconds(), cache.statistics().bytes};
            measure_times(CacheQueries(cache, samples), making, rendering, growth, options, reporter, m);
            cache.visibility(surface_points(at.points(), at.normals(), at.footprints()), values);
        });
    } else {
        subject.with_mesh(candidate, options.base, rendering, [&](const auto& mesh) {
            const Making making{watch.seconds(), mesh.statistics().bytes};
            measure_times(MeshQueries(mesh, samples), making, rendering, growth, options, reporter, m);
            mesh.visibility(at.points(), at.normals(), values);
        });
    }
    add_errors(values, references, m);
    return m;
}

/// Seconds for one shadow ray for each sample and light that can reach it.
template <class... Adapters>
double timed_shadow_rays(const Subject<Adapters...>& subject, const ShadowRays& rays) {
    const Samples& samples = subject.samples();
    const Watch watch;
    for (std::size_t i = 0; i < samples.points.size(); ++i)
        rays.for_each(samples.points[i], samples.normals[i], [&](std::size_t, const Segment& segment) {
            static_cast<void>(subject.tracer().occluded(segment));
        });
    return watch.seconds();
}

}  // namespace detail

/// The cost of hard shadows, to compare with: one shadow ray of the `Intersector` for each sample and light
/// that can reach it, one by one, on one thread. Nanoseconds per point, the fastest of three passes.
template <class... Adapters>
double time_shadow_rays(const Subject<Adapters...>& subject) {
    const ShadowRays rays(subject.lights(), subject.resolution());
    double seconds = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < 3; ++pass)
        seconds = (std::min)(seconds, detail::timed_shadow_rays(subject, rays));
    return 1e9 * seconds / static_cast<double>(subject.samples().points.size());
}

}  // namespace lightmesh::tune
