// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/cache/blend.hpp>
#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/segment.hpp>

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
    glm::vec3 position;     ///< off the surface already
    glm::vec3 unit_normal;  ///< 0: in the air
    std::uint64_t seed;     ///< of the patterns
    double step;            ///< of the lattice
    double reach;           ///< the greatest length of a ray
};

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

/// From where rays tell a row.
struct RowLook {
    bool is_probe = false;
    RayPlan plan{};                       ///< of a row that is no probe's: from the first origin
    std::size_t places = 0;               ///< of a probe
    std::array<RowOrigin, 16> origins{};  ///< of a probe the middles of parts of its cell or shaft
    std::array<bool, 16> is_there{};      ///< of a probe: whether there is a surface
};

/// Which rays tell what shares of a tile's lamps are open, round by round, and what they have told. Knows no
/// tracer.
class LampTally {
public:
    LampTally(const LampTable& lamps, std::size_t tile) : lamps_(&lamps), tile_(tile) {}

    /// Of the lights in `wanted` by the first rays of a plan each, and where any of those disagree by 16 and
    /// twice as many as long as they disagree, up to the most.
    void begin(const RowOrigin& origin, std::uint64_t wanted, const RayPlan& plan) {
        origin_ = origin;
        plan_ = plan;
        wanted_ = wanted;
        first_ = 0;
        until_ = plan.first;
    }
    /// Calls add(ray, segment) for the rays of a round: `take` is to be told of each.
    template <class Add>
    void list_round(Add&& add) const {
        for (std::uint64_t rest = wanted_; rest != 0; rest &= rest - 1)
            list_rays(static_cast<std::size_t>(std::countr_zero(rest)), add);
    }
    /// Writes the values that all rays so far give, 0 to 255. Returns whether it takes another round.
    bool end_round(TileValues& values) {
        std::uint64_t mixed = 0;
        for (std::uint64_t rest = wanted_; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            values[l] = plan_.most == 2 ? value_with_rim(l) : value(l);
            const bool sees_open = open_[l] + rim_open_[l] != 0;
            const bool sees_closed = open_[l] + rim_open_[l] != sums_[l] + rim_sums_[l];
            if (sees_open && sees_closed)
                mixed |= rest & (~rest + 1u);
        }
        if (until_ == plan_.most)
            return false;
        wanted_ = mixed;
        first_ = until_;
        until_ = (std::min)((std::max)(2 * first_, std::size_t{16}), plan_.most);
        return wanted_ != 0;
    }

    /// Calls add(ray, segment) for one ray from a place to the i-th part of each light in `wanted` that does
    /// not lie below.
    template <class Add>
    void list_part(const RowOrigin& origin, std::uint64_t wanted, std::size_t i, Add&& add) const {
        for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const Lamp& lamp = lamp_of(l);
            if (lamp.is_below(origin.position, origin.unit_normal))
                continue;
            const Lamp::View view = view_of(lamp, origin);
            add(static_cast<std::uint8_t>(l), lamp.is_point() ? view.middle_ray() : view.ray(i));
        }
    }
    /// Writes what rays to parts say together: 0, 255, `probe_sees_both` or `probe_knows_nothing`.
    void end_parts(std::uint64_t wanted, TileValues& values) const {
        for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            values[l] = sums_[l] == 0          ? probe_knows_nothing
                        : open_[l] == 0        ? std::uint8_t{0}
                        : open_[l] == sums_[l] ? std::uint8_t{255}
                                               : probe_sees_both;
        }
    }

    /// Counts a ray, by the name that it was listed under.
    void take(std::uint8_t ray, bool is_open) {
        const std::size_t l = ray & (rim_flag - 1);
        const bool is_rim = (ray & rim_flag) != 0;
        ++(is_rim ? rim_sums_ : sums_)[l];
        if (is_open)
            ++(is_rim ? rim_open_ : open_)[l];
    }

private:
    /// Of a ray, beside its light's number.
    static constexpr std::uint8_t rim_flag = 128;

    using Counts = std::array<std::uint16_t, lamps_per_tile>;

    const Lamp& lamp_of(std::size_t l) const { return lamps_->lamp(tile_ * lamps_per_tile + l); }

    static Lamp::View view_of(const Lamp& lamp, const RowOrigin& origin) {
        return Lamp::View(lamp, origin.position, static_cast<std::uint32_t>(origin.seed >> 32), origin.step,
                          origin.reach);
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

    template <class Add>
    void list_rays(std::size_t l, Add&& add) const {
        const Lamp& lamp = lamp_of(l);
        if (lamp.is_below(origin_.position, origin_.unit_normal))
            return;
        const Lamp::View view = view_of(lamp, origin_);
        const auto ray = static_cast<std::uint8_t>(l);
        if (lamp.is_point()) {
            if (first_ == 0)
                add(ray, view.middle_ray());
            return;
        }
        if (first_ == 0 && plan_.has_rim)
            for (std::size_t i = 0; i < 8; ++i)
                add(static_cast<std::uint8_t>(ray | rim_flag), view.rim_ray(i));
        for (std::size_t i = first_; i < until_; ++i)
            add(ray, view.ray(i));
    }

    const LampTable* lamps_;
    std::size_t tile_;
    RowOrigin origin_{};
    RayPlan plan_{};
    std::uint64_t wanted_ = 0;
    std::size_t first_ = 0;  ///< rays of a round
    std::size_t until_ = 0;
    Counts sums_{}, open_{}, rim_sums_{}, rim_open_{};
};

/// Finds which shares of lamps are open by rays of the user's tracer.
template <Intersector Tracer>
class LampRays {
public:
    LampRays(const Tracer& tracer, const LampTable& lamps, std::size_t tile)
        : tracer_(tracer), tally_(lamps, tile) {}

    /// As `LampTally::begin` says, all rounds.
    void find(const RowOrigin& origin, std::uint64_t wanted, const RayPlan& plan, TileValues& values) {
        if (wanted == 0)
            return;
        tally_.begin(origin, wanted, plan);
        do {
            tally_.list_round([this](std::uint8_t ray, const Segment& segment) { add(ray, segment); });
            flush();
        } while (tally_.end_round(values));
    }

    /// As `LampTally::list_part`.
    void find_part(const RowOrigin& origin, std::uint64_t wanted, std::size_t i) {
        tally_.list_part(origin, wanted, i,
                         [this](std::uint8_t ray, const Segment& segment) { add(ray, segment); });
        flush();
    }
    /// As `LampTally::end_parts`.
    void end_parts(std::uint64_t wanted, TileValues& values) const { tally_.end_parts(wanted, values); }

    std::uint64_t rays() const { return rays_; }

private:
    void add(std::uint8_t ray, const Segment& segment) {
        segments_[count_] = segment;
        ray_[count_++] = ray;
        if (count_ == segments_.size())
            flush();
    }

    void flush() {
        trace(tracer_, std::span<const Segment>(segments_).first(count_),
              std::span<std::uint8_t>(hit_).first(count_));
        for (std::size_t i = 0; i < count_; ++i)
            tally_.take(ray_[i], hit_[i] == 0);
        rays_ += count_;
        count_ = 0;
    }

    const Tracer& tracer_;
    LampTally tally_;
    std::array<Segment, most_segments> segments_;
    std::array<std::uint8_t, most_segments> ray_;
    std::array<std::uint8_t, most_segments> hit_;
    std::size_t count_ = 0;
    std::uint64_t rays_ = 0;
};

}  // namespace lightmesh::detail
