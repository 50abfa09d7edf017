// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/grid.hpp>
#include <lightmesh/light_table.hpp>
#include <lightmesh/ray_ends.hpp>
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
/// neighbours share them: as max * n / (n + half), which is fitted to a half and all of the samples.
struct FrameEstimate {
    double light_points = 0.0;
    double bytes = 0.0;
    double cold_seconds = 0.0;  ///< the first frame, which fills the mesh
    double warm_seconds = 0.0;  ///< a frame that finds all it needs in the mesh
};

/// What a candidate costs and how well it does. Times are of one thread.
struct Measurement {
    Candidate candidate;
    std::size_t points = 0;             ///< surface points queried, each once in each pass
    std::size_t points_per_frame = 0;   ///< as the samples had it
    double cold_ns_per_point = 0.0;     ///< from an empty mesh, all that fills it included
    double warm_ns_per_point = 0.0;     ///< all lights, the mesh being filled
    double setup_seconds = 0.0;         ///< making the mesh and rendering shadow maps; part of the cold time
    double short_rays_per_point = 0.0;  ///< to light points, and to lights where a point sees none of them
    std::uint64_t long_rays = 0;        ///< for V(L, x), all samples together
    std::uint64_t link_rays = 0;        ///< for links between light points, all samples together
    std::size_t light_points = 0;
    std::size_t bytes = 0;
    /// Mean absolute difference of S to the reference of the same radius, over pairs of a point and a light
    /// that can reach it.
    double mean_absolute_error = 0.0;
    double rms_error = 0.0;  ///< root mean square of the same
    Convergence reference;
    FrameEstimate frame;
};

namespace detail {

/// One query of all the samples, block by block.
template <class Mesh>
double timed_pass(const Mesh& mesh, const Samples& samples, std::span<float> row, QueryStatistics* spent,
                  Reporter& reporter) {
    double seconds = 0.0;
    const std::size_t count = samples.points.size();
    for (std::size_t i = 0; i < count; i += block_size) {
        const std::size_t size = (std::min)(block_size, count - i);
        const Watch watch;
        mesh.visibility(samples.points.subspan(i, size), samples.normals.subspan(i, size),
                        row.first(size * mesh.light_count()), spent);
        seconds += watch.seconds();
        reporter.poll();
    }
    return seconds;
}

/// Times of a mesh: filling it, and the fastest pass afterwards.
struct Timing {
    double cold_seconds = 0.0;
    double warm_seconds = 0.0;
    QueryStatistics spent;
};

template <class Mesh>
Timing time_mesh(const Mesh& mesh, const Samples& samples, double least_seconds, Reporter& reporter) {
    std::vector<float> row(block_size * mesh.light_count());
    Timing timing;
    timing.cold_seconds = timed_pass(mesh, samples, row, &timing.spent, reporter);
    timing.warm_seconds = timed_pass(mesh, samples, row, nullptr, reporter);
    for (double sum = timing.warm_seconds; sum < least_seconds;) {
        const double seconds = timed_pass(mesh, samples, row, nullptr, reporter);
        timing.warm_seconds = (std::min)(timing.warm_seconds, seconds);
        sum += (std::max)(seconds, 1e-6);
    }
    return timing;
}

inline FrameEstimate estimate_frame(const Measurement& m, const Growth& growth, double fixed_bytes) {
    const auto points = static_cast<double>(m.points);
    const auto per_frame = static_cast<double>(m.points_per_frame);
    const double grown = growth.factor(m.points, m.points_per_frame);
    FrameEstimate frame;
    frame.light_points = static_cast<double>(m.light_points) * grown;
    frame.bytes = fixed_bytes + (static_cast<double>(m.bytes) - fixed_bytes) * grown;
    frame.warm_seconds = 1e-9 * m.warm_ns_per_point * per_frame;
    const double filling = 1e-9 * (m.cold_ns_per_point - m.warm_ns_per_point) * points - m.setup_seconds;
    frame.cold_seconds = m.setup_seconds + frame.warm_seconds + (std::max)(filling, 0.0) * grown;
    return frame;
}

/// Measures one candidate that has passed `Subject::check`. Throws `Cancelled`.
template <class... Adapters>
Measurement measure(const Subject<Adapters...>& subject, const Candidate& candidate,
                    const Reference& reference, const Growth& growth, const Options& options,
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
        const Timing timing = time_mesh(mesh, samples, options.least_seconds, reporter);
        const MeshStatistics held = mesh.statistics();
        const double ns = 1e9 / static_cast<double>(m.points);
        m.cold_ns_per_point = (made + timing.cold_seconds) * ns;
        m.warm_ns_per_point = timing.warm_seconds * ns;
        m.setup_seconds = made + rendering.seconds;
        m.short_rays_per_point = static_cast<double>(timing.spent.short_rays + timing.spent.shadow_rays) /
                                 static_cast<double>(m.points);
        m.long_rays = held.long_rays;
        m.link_rays = held.link_rays;
        m.light_points = held.light_points;
        m.bytes = held.bytes;
        m.frame =
            estimate_frame(m, growth, static_cast<double>(empty_bytes + rendering.texels * sizeof(float)));
        std::vector<float> values(reference.points().size() * mesh.light_count());
        mesh.visibility(reference.points(), reference.normals(), values);
        const Difference error = reference.difference_to(values);
        m.mean_absolute_error = error.mean_absolute;
        m.rms_error = error.root_mean_square;
    });
    return m;
}

}  // namespace detail

/// What the plain way costs, to compare with: one shadow ray of the `Intersector` for each sample and light
/// that can reach it, one by one, on one thread. Nanoseconds per point.
template <class... Adapters>
double time_shadow_rays(const Subject<Adapters...>& subject) {
    const Grid grid{Settings{}};
    const lightmesh::detail::LightTable table(subject.lights(), grid);
    const Samples& samples = subject.samples();
    const detail::Watch watch;
    for (std::size_t i = 0; i < samples.points.size(); ++i) {
        const glm::vec3 normal = lightmesh::detail::unit_or_zero(samples.normals[i]);
        const glm::vec3 end =
            lightmesh::detail::surface_end(samples.points[i], normal, static_cast<float>(grid.step()));
        for (std::size_t light = 0; light < table.size(); ++light)
            if (table.reaches(light, samples.points[i], normal))
                static_cast<void>(subject.tracer().occluded(table.shadow_segment(light, end)));
    }
    return 1e9 * watch.seconds() / static_cast<double>(samples.points.size());
}

}  // namespace lightmesh::tune
