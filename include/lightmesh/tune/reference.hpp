// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/shadow_rays.hpp>
#include <lightmesh/tune/options.hpp>
#include <lightmesh/tune/subject.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// The values that light meshes are held against: S of equation (3), all tests by rays, with so many light
/// points that more of them change nothing.

namespace lightmesh::tune {

/// The quality of a reference.
struct Convergence {
    float quality = 0.0f;  ///< q of the reference; 0 of a cache, whose reference are rays to lamps
    /// Mean absolute difference of S between the reference and one of half its q, or half its rays.
    double change = 0.0;
    /// True if `change` is as small as was asked for. If not, q has reached its limit of 16, or rays theirs
    /// of 256, before.
    bool converged = false;
};

namespace detail {

/// Difference of S over pairs of a point and a light that can reach it.
struct Difference {
    double mean_absolute = 0.0;
    double root_mean_square = 0.0;
};

/// The points and lights at which errors are measured: every k-th of the samples.
class ErrorPoints {
public:
    template <class... Adapters>
    ErrorPoints(const Subject<Adapters...>& subject, std::size_t most)
        : light_count_(subject.lights().size()) {
        const Samples& samples = subject.samples();
        const std::size_t count = samples.points.size();
        const std::size_t chosen = (std::min)(most, count);
        for (std::size_t i = 0; i < chosen; ++i) {
            points_.push_back(samples.points[i * count / chosen]);
            normals_.push_back(samples.normals[i * count / chosen]);
            if (!samples.footprints.empty())
                footprints_.push_back(samples.footprints[i * count / chosen]);
        }
        // Where S can be other than 0: chi, range and cone.
        const ShadowRays rays(subject.lights(), subject.resolution());
        for (std::size_t i = 0; i < points_.size(); ++i)
            rays.for_each(points_[i], normals_[i], [&](std::size_t light, const Segment&) {
                pairs_.push_back(i * light_count_ + light);
            });
    }

    std::span<const glm::vec3> points() const { return points_; }
    std::span<const glm::vec3> normals() const { return normals_; }
    std::span<const float> footprints() const { return footprints_; }
    /// Of S at all points, a row of lights for each.
    std::size_t value_count() const { return points_.size() * light_count_; }

    Difference difference(std::span<const float> a, std::span<const float> b) const {
        if (pairs_.empty())
            return {};
        double sum = 0.0;
        double sum_of_squares = 0.0;
        for (const std::size_t pair : pairs_) {
            const double d = static_cast<double>(a[pair]) - static_cast<double>(b[pair]);
            sum += std::abs(d);
            sum_of_squares += d * d;
        }
        const auto count = static_cast<double>(pairs_.size());
        return {sum / count, std::sqrt(sum_of_squares / count)};
    }

private:
    std::size_t light_count_;
    std::vector<glm::vec3> points_;
    std::vector<glm::vec3> normals_;
    std::vector<float> footprints_;
    std::vector<std::size_t> pairs_;
};

/// Calls work(i) for each i < count by the executor, and asks now and then whether to go on.
template <class Work>
void in_rounds(std::size_t count, const Options& options, Reporter& reporter, const Work& work) {
    const std::size_t round = options.executor.threads == 1 ? 1 : 4 * options.executor.threads;
    for (std::size_t done = 0; done < count; done += round) {
        reporter.poll();
        options.executor.for_each((std::min)(round, count - done), [&](std::size_t i) { work(done + i); });
    }
}

/// S of a light mesh at the points where errors are measured, for one radius.
class Reference {
public:
    /// `largest_quality` is that of the candidates. Throws `Cancelled`.
    template <class... Adapters>
    Reference(const ErrorPoints& points, const Subject<Adapters...>& subject, float radius,
              float largest_quality, const Options& options, Reporter& reporter) {
        const auto compute = [&](float quality) {
            return values_of(points, subject, settings_at(radius, quality, options), options, reporter);
        };
        // The pairs of qualities that are compared end at 16, the greatest that there is.
        const float limit = Grid::max_quality;
        float coarse = (std::min)(largest_quality, limit / 2.0f);
        std::vector<float> before = compute(coarse);
        for (;;) {
            const float fine = 2.0f * coarse;
            values_ = compute(fine);
            const double change = points.difference(before, values_).mean_absolute;
            convergence_ = {fine, change, change < options.reference_change};
            if (convergence_.converged || fine >= limit)
                return;
            if (2.0f * fine <= limit) {
                before = values_;
                coarse = fine;
            } else {
                coarse = limit / 2.0f;
                before = compute(coarse);
            }
        }
    }

    const Convergence& convergence() const { return convergence_; }
    /// A row of lights for each point.
    std::span<const float> values() const { return values_; }

private:
    static Settings settings_at(float radius, float quality, const Options& options) {
        return settings_of({radius, quality, ShortTest::exact, LongTest::rays, 0}, options.base);
    }

    /// Each group of points has a mesh of its own, so that memory stays small.
    template <class... Adapters>
    static std::vector<float> values_of(const ErrorPoints& at, const Subject<Adapters...>& subject,
                                        const Settings& settings, const Options& options,
                                        Reporter& reporter) {
        constexpr std::size_t group_size = 4;
        const std::size_t count = at.points().size();
        const std::size_t light_count = subject.lights().size();
        std::vector<float> values(at.value_count());
        in_rounds((count + group_size - 1) / group_size, options, reporter, [&](std::size_t group) {
            const LightMesh mesh{subject.tracer(), subject.lights(), settings};
            const std::size_t first = group * group_size;
            const std::size_t size = (std::min)(group_size, count - first);
            mesh.visibility(at.points().subspan(first, size), at.normals().subspan(first, size),
                            std::span(values).subspan(first * light_count, size * light_count));
        });
        return values;
    }

    std::vector<float> values_;
    Convergence convergence_;
};

}  // namespace detail

}  // namespace lightmesh::tune
