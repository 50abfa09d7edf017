// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/segment.hpp>
#include <lightmesh/shadow_rays.hpp>
#include <lightmesh/tune/require.hpp>
#include <lightmesh/tune/subject.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace lightmesh::tune {

/// Radii to try, and what they come from.
struct RadiusAdvice {
    std::vector<float> radii;     ///< half of it, `radius`, twice of it; world units
    float radius = 0.0f;          ///< rounded to 1, 1.5, 2, 3, 5 or 7 times a power of ten
    double penumbra_width = 0.0;  ///< median over the shadowed pairs, world units; 0 if there are none
    std::size_t points = 0;       ///< of the frame, or of the samples, that were looked at
    std::size_t pairs = 0;        ///< of one of these and a light that could reach it
    std::size_t shadowed = 0;     ///< those of them with something between
};

namespace detail {

/// 1, 1.5, 2, 3, 5 or 7 times a power of ten, the one with the nearest logarithm.
inline float round_radius(double value) {
    constexpr std::array steps{1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0};
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    double best = power;
    for (const double step : steps)
        if (std::abs(std::log(value / (step * power))) < std::abs(std::log(value / best)))
            best = step * power;
    return static_cast<float>(best);
}

/// Distance from the origin of a blocked segment to its first blocker: a doubling search from `start`, which
/// finds what is near as exactly as what is far, and ten halvings.
template <Intersector Tracer>
double first_blocker(const Tracer& tracer, const Segment& segment, double start) {
    const glm::dvec3 origin(segment.origin);
    const glm::dvec3 to_target = glm::dvec3(segment.target) - origin;
    const double length = glm::length(to_target);
    const auto is_blocked = [&](double distance) {
        return tracer.occluded(Segment{segment.origin, glm::vec3(origin + to_target * (distance / length))});
    };
    double open = 0.0;
    double blocked = start;
    while (blocked < length && !is_blocked(blocked)) {
        open = blocked;
        blocked *= 2.0;
    }
    blocked = (std::min)(blocked, length);
    for (int i = 0; i < 10; ++i) {
        const double centre = 0.5 * (open + blocked);
        (is_blocked(centre) ? blocked : open) = centre;
    }
    return blocked;
}

/// For `count` things in a row: multiples of this, modulo `count`, meet all parts of the row before any thing
/// that lies close to one before, and each thing once. By the golden ratio.
inline std::size_t golden_stride(std::size_t count) {
    auto stride = static_cast<std::size_t>(0.6180339887498949 * static_cast<double>(count)) + 1;
    while (std::gcd(stride, count) != 1)
        ++stride;
    return stride;
}

/// The median; `values` are not empty.
inline double median(std::vector<double> values) {
    const auto centre = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), centre, values.end());
    return *centre;
}

}  // namespace detail

/// Radii that suit a scene.
///
/// A lamp of radius R throws a penumbra of width w = 2 R d / D behind an edge at distance D from it, d before
/// the surface (similar triangles through the edge). A mesh blurs an edge over 2 r, whatever the distances:
/// so the radius that gives the typical penumbra of this scene its true width is r = R d / D. Point lights
/// have no size; all of them are taken for lamps that the lit surface sees at `lamp_angle` from centre to
/// rim: R = lamp_angle * (d + D). The default is a big, soft lamp: it gives about the radii that published
/// pictures have, and those of this project's scenes. A smaller one gives crisper shadows, which cost more:
/// light points grow with 1 / r^2. A directional light, for which D is infinite, gives r = lamp_angle * d.
///
/// d and D are measured at 4,096 points or more, spread over all points of the frame, if the samples have
/// them, else over the samples; where there are fewer, at all of them: with 4,096 pairs or more of a point
/// and a light that can reach it, if there are so many. For each such pair, of which most points have one,
/// the blocker nearest to the surface is searched with some 20 rays. The radius is the median over the pairs
/// that have one. It is kept between 1/500 and 1/20 of the diagonal of the samples' box: below that a shadow
/// is as good as hard, above it is no shadow. Without any shadow (`RadiusAdvice::shadowed` is 0) it is 1/100
/// of the diagonal. No more than 32,768 pairs are tried, for views that few lights reach.
///
/// `lamp_angle` in radians, finite, greater than 0; else std::invalid_argument, as also if all samples lie on
/// one point.
template <class Tracer, class... Sources>
RadiusAdvice suggest_radii(const Subject<Tracer, Sources...>& subject, double lamp_angle = 0.3) {
    detail::require(lamp_angle > 0.0 && lamp_angle < 1e6, "lamp_angle", lamp_angle,
                    "finite and greater than 0");
    const Samples& samples = subject.samples();
    const float diagonal = subject.diagonal();
    detail::require(diagonal > 0.0f, "the diagonal of the samples' box", diagonal, "greater than 0");
    const ShadowRays rays(subject.lights(), subject.resolution());
    const auto size = static_cast<double>(diagonal);
    constexpr std::size_t enough = 4096;  // of points, and of pairs
    const bool has_frame = !samples.frame_points.empty();
    const std::span<const glm::vec3> points = has_frame ? samples.frame_points : samples.points;
    const std::span<const glm::vec3> normals = has_frame ? samples.frame_normals : samples.normals;
    const std::size_t all = points.size() * rays.size();
    const std::size_t tried = (std::min)(all, 8 * enough);
    const std::size_t stride = detail::golden_stride(all);
    const std::size_t enough_points = (std::min)(points.size(), enough);
    RadiusAdvice advice;
    std::vector<bool> is_counted(points.size());
    std::vector<double> radii;
    for (std::size_t k = 0; k < tried && (advice.pairs < enough || advice.points < enough_points); ++k) {
        const std::size_t pair = k * stride % all;
        const std::size_t light = pair % rays.size();
        const std::size_t place = pair / rays.size();
        const glm::vec3& point = points[place];
        const glm::vec3& normal = normals[place];
        advice.points += is_counted[place] ? 0u : 1u;
        is_counted[place] = true;
        if (!rays.can_light(light, point, normal))
            continue;
        ++advice.pairs;
        const Segment segment = rays.segment(light, point, normal);
        if (!subject.tracer().occluded(segment))
            continue;
        ++advice.shadowed;
        const double d = detail::first_blocker(subject.tracer(), segment, 1e-3 * size);
        const auto length = static_cast<double>(glm::distance(segment.origin, segment.target));
        const bool is_sun = std::holds_alternative<DirectionalLight>(subject.lights()[light]);
        radii.push_back(lamp_angle * (is_sun ? d : d * length / (std::max)(length - d, 1e-3 * length)));
    }
    const double wanted = radii.empty() ? size / 100.0 : detail::median(radii);
    advice.penumbra_width = radii.empty() ? 0.0 : 2.0 * wanted;
    advice.radius = detail::round_radius(std::clamp(wanted, size / 500.0, size / 20.0));
    advice.radii = {detail::round_radius(0.5 * static_cast<double>(advice.radius)), advice.radius,
                    detail::round_radius(2.0 * static_cast<double>(advice.radius))};
    return advice;
}

}  // namespace lightmesh::tune
