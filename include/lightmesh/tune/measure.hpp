// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/shadow_rays.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/tune/candidate.hpp>
#include <lightmesh/tune/frame_growth.hpp>
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

/// What a whole frame would take, from the samples: one thread, `Samples::points_per_frame` points. An
/// estimate.
///
/// What is paid per surface point grows with their number, what is paid per light point with the number of
/// light points, and shadow maps are rendered once. Light points grow slower than surface points, since
/// neighbours share them: by as much as is counted in empty space with `Samples::frame_points`, at a q of 2
/// at most; without these as max * n / (n + half), which is fitted to a half and all of the samples.
struct FrameEstimate {
    double light_points = 0.0;  ///< that the mesh holds
    double bytes = 0.0;         ///< mesh and shadow maps
    double cold_seconds = 0.0;  ///< the first frame, which fills the mesh
    double warm_seconds = 0.0;  ///< a frame that finds all it needs in the mesh
};

/// What a candidate costs and how well it does. Times are of one thread, but that a `DepthRenderer` may use
/// more.
struct Measurement {
    Candidate candidate;                ///< what was measured
    std::size_t points = 0;             ///< surface points queried, each once in each pass
    std::size_t points_per_frame = 0;   ///< as the samples had it
    double cold_ns_per_point = 0.0;     ///< from an empty mesh, all that fills it included
    double warm_ns_per_point = 0.0;     ///< all lights, the mesh being filled
    double setup_seconds = 0.0;         ///< of the cold time what is paid once: mostly shadow maps
    double short_rays_per_point = 0.0;  ///< to light points, and to lights where a point sees none of them
    std::uint64_t long_rays = 0;        ///< for V(L, x), all samples together
    std::uint64_t link_rays = 0;        ///< for links between light points, all samples together
    std::size_t light_points = 0;       ///< that the mesh holds in the end
    std::size_t bytes = 0;              ///< of the mesh in the end
    /// Mean absolute difference of S to the reference of the same radius, over pairs of a point and a light
    /// that can reach it.
    double mean_absolute_error = 0.0;
    double rms_error = 0.0;  ///< root mean square of the same
    Convergence reference;   ///< what the errors are held against
    FrameEstimate frame;     ///< the same for a whole frame
};

namespace detail {

/// One query of every `stride`-th block of the samples.
template <class Mesh>
double timed_pass(const Mesh& mesh, const Samples& samples, std::size_t first_block, std::size_t stride,
                  QueryStatistics* spent, Reporter& reporter) {
    std::vector<float> row(block_size * mesh.light_count());
    double seconds = 0.0;
    const std::size_t count = samples.points.size();
    for (std::size_t i = first_block * block_size; i < count; i += stride * block_size) {
        const std::size_t size = (std::min)(block_size, count - i);
        const Watch watch;
        mesh.visibility(samples.points.subspan(i, size), samples.normals.subspan(i, size),
                        std::span(row).first(size * mesh.light_count()), spent);
        seconds += watch.seconds();
        reporter.poll();
    }
    return seconds;
}

/// Times of a mesh, and what they are made of.
struct Timing {
    double cold_seconds = 0.0;
    double warm_seconds = 0.0;             ///< the fastest pass
    double seconds_per_light_point = 0.0;  ///< to fill it
    double setup_seconds = 0.0;            ///< of the cold time what is neither warm time nor filling
    QueryStatistics spent;                 ///< of the cold pass
    MeshStatistics held;                   ///< after it
};

/// Fills the mesh with every second block of the samples, and then with the others. By then all that is done
/// once is done: the second half tells what a light point costs, and so the first what comes on top of it.
template <class Mesh>
Timing time_mesh(const Mesh& mesh, const Samples& samples, const RendererCost& rendering,
                 double least_seconds, Reporter& reporter) {
    Timing timing;
    const double first = timed_pass(mesh, samples, 0, 2, &timing.spent, reporter);
    const auto half = static_cast<double>(mesh.statistics().light_points);
    const double rendered = rendering.seconds;
    const double second = timed_pass(mesh, samples, 1, 2, &timing.spent, reporter);
    const double rendered_late = rendering.seconds - rendered;
    timing.held = mesh.statistics();
    timing.cold_seconds = first + second;
    timing.warm_seconds = timed_pass(mesh, samples, 0, 1, nullptr, reporter);
    for (double sum = timing.warm_seconds; sum < least_seconds;) {
        const double seconds = timed_pass(mesh, samples, 0, 1, nullptr, reporter);
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

/// Measures one candidate that has passed `Subject::check`. Throws `Cancelled`.
template <class... Adapters>
Measurement measure(const Subject<Adapters...>& subject, const Candidate& candidate,
                    const Reference& reference, double frame_growth, const Options& options,
                    Reporter& reporter) {
    const Samples& samples = subject.samples();
    Measurement m;
    m.candidate = candidate;
    m.points = samples.points.size();
    m.points_per_frame = samples.points_per_frame;
    m.reference = reference.convergence();
    RendererCost rendering;
    const Watch making;
    subject.with_mesh(candidate, options.base, rendering, [&](const auto& mesh) {
        const double made = making.seconds();
        const std::size_t empty_bytes = mesh.statistics().bytes;
        const Timing timing = time_mesh(mesh, samples, rendering, options.least_seconds, reporter);
        const double ns = 1e9 / static_cast<double>(m.points);
        m.cold_ns_per_point = (made + timing.cold_seconds) * ns;
        m.warm_ns_per_point = timing.warm_seconds * ns;
        m.setup_seconds = made + timing.setup_seconds;
        m.short_rays_per_point = static_cast<double>(timing.spent.short_rays + timing.spent.shadow_rays) /
                                 static_cast<double>(m.points);
        m.long_rays = timing.held.long_rays;
        m.link_rays = timing.held.link_rays;
        m.light_points = timing.held.light_points;
        m.bytes = timing.held.bytes;
        m.frame = estimate_frame(m, timing, frame_growth,
                                 static_cast<double>(empty_bytes + rendering.texels * sizeof(float)));
        std::vector<float> values(reference.points().size() * mesh.light_count());
        mesh.visibility(reference.points(), reference.normals(), values);
        const Difference error = reference.difference_to(values);
        m.mean_absolute_error = error.mean_absolute;
        m.rms_error = error.root_mean_square;
    });
    return m;
}

}  // namespace detail

namespace detail {

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

/// What the plain way costs, to compare with: one shadow ray of the `Intersector` for each sample and light
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
