// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/settings.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/rounded.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

namespace lightmesh {

/// The positions of the light points: x(i, j, k) = origin + step * (i, j, k), for all integers of magnitude
/// up to `Grid::max_index`. World units; computed in double, so that far from the origin the points are still
/// the nearest floats to their places.
class Grid {
public:
    /// Beyond this index a float cannot tell neighbouring light points apart.
    static constexpr std::int32_t max_index = 1 << 24;

    /// Of radius and origin, world units: what is greater can not be squared.
    static constexpr float largest_coordinate = 1e18f;

    /// Throws std::invalid_argument that names the value for a radius or quality that is not finite or out of
    /// range, and for an origin that is out of range or only partly NaN.
    explicit Grid(const Settings& settings) {
        using detail::require;
        require(settings.radius > 0.0f && settings.radius <= largest_coordinate, "Settings::radius",
                settings.radius, "greater than 0 and at most 1e18");
        require(settings.quality >= 1.0f && settings.quality <= max_quality, "Settings::quality",
                settings.quality, "in [1, 16]");
        radius_ = settings.radius;
        quality_ = settings.quality;
        step_ = static_cast<double>(radius_) / static_cast<double>(quality_);
        const glm::vec3& origin = settings.origin;
        if (std::isnan(origin.x) && std::isnan(origin.y) && std::isnan(origin.z)) {
            origin_ = glm::dvec3(0.3819660, 0.2763932, 0.4270510) * step_;
        } else {
            require(detail::largest_component(origin) <= largest_coordinate && detail::is_finite(origin),
                    "Settings::origin", origin, "of magnitude up to 1e18, or NaN in all three components");
            origin_ = glm::dvec3(origin);
        }
    }

    /// The same with an origin in double: that of another grid, from its `origin`. Throws as above.
    Grid(const Settings& settings, const glm::dvec3& origin) : Grid(settings) {
        detail::require(std::abs(origin.x) <= 1e18 && std::abs(origin.y) <= 1e18 &&
                            std::abs(origin.z) <= 1e18,
                        "the grid's origin", glm::vec3(origin), "of magnitude up to 1e18");
        origin_ = origin;
    }

    /// r of equation (2), world units.
    float radius() const { return radius_; }
    /// q: light points per radius.
    float quality() const { return quality_; }
    /// h = r / q, world units.
    double step() const { return step_; }
    /// The light point of index (0, 0, 0), world units.
    const glm::dvec3& origin() const { return origin_; }

    /// The light point of an index.
    glm::vec3 position(const glm::ivec3& index) const {
        using detail::rounded;
        return {static_cast<float>(origin_.x + rounded(step_ * index.x)),
                static_cast<float>(origin_.y + rounded(step_ * index.y)),
                static_cast<float>(origin_.z + rounded(step_ * index.z))};
    }

    /// The position of a point in the grid, in steps from the origin. Throws std::out_of_range that names the
    /// point if the light points around it have no index.
    glm::dvec3 locate(const glm::vec3& point) const {
        const glm::dvec3 pos = detail::rounded((glm::dvec3(point) - origin_) * (1.0 / step_));
        constexpr double limit = max_index - 64.0;
        const bool inside = std::abs(pos.x) < limit && std::abs(pos.y) < limit && std::abs(pos.z) < limit;
        if (!inside)
            throw_outside(point);
        return pos;
    }

    /// The greatest q.
    static constexpr float max_quality = 16.0f;

private:
    [[noreturn]] void throw_outside(const glm::vec3& point) const {
        throw std::out_of_range(
            "lightmesh: point " + detail::to_text(point) + " lies outside the grid, which reaches " +
            detail::to_text(max_index * step_) + " to all sides of " + detail::to_text(glm::vec3(origin_)) +
            "; a greater radius or a lower quality reaches farther");
    }

    glm::dvec3 origin_{0.0};
    double step_ = 1.0;
    float radius_ = 1.0f;
    float quality_ = 1.0f;
};

}  // namespace lightmesh
