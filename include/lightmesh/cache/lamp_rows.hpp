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
#include <cstdlib>
#include <new>
#include <span>

namespace lightmesh::detail {

/// The most rays that a record takes to one lamp whose `lamp_rays` are halved so many times, at most twice,
/// but not below 16.
inline std::size_t most_rays(int lamp_rays, int halvings) {
    return static_cast<std::size_t>(
        (std::max)(lamp_rays >> std::clamp(halvings, 0, 2), (std::min)(lamp_rays, 16)));
}

/// From where a row looks.
struct RowOrigin {
    glm::vec3 position;     ///< off the surface already
    glm::vec3 unit_normal;  ///< 0: in the air
    std::uint64_t seed;     ///< of the patterns
    double step;            ///< of the lattice
    double reach;           ///< the greatest length of a ray
};

/// The number of rays that a row sends to each lamp.
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

/// From where rays tell a row: from the record itself, or from places around it, one ray from each to its own
/// part of a lamp, or first from these.
struct RowLook {
    /// The use of rays from places around.
    enum class Around {
        no,
        only,   ///< all there is: a probe
        first,  ///< where all of them agree the record does, too: a shaft row
    };

    Around around = Around::no;
    RowOrigin origin{};  ///< of the record itself
    RayPlan plan{};      ///< for rays from there
    static constexpr std::size_t most_places = 16;
    std::size_t place_count = 0;
    std::size_t rays_of_place = 1;
    std::size_t parts_apart = most_places;         ///< of a lamp, between two rays of a place
    std::array<RowOrigin, most_places> places{};   ///< where there is a surface
    std::array<std::uint8_t, most_places> part{};  ///< of a lamp, for each of them

    void add_place(std::size_t part_of_lamp, const RowOrigin& place) {
        part[place_count] = static_cast<std::uint8_t>(part_of_lamp);
        places[place_count++] = place;
    }
};

/// Which rays tell what shares of a tile's lamps are open, round by round, and what they have told. Knows no
/// tracer.
class LampTally {
public:
    /// Of the lights in `wanted`.
    LampTally(const LampTable& lamps, std::size_t tile, const RowLook& look, std::uint64_t wanted)
        : lamps_(&lamps), tile_(tile), look_(look), wanted_(wanted),
          is_around_(look.around != RowLook::Around::no) {
        if (!is_around_)
            begin_plan();
    }

