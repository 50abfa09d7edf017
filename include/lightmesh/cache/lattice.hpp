// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache_settings.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/rounded.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

namespace lightmesh::detail {

/// The lattices on which records stand, one for each level: x = origin(level) + step(level) * index. A level
/// has half the step of the level before.
///
/// Products here are exact in double, 24 bits of a step by at most 27 of an index, so that positions and
/// indices do not depend on whether a compiler fuses them with the sums that follow.
class Lattice {
public:
    static constexpr int level_count = 16;
    /// The level of step g. Coarser ones serve points with wide footprints.
    static constexpr int base_level = 9;
    /// Indices lie below this magnitude, on all levels.
    static constexpr std::int32_t max_index = 1 << 25;

    /// Throws std::invalid_argument that names the value for settings out of range.
    explicit Lattice(const CacheSettings& settings) {
        require(settings.spacing > 0.0f && settings.spacing <= 1e18f, "CacheSettings::spacing",
                settings.spacing, "greater than 0 and at most 1e18");
        require(settings.detail >= 0 && settings.detail <= 6, "CacheSettings::detail", settings.detail,
                "in [0, 6]");
        require(settings.lamp_rays >= 1 && settings.lamp_rays <= 256, "CacheSettings::lamp_rays",
                settings.lamp_rays, "in [1, 256]");
        const glm::vec3& origin = settings.origin;
        const bool is_default = std::isnan(origin.x) && std::isnan(origin.y) && std::isnan(origin.z);
        require(is_default || (is_finite(origin) && largest_component(origin) <= 1e18f),
                "CacheSettings::origin", origin, "of magnitude up to 1e18, or NaN in all three components");
        finest_ = base_level + settings.detail;
        has_shaft_rows_ = settings.shaft_rows;
        for (int level = 0; level < level_count; ++level) {
            const auto l = static_cast<std::size_t>(level);
            step_[l] = std::ldexp(static_cast<double>(settings.spacing), base_level - level);
            per_step_[l] = 1.0 / step_[l];
            const glm::dvec3 uneven(glm::vec3(0.3819660f, 0.2763932f, 0.4270510f));
            origin_[l] = is_default ? step_[l] * uneven : glm::dvec3(origin);
        }
    }

    int finest_level() const { return finest_; }
    /// True if probes ask what records of a level miss.
    bool has_probes(int level) const {
        return (level == base_level || level == base_level + 1) && !has_shaft_rows_;
    }
    /// True if records themselves look half a step to all sides: those of steps g, g / 2 and g / 4. A level
    /// more would find nothing that these miss.
    bool has_shaft_rows(int level) const {
        return level >= base_level && level <= finest_shaft_level && has_shaft_rows_;
    }
    static constexpr int finest_shaft_level = base_level + 2;
    /// World units.
    double step(int level) const { return step_[static_cast<std::size_t>(level)]; }
    /// World units.
    const glm::dvec3& origin(int level) const { return origin_[static_cast<std::size_t>(level)]; }
    glm::vec3 position(const glm::ivec3& index, int level) const {
        const auto l = static_cast<std::size_t>(level);
        return glm::vec3(origin_[l] + step_[l] * glm::dvec3(index));
    }
    /// The position of a point in steps from the origin.
    glm::dvec3 locate(const glm::vec3& point, int level) const {
        const auto l = static_cast<std::size_t>(level);
        const glm::dvec3 offset = glm::dvec3(point) - origin_[l];
        return {rounded(offset.x * per_step_[l]), rounded(offset.y * per_step_[l]),
                rounded(offset.z * per_step_[l])};
    }

    /// Throws std::out_of_range that names the point if lattice points around it have no index.
    void check_inside(const glm::vec3& point) const {
        const auto l = static_cast<std::size_t>(finest_);
        const glm::dvec3 offset = glm::dvec3(point) - origin_[l];
        const double limit = step_[l] * (max_index - 64.0);
        if (!(std::abs(offset.x) < limit && std::abs(offset.y) < limit && std::abs(offset.z) < limit))
            throw_outside(point);
    }

private:
    [[noreturn]] void throw_outside(const glm::vec3& point) const {
        throw std::out_of_range(
            "lightmesh: point " + to_text(point) + " lies outside the lattice, which reaches " +
            to_text(step(finest_) * max_index) +
            " to all sides of its origin; a greater spacing or less detail reaches farther");
    }

    std::array<double, level_count> step_{};
    std::array<double, level_count> per_step_{};
    std::array<glm::dvec3, level_count> origin_{};
    int finest_ = base_level;
    bool has_shaft_rows_ = false;
};

}  // namespace lightmesh::detail
