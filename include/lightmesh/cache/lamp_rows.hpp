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

/// Values of a tile's lights, a byte each.
using TileValues = std::array<std::uint8_t, lamps_per_tile>;

/// Finds which shares of lamps are open: bytes of a row, 0 to 255.
template <Intersector Tracer>
class LampRays {
public:
    LampRays(const Tracer& tracer, const LampTable& lamps, std::size_t tile, const RowOrigin& origin)
        : tracer_(tracer), lamps_(lamps), tile_(tile), origin_(origin) {}

    /// The lights in `wanted`, by `first_rays` each, and twice as many as long as those disagree, up to
    /// `most_rays`.
    void find(std::uint64_t wanted, std::size_t first_rays, std::size_t most_rays, TileValues& values) {
        for (std::size_t first = 0; first < most_rays && wanted != 0;) {
            const std::size_t until = (std::min)(first == 0 ? first_rays : 2 * first, most_rays);
            for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1)
                add_rays(static_cast<std::size_t>(std::countr_zero(rest)), first, until);
            flush();
            std::uint64_t mixed = 0;
            for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
                const auto l = static_cast<std::size_t>(std::countr_zero(rest));
                const std::uint32_t sum = sums_[l];
                values[l] = static_cast<std::uint8_t>((510u * open_[l] + sum) / (2u * (std::max)(sum, 1u)));
                if (open_[l] != 0 && open_[l] != sum)
                    mixed |= rest & (~rest + 1u);
            }
            wanted = mixed;
            first = until;
        }
    }

    /// One ray to the middle of each light in `wanted` that does not lie below: 0, 255; 128 if it does.
    void probe(std::uint64_t wanted, TileValues& values) {
        for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const Lamp& lamp = lamp_of(l);
            if (!lamp.is_below(origin_.place, origin_.unit_normal))
                add(l, Lamp::View(lamp, origin_.place, 0, origin_.step, origin_.reach).middle_ray());
        }
        flush();
        for (std::uint64_t rest = wanted; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            values[l] = sums_[l] == 0 ? 128 : open_[l] != 0 ? 255 : 0;
        }
    }

    std::uint64_t rays() const { return rays_; }

private:
    const Lamp& lamp_of(std::size_t l) const { return lamps_.lamp(tile_ * lamps_per_tile + l); }

    void add_rays(std::size_t l, std::size_t first, std::size_t until) {
        const Lamp& lamp = lamp_of(l);
        if (lamp.is_below(origin_.place, origin_.unit_normal))
            return;
        const auto turn = static_cast<std::uint32_t>(mix_bits(origin_.seed ^ lamp.salt()) >> 32);
        const Lamp::View view(lamp, origin_.place, turn, origin_.step, origin_.reach);
        if (lamp.is_point()) {
            if (first == 0)
                add(l, view.middle_ray());
            return;
        }
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
            ++sums_[light_[i]];
            open_[light_[i]] += hit_[i] == 0 ? 1u : 0u;
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
    std::size_t count_ = 0;
    std::uint64_t rays_ = 0;
};

}  // namespace lightmesh::detail
