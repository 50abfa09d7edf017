// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/rounded.hpp>

#include <cmath>

/// Levels of a light mesh: level k is a mesh of radius 2^k r and as many light points per radius. Which of
/// them serve a point follows from its footprint alone.

namespace lightmesh::detail {

/// The settings of a level: those of a mesh with its radius.
inline Settings settings_of_level(const Settings& settings, int level) {
    Settings coarse = settings;
    coarse.radius = std::ldexp(settings.radius, level);
    return coarse;
}

/// S of a point between two levels.
inline float blended(float fine, float coarse, float coarse_share) {
    const auto from = static_cast<double>(fine);
    const auto to = static_cast<double>(coarse);
    return static_cast<float>(from + rounded(static_cast<double>(coarse_share) * (to - from)));
}

/// The level that serves a point, and how much of the next one is blended in.
struct LevelChoice {
    int level = 0;
    float coarser_share = 0.0f;

    bool is_between() const { return coarser_share > 0.0f; }
};

/// Chooses levels by footprints: the finest whose step is wider than `Settings::footprint_scale` footprints.
/// In the last fifth of an octave of footprints the next level is blended in, so that nothing jumps where
/// levels change.
class LevelRule {
public:
    /// Throws std::invalid_argument that names the value for a scale that is negative or not finite. Radius
    /// and quality must be right.
    explicit LevelRule(const Settings& settings) {
        require(settings.footprint_scale >= 0.0f && std::isfinite(settings.footprint_scale),
                "Settings::footprint_scale", settings.footprint_scale, "at least 0 and finite");
        steps_per_footprint_ = static_cast<double>(settings.footprint_scale) *
                               static_cast<double>(settings.quality) / static_cast<double>(settings.radius);
        while (coarsest_ + 1 < static_cast<int>(most_mesh_levels) &&
               std::ldexp(settings.radius, coarsest_ + 1) <= Grid::largest_coordinate)
            ++coarsest_;
    }

    /// Of level 0, in a footprint of 1 world unit, times `Settings::footprint_scale`.
    double steps_per_footprint() const { return steps_per_footprint_; }
    /// The last level; wider footprints, also infinite ones, are served by it.
    int coarsest() const { return coarsest_; }

    /// Level 0 for a footprint that is 0, negative or NaN.
    LevelChoice operator()(float footprint) const {
        // 2^-0.2
        constexpr double begin_of_blend = 0.8705505632961241;
        const double steps = static_cast<double>(footprint) * steps_per_footprint_;
        if (!(steps > begin_of_blend))
            return {};
        if (steps >= std::ldexp(0.5, coarsest_))
            return {coarsest_, 0.0f};
        LevelChoice choice;
        const double place_in_octave = std::frexp(steps, &choice.level);  // in [0.5, 1)
        if (place_in_octave > begin_of_blend)
            choice.coarser_share =
                static_cast<float>((place_in_octave - begin_of_blend) / (1.0 - begin_of_blend));
        return choice;
    }

private:
    double steps_per_footprint_ = 0.0;
    int coarsest_ = 0;
};

}  // namespace lightmesh::detail
