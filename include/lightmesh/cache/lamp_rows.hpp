// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/fill/trace.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace lightmesh::detail {

/// From where a row looks.
struct RowOrigin {
    glm::vec3 place;        ///< off the surface already
    glm::vec3 unit_normal;  ///< 0: in the air
    std::uint64_t seed;     ///< of the patterns
    double step;            ///< of the lattice
    double reach;           ///< the greatest length of a ray
};

/// For each light of a tile, from how many places it is seen, or not.
using SightCounts = std::array<std::uint8_t, lamps_per_tile>;

/// How many rays a row sends to each lamp.
struct RayPlan {
    bool has_rim;       ///< whether eight go to the lamp's rim, before all others
    std::size_t first;  ///< how many before it is asked whether they disagree
    std::size_t most;   ///< where they do

    /// For penumbrae as good as this many rays make them. Rays to the rim only tell whether there is a
    /// penumbra: of the values of its ends, where few rays are hidden or few are open, they miss little.
    static RayPlan full(std::size_t most) {
        if (most < 16)
            return {.has_rim = false, .first = most, .most = most};
        return {.has_rim = true, .first = 2, .most = most};
    }
    /// For what stands in for a record that does not fit, with little weight, or only to tell whether some of
    /// the lamp is seen: ten rays of coarse levels, eight of fine ones; more if `lamp_rays` is more than 64.
    static RayPlan glance(std::size_t lamp_rays, bool is_fine) {
        if (!is_fine && lamp_rays >= 16)
            return {.has_rim = true, .first = 2, .most = 2};
        const std::size_t most = (std::max)(lamp_rays / 8, (std::min)(lamp_rays, std::size_t{8}));
        return {.has_rim = false, .first = (std::min)(most, std::size_t{8}), .most = most};
    }
};

/// Finds which shares of lamps are open: bytes of a row, 0 to 255.
template <Intersector Tracer>
class LampRays {
public:
    LampRays(const Tracer& tracer, const LampTable& lamps, std::size_t tile, const RowOrigin& origin)
        : tracer_(tracer), lamps_(lamps), tile_(tile), origin_(origin) {}

    /// The lights in `wanted`, by the first rays of a plan each, and where any of those disagree by 16 and
    /// twice as many as long as they disagree, up to the most.
    void find(std::uint64_t wanted, const RayPlan& plan, TileValues& values) {
        std::size_t first = 0;
        for (std::size_t until = plan.first; wanted != 0;
             until = (std::min)((std::max)(2 * first, std::size_t{16}), plan.most)) {
            for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1)
                add_rays(static_cast<std::size_t>(std::countr_zero(rest)), first, until, plan.has_rim);
            flush();
            std::uint64_t mixed = 0;
            for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
                const auto l = static_cast<std::size_t>(std::countr_zero(rest));
                values[l] = plan.most == 2 ? value_with_rim(l) : value(l);
                const bool sees_open = open_[l] + rim_open_[l] != 0;
                const bool sees_closed = open_[l] + rim_open_[l] != sums_[l] + rim_sums_[l];
                if (sees_open && sees_closed)
                    mixed |= rest & (~rest + 1u);
            }
            if (until == plan.most)
                return;
            wanted = mixed;
            first = until;
        }
    }

    /// One ray to the i-th part of each light in `wanted` that does not lie below, counted with the open or
    /// the closed ones.
    void probe(std::uint64_t wanted, std::size_t i, SightCounts& open, SightCounts& closed) {
        for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const Lamp& lamp = lamp_of(l);
            if (lamp.is_below(origin_.place, origin_.unit_normal))
                continue;
            const Lamp::View view = view_of(lamp);
            add(l, lamp.is_point() ? view.middle_ray() : view.ray(i));
        }
        flush();
        for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            open[l] = static_cast<std::uint8_t>(open[l] + open_[l]);
            closed[l] = static_cast<std::uint8_t>(closed[l] + sums_[l] - open_[l]);
        }
    }

    std::uint64_t rays() const { return rays_; }

private:
    /// Of a ray in a batch, beside its light's number.
    static constexpr std::size_t rim_flag = 128;

    const Lamp& lamp_of(std::size_t l) const { return lamps_.lamp(tile_ * lamps_per_tile + l); }

    Lamp::View view_of(const Lamp& lamp) const {
        return Lamp::View(lamp, origin_.place, static_cast<std::uint32_t>(origin_.seed >> 32), origin_.step,
                          origin_.reach);
    }

    /// The share of rays that are open.
    std::uint8_t value(std::size_t l) const {
        const std::uint32_t sum = sums_[l];
        return static_cast<std::uint8_t>((510u * open_[l] + sum) / (2u * (std::max)(sum, 1u)));
    }
    /// The same of two rays, which stand for the inner half of the lamp, and eight to its rim.
    std::uint8_t value_with_rim(std::size_t l) const {
        if (rim_sums_[l] == 0)
            return value(l);
        return static_cast<std::uint8_t>((255u * (4u * open_[l] + rim_open_[l]) + 8u) / 16u);
    }

    void add_rays(std::size_t l, std::size_t first, std::size_t until, bool has_rim) {
        const Lamp& lamp = lamp_of(l);
        if (lamp.is_below(origin_.place, origin_.unit_normal))
            return;
        const Lamp::View view = view_of(lamp);
        if (lamp.is_point()) {
            if (first == 0)
                add(l, view.middle_ray());
            return;
        }
        if (first == 0 && has_rim)
            for (std::size_t i = 0; i < 8; ++i)
                add(l | rim_flag, view.rim_ray(i));
        for (std::size_t i = first; i < until; ++i)
            add(l, view.ray(i));
    }

    void add(std::size_t l, const Segment& segment) {
        segments_[count_] = segment;
        light_[count_++] = static_cast<std::uint8_t>(l);
        if (count_ == segments_.size())
            flush();
    }

    void flush() {
        trace(tracer_, std::span<const Segment>(segments_).first(count_),
              std::span<std::uint8_t>(hit_).first(count_));
        for (std::size_t i = 0; i < count_; ++i) {
            const std::uint32_t open = hit_[i] == 0 ? 1u : 0u;
            const std::size_t l = light_[i] & (rim_flag - 1);
            const bool is_rim = (light_[i] & rim_flag) != 0;
            ++(is_rim ? rim_sums_ : sums_)[l];
            (is_rim ? rim_open_ : open_)[l] += open;
        }
        rays_ += count_;
        count_ = 0;
    }

    const Tracer& tracer_;
    const LampTable& lamps_;
    std::size_t tile_;
    RowOrigin origin_;
    std::array<Segment, most_segments> segments_;
    std::array<std::uint8_t, most_segments> light_;
    std::array<std::uint8_t, most_segments> hit_;
    std::array<std::uint32_t, lamps_per_tile> sums_{};
    std::array<std::uint32_t, lamps_per_tile> open_{};
    std::array<std::uint32_t, lamps_per_tile> rim_sums_{};
    std::array<std::uint32_t, lamps_per_tile> rim_open_{};
    std::size_t count_ = 0;
    std::uint64_t rays_ = 0;
};

}  // namespace lightmesh::detail
