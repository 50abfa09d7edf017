// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/cache/fall.hpp>
#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/lamp_rows.hpp>
#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// A place moved off its surface: by some roundings of its coordinates and 2^-14 steps.
inline glm::vec3 off_surface(const glm::vec3& position, const glm::vec3& unit_normal, double step) {
    return position +
           (largest_component(position) * 0x1p-20f + static_cast<float>(step * 0x1p-14)) * unit_normal;
}

/// The greatest length of a ray, as far as segments to the sky go.
inline double greatest_reach(const Lattice& lattice) {
    return 0x1p24 * lattice.step(Lattice::base_level);
}

/// Finds which shares of lamps are open from a surface point itself.
template <Intersector Tracer>
class PointRays {
public:
    PointRays(const Tracer& tracer, const Lattice& lattice, const LampTable& lamps,
              const CacheSettings& settings)
        : tracer_(tracer), lamps_(lamps), step_(lattice.step(lattice.finest_level())),
          reach_(greatest_reach(lattice)), lamp_rays_(settings.lamp_rays) {}

    void find(const glm::vec3& point, const glm::vec3& unit_normal, std::size_t tile, std::uint64_t wanted,
              TileValues& values) {
        find_from(off_surface(point, unit_normal, step_), unit_normal, point, tile, wanted, full_plan(),
                  values);
    }

    /// The same in place of records that do not serve the point: by eight rays, and where those disagree by
    /// as many as records of the finest levels take.
    void stand_in(const glm::vec3& point, const glm::vec3& unit_normal, std::size_t tile,
                  std::uint64_t wanted, TileValues& values) {
        const std::size_t most = most_rays(lamp_rays_, 2);
        const RayPlan plan{.has_rim = false, .first = (std::min)(most, std::size_t{8}), .most = most};
        find_from(off_surface(point, unit_normal, step_), unit_normal, point, tile, wanted, plan, values);
    }

    /// The same for a point of a smooth surface that coarse facets stand for: rays start on that surface, as
    /// far above the facet as it takes to clear it, and lamps are seen as its normal sees them.
    void find(const glm::vec3& point, const glm::vec3& unit_normal, const glm::vec3& smooth_normal,
              std::size_t tile, std::uint64_t wanted, TileValues& values) {
        for (; wanted != 0; wanted &= wanted - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(wanted));
            const Lamp& lamp = lamps_.lamp(tile * lamps_per_tile + l);
            find_from(lifted(point, unit_normal, smooth_normal, lamp), smooth_normal, point, tile,
                      wanted & (~wanted + 1u), full_plan(), values);
        }
    }

    std::uint64_t rays() const { return rays_; }

private:
    RayPlan full_plan() const { return RayPlan::full(static_cast<std::size_t>(lamp_rays_)); }

    void find_from(const glm::vec3& start, const glm::vec3& unit_normal, const glm::vec3& point,
                   std::size_t tile, std::uint64_t wanted, const RayPlan& plan, TileValues& values) {
        LampRays<Tracer> rays(tracer_);
        RowLook look;
        look.origin = {start, unit_normal, seed_at(point), step_, reach_};
        look.plan = plan;
        rays.find(lamps_, tile, look, wanted, values);
        rays_ += rays.rays();
    }

    /// The bits that turn the pattern of rays: one for all within a 64th of the finest step, so that points
    /// which differ by the rounding of an intersection, as from another tracer, mostly have the same.
    std::uint64_t seed_at(const glm::vec3& point) const {
        const auto bits = [&](float coordinate) {
            return std::bit_cast<std::uint64_t>(std::floor(static_cast<double>(coordinate) * (64.0 / step_)));
        };
        return mix_bits(bits(point.x) ^ std::rotl(bits(point.y), 21) ^ std::rotl(bits(point.z), 42));
    }

    /// A point moved from its facet to the smooth surface, or beyond: where rays to a lamp below the facet's
    /// plane clear facets that bend away. How much that takes, the way through the solid to where it leaves
    /// towards the lamp tells: the solid does not rise above the planes at both of its ends. (Hanika,
    /// "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021, has the vertices to do it with.) Behind a
    /// wall that does not bend away, or is not closed, such a ray stays blocked.
    glm::vec3 lifted(const glm::vec3& point, const glm::vec3& unit_normal, const glm::vec3& smooth_normal,
                     const Lamp& lamp) {
        const glm::vec3 start = off_surface(point, unit_normal, step_);
        const Lamp::LowestPart lowest = lamp.lowest_part(point, unit_normal, reach_);
        const double sine = -glm::dot(glm::dvec3(unit_normal), lowest.direction);
        if (sine <= 0.0)
            return start;
        const auto out = find_exit(tracer_, off_surface(point, -unit_normal, step_), lowest.direction,
                                   lowest.length, rays_);
        if (!out)
            return start;
        // A ray is before the facet's plane at first, and from some place on before the plane where the way
        // leaves. The lift is one at which the second begins before the first ends.
        const glm::dvec3 lift(smooth_normal);
        const double rise = glm::dot(glm::dvec3(unit_normal), lift) / sine;
        const double sine_out = glm::dot(out->normal, lowest.direction);
        const double rise_out = glm::dot(out->normal, lift);
        const double both = rise + (rise_out > 0.0 ? rise_out / (std::max)(sine_out, 1e-3) : 0.0);
        // Seen from higher up, a lamp nearby lies lower.
        const double inside = (std::max)(1.0 - out->distance / lowest.length, 0.1);
        const glm::vec3 end = start +
                              static_cast<float>(1.02 * out->distance / (both * inside)) * smooth_normal +
                              (start - point);
        ++rays_;
        return tracer_.occluded({start, end}) ? start : end;
    }

    const Tracer& tracer_;
    const LampTable& lamps_;
    double step_;
    double reach_;
    int lamp_rays_;
    std::uint64_t rays_ = 0;
};

}  // namespace lightmesh::detail
