// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/shadow_rays.hpp>
#include <lightmesh/tune/options.hpp>
#include <lightmesh/tune/reference.hpp>
#include <lightmesh/tune/subject.hpp>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <variant>
#include <vector>

/// The values that caches are held against, and meshes besides: the share of each lamp that 256 rays find
/// open.

namespace lightmesh::tune::detail {

/// Uniform in [0, 1), always the same for the same number: splitmix64 (Steele, Lea and Flood, "Fast
/// Splittable Pseudorandom Number Generators", OOPSLA 2014).
inline double uniform_of(std::uint64_t number) {
    number = (number + 1) * 0x9e3779b97f4a7c15u;
    number = (number ^ number >> 30) * 0xbf58476d1ce4e5b9u;
    number = (number ^ number >> 27) * 0x94d049bb133111ebu;
    return static_cast<double>((number ^ number >> 31) >> 11) * 0x1p-53;
}

/// A lamp as seen along the segment to its centre that `ShadowRays` gives: the same origin, and ends that do
/// not let a fixture hide its own lamp, as `VisibilityCache` has them.
class LampView {
public:
    LampView(const Light& light, const Segment& to_middle) : origin_(to_middle.origin) {
        to_end_ = glm::dvec3(to_middle.target) - origin_;
        if (const auto* sun = std::get_if<DirectionalLight>(&light)) {
            span_disc(glm::length(to_end_) * std::tan(static_cast<double>(sun->angular_radius)));
        } else if (const auto* pane = std::get_if<RectLight>(&light)) {
            u_ = glm::dvec3(pane->half_u);
            v_ = glm::dvec3(pane->half_v);
            is_rectangle_ = true;
        } else {
            const auto* spot = std::get_if<SpotLight>(&light);
            const auto* point = std::get_if<PointLight>(&light);
            const auto radius = static_cast<double>(spot != nullptr ? spot->radius : point->radius);
            const double distance = glm::length(to_end_);
            share_ = radius > 0.0 ? (std::max)(0.3, 1.0 - 1.15 * radius / distance) : 1.0;
            span_disc(radius);
        }
    }

    /// True if one segment says all.
    bool is_point() const { return u_ == glm::dvec3(0.0) && v_ == glm::dvec3(0.0); }

    /// To one point of the lamp for each of [0, 1)^2, uniform over its area.
    Segment segment(double x, double y) const {
        if (is_rectangle_)
            return to((2.0 * x - 1.0) * u_ + (2.0 * y - 1.0) * v_);
        const double angle = 2.0 * std::numbers::pi * y;
        return to(std::sqrt(x) * (std::cos(angle) * u_ + std::sin(angle) * v_));
    }

private:
    Segment to(const glm::dvec3& from_middle) const {
        return {glm::vec3(origin_), glm::vec3(origin_ + share_ * (to_end_ + from_middle))};
    }

    /// The disc of this radius that faces the origin.
    void span_disc(double radius) {
        const glm::dvec3 axis = glm::normalize(to_end_);
        const glm::dvec3 other = std::abs(axis.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
        const glm::dvec3 right = glm::normalize(glm::cross(axis, other));
        u_ = radius * right;
        v_ = radius * glm::cross(right, axis);
    }

    glm::dvec3 origin_;
    glm::dvec3 to_end_;
    double share_ = 1.0;
    bool is_rectangle_ = false;
    glm::dvec3 u_{0.0};
    glm::dvec3 v_{0.0};
};

/// The share of each lamp that is open at the points where errors are measured: 256 rays, stratified, two
/// times 8 x 16, of which the first half tells how much chance there is in all.
class LampReference {
public:
    /// Throws `Cancelled`.
    template <class... Adapters>
    LampReference(const ErrorPoints& at, const Subject<Adapters...>& subject, const Options& options,
                  Reporter& reporter)
        : values_(at.value_count()) {
        const ShadowRays rays(subject.lights(), subject.resolution());
        const std::size_t light_count = subject.lights().size();
        std::vector<float> halves(values_.size());
        in_rounds(at.points().size(), options, reporter, [&](std::size_t i) {
            rays.for_each(at.points()[i], at.normals()[i], [&](std::size_t light, const Segment& to_middle) {
                const std::size_t pair = i * light_count + light;
                const LampView lamp(subject.lights()[light], to_middle);
                if (lamp.is_point()) {
                    values_[pair] = halves[pair] = subject.tracer().occluded(to_middle) ? 0.0f : 1.0f;
                    return;
                }
                const double first = open_share(subject.tracer(), lamp, 2 * pair);
                const double second = open_share(subject.tracer(), lamp, 2 * pair + 1);
                halves[pair] = static_cast<float>(first);
                values_[pair] = static_cast<float>(0.5 * (first + second));
            });
        });
        const double change = at.difference(halves, values_).mean_absolute;
        convergence_ = {0.0f, change, change < options.reference_change};
    }

    const Convergence& convergence() const { return convergence_; }
    /// A row of lights for each point.
    std::span<const float> values() const { return values_; }

    static constexpr std::size_t ray_count = 256;

private:
    template <class Tracer>
    static double open_share(const Tracer& tracer, const LampView& lamp, std::uint64_t seed) {
        constexpr std::size_t rings = 8;
        constexpr std::size_t turns = 16;
        static_assert(2 * rings * turns == ray_count);
        std::size_t open = 0;
        for (std::size_t k = 0; k < rings * turns; ++k) {
            const std::uint64_t number = 2 * (seed * rings * turns + k);
            const std::size_t ring = k / turns;
            const std::size_t turn = k % turns;
            const double x = (static_cast<double>(ring) + uniform_of(number)) / rings;
            const double y = (static_cast<double>(turn) + uniform_of(number + 1)) / turns;
            open += tracer.occluded(lamp.segment(x, y)) ? 0u : 1u;
        }
        return static_cast<double>(open) / static_cast<double>(rings * turns);
    }

    std::vector<float> values_;
    Convergence convergence_;
};

}  // namespace lightmesh::tune::detail