    /// Calls add(ray, make) for the rays of a round: make() gives the segment, and `take` is to be told of
    /// each. From the record itself go the first rays of the plan to each light, and where any of those
    /// disagree the most.
    template <class Add>
    void list_round(Add&& add) const {
        // Light by light: what runs side by side, tracers of packets do at once.
        for (std::uint64_t rest = wanted_; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            if (is_around_)
                list_rays_around(l, add);
            else
                list_rays(l, add);
        }
    }
    /// Writes the values that all rays so far give: 0 to 255, or what a probe says. Returns whether it takes
    /// another round.
    bool end_round(TileValues& values) {
        if (is_around_)
            return end_around(values);
        std::uint64_t mixed = 0;
        for (std::uint64_t rest = wanted_; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const std::uint64_t light = rest & (~rest + 1u);
            const std::uint8_t around = values[l];
            values[l] = look_.plan.most == 2 ? value_with_rim(l) : value(l);
            const bool sees_open = open_[l] + rim_open_[l] != 0;
            const bool sees_closed = open_[l] + rim_open_[l] != sums_[l] + rim_sums_[l];
            if (first_ == 0 && (doubted_ & light) != 0 &&
                (!sees_open || !sees_closed || std::abs(values[l] - around) > most_apart))
                missing_ |= light;
            if (sees_open && sees_closed && (missing_ & light) == 0)
                mixed |= light;
        }
        if (until_ != look_.plan.most && mixed != 0) {
            wanted_ = mixed;
            // More rays never make them agree.
            first_ = until_;
            until_ = look_.plan.most;
            return true;
        }
        for (std::uint64_t rest = unsettled_; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            values[l] = shaft_byte(values[l], (missing_ >> l & 1u) != 0);
        }
        return false;
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

    /// The most by which what rays around a record say may differ from what the record itself says: one ray
    /// of sixteen.
    static constexpr int most_apart = 16;

    using Counts = std::array<std::uint16_t, lamps_per_tile>;

    void begin_plan() {
        is_around_ = false;
        first_ = 0;
        until_ = look_.plan.first;
    }

    /// The rays of each place that a light does not lie below, to parts of it that are the place's own.
    template <class Add>
    void list_rays_around(std::size_t l, Add&& add) const {
        const Lamp& lamp = lamp_of(l);
        for (std::size_t i = 0; i < look_.place_count; ++i) {
            const RowOrigin& origin = look_.places[i];
            if (lamp.is_below(origin.position, origin.unit_normal))
                continue;
            const Lamp::View view = view_of(lamp, origin);
            if (lamp.is_point()) {
                add(static_cast<std::uint8_t>(l), [&] { return view.middle_ray(); });
                continue;
            }
            for (std::size_t k = 0; k < look_.rays_of_place; ++k)
                add(static_cast<std::uint8_t>(l),
                    [&] { return view.ray(look_.part[i] + k * look_.parts_apart); });
        }
    }
    /// After those: what a probe says, or what is left for rays from the record itself.
    bool end_around(TileValues& values) {
        for (std::uint64_t rest = wanted_; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const std::uint64_t light = rest & (~rest + 1u);
            const bool sees_both = open_[l] != 0 && open_[l] != sums_[l];
            values[l] = value(l);
            if (look_.around == RowLook::Around::only) {
                if (sees_both || sums_[l] == 0)
                    values[l] = sees_both ? probe_sees_both : probe_knows_nothing;
            } else if (sees_both || sums_[l] < enough(l) || (open_[l] != 0 && is_below_origin(l))) {
                unsettled_ |= light;
                doubted_ |= sees_both ? light : 0;
                sums_[l] = open_[l] = 0;
            }
        }
        wanted_ = unsettled_;
        begin_plan();
        return wanted_ != 0;
    }

    const Lamp& lamp_of(std::size_t l) const { return lamps_->lamp(tile_ * lamps_per_tile + l); }

    /// Rays of half of all places, which must agree to settle a light.
    std::size_t enough(std::size_t l) const {
        return look_.parts_apart * (lamp_of(l).is_point() ? 1 : look_.rays_of_place) / 2;
    }

    /// True if the record sees nothing of a light, whatever places on a slope around it see.
    bool is_below_origin(std::size_t l) const {
        return lamp_of(l).is_below(look_.origin.position, look_.origin.unit_normal);
    }

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
        const RowOrigin& origin = look_.origin;
        const Lamp& lamp = lamp_of(l);
        if (lamp.is_below(origin.position, origin.unit_normal))
            return;
        const Lamp::View view = view_of(lamp, origin);
        const auto ray = static_cast<std::uint8_t>(l);
        if (lamp.is_point()) {
            if (first_ == 0)
                add(ray, [&] { return view.middle_ray(); });
            return;
        }
        if (first_ == 0 && look_.plan.has_rim)
            for (std::size_t i = 0; i < 8; ++i)
                add(static_cast<std::uint8_t>(ray | rim_flag), [&] { return view.rim_ray(i); });
        for (std::size_t i = first_; i < until_; ++i)
            add(ray, [&] { return view.ray(i); });
    }

    const LampTable* lamps_;
    std::size_t tile_;
    RowLook look_;
    std::uint64_t wanted_;
    std::uint64_t unsettled_ = 0;  ///< the lights that places around do not settle
    std::uint64_t doubted_ = 0;    ///< of them those that some of these see and some do not
    std::uint64_t missing_ = 0;    ///< of them those of which the record itself tells something else
    bool is_around_;               ///< whether rays from there are next
    std::size_t first_ = 0;        ///< rays of a round
    std::size_t until_ = 0;
    Counts sums_{}, open_{}, rim_sums_{}, rim_open_{};
};

/// Finds which shares of lamps are open by rays of the user's tracer.
template <Intersector Tracer>
class LampRays {
public:
    explicit LampRays(const Tracer& tracer) : tracer_(tracer) {}

    /// Writes the values of some lights of a tile, 0 to 255, or what a probe says.
    void find(const LampTable& lamps, std::size_t tile, const RowLook& look, std::uint64_t wanted,
              TileValues& values) {
        if (wanted == 0)
            return;
        LampTally tally(lamps, tile, look, wanted);
        do {
            tally.list_round([&](std::uint8_t ray, const auto& make) { add(ray, make, tally); });
            flush(tally);
        } while (tally.end_round(values));
    }

    std::uint64_t rays() const { return rays_; }

private:
    template <class Make>
    void add(std::uint8_t ray, const Make& make, LampTally& tally) {
        // Made in its place: to copy what was written in smaller parts takes long.
        new (&segments_[count_]) Segment(make());
        ray_[count_++] = ray;
        if (count_ == segments_.size())
            flush(tally);
    }

    void flush(LampTally& tally) {
        trace(tracer_, std::span<const Segment>(segments_).first(count_),
              std::span<std::uint8_t>(hit_).first(count_));
        for (std::size_t i = 0; i < count_; ++i)
            tally.take(ray_[i], hit_[i] == 0);
        rays_ += count_;
        count_ = 0;
    }

    const Tracer& tracer_;
    std::array<Segment, most_segments> segments_;
    std::array<std::uint8_t, most_segments> ray_;
    std::array<std::uint8_t, most_segments> hit_;
    std::size_t count_ = 0;
    std::uint64_t rays_ = 0;
};

}  // namespace lightmesh::detail
