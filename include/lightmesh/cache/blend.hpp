// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/cell_values.hpp>
#include <lightmesh/cache/lanes.hpp>
#include <lightmesh/cache/taps.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// Blended values are integers of 16 bits: 256 for each of a byte's steps.
inline constexpr std::uint32_t one_value = 255u * 256u;

/// The greatest weighted difference between one record and their blend, of one_value, up to which a level
/// does without the next one: .03, .1 and .15, for levels of g, of g / 2, and finer ones. Where coarse
/// records nearly agree they may miss most, and finer ones cost most and mend least. It gives way wholly
/// where the difference is greater by spread_range. Below a blend of one half the difference counts more, up
/// to twice as much in the dark, where the eye sees less light.
inline constexpr std::array<std::uint32_t, 3> spread_lows{1958, 6528, 9792};
inline constexpr std::uint32_t spread_range = 16384;  // .25

/// The values of probes beside 0 and 255, closed and open: some rays of a cell are open and some closed, or
/// there is none.
inline constexpr std::uint8_t probe_sees_both = 127;
inline constexpr std::uint8_t probe_knows_nothing = 128;

/// Bytes beyond which all records of a cell are open, or up to which they are closed, where its probe says
/// the contrary.
inline constexpr std::uint32_t open_from = 153;
inline constexpr std::uint32_t closed_to = 102;

/// The visibilities of a tile of lights on their way from level to level: for each light what is found, and
/// how much of one_weight is left for finer levels. Compilers for processors without AVX would align these
/// less than kernels for those with it need.
struct alignas(32) Blend {
    std::array<Lanes, 8> found;
    std::array<Lanes, 8> left;
};

/// The records of a cell that serve a point, with weights that sum to one_weight, and what makes a level give
/// way to the next one.
struct BlendLevel {
    const CellValues* values = nullptr;
    std::size_t taps = 0;
    /// Of the cell's; beyond the taps, up to a multiple of four, any of them, with a weight of 0.
    std::array<std::uint8_t, 8> records;
    std::array<std::uint32_t, 8> weights;
    std::uint32_t spread_low = spread_lows[0];  ///< of `spread_lows`
    std::uint32_t force = 0;                    ///< least share of the next level, of one_weight
    std::uint32_t fade = static_cast<std::uint32_t>(one_weight);  ///< greatest share of the next level
    bool is_last = false;
    std::uint32_t window = 0;  ///< weight of the cell's probe; 0: it is not asked
    std::uint64_t misses = 0;  ///< the lights of which any record does not tell what lies around it
    /// Least share of the next level for lights that any of the records sees: for want of records that fit.
    std::uint32_t missing = 0;

    void set(std::size_t tap, std::size_t record, std::uint32_t weight) {
        records[tap] = static_cast<std::uint8_t>(record);
        weights[tap] = weight;
    }
    /// After the taps are set.
    void pad() {
        for (std::size_t tap = taps; tap % 4 != 0; ++tap)
            set(tap, records[0], 0);
    }
    /// By how much a difference between a record and the blend counts: four times the record's weight, at
    /// most one_weight.
    std::uint32_t spread_weight(std::size_t tap) const {
        return (std::min)(4 * weights[tap], static_cast<std::uint32_t>(one_weight));
    }
    /// Least share of the next level for lights of which this record does not tell what lies around it.
    std::uint32_t miss_weight(std::size_t tap) const {
        return (std::min)(8 * weights[tap], static_cast<std::uint32_t>(one_weight));
    }
};

/// True if the probe of a cell says the contrary of what its records say: something else, or, where they all
/// say that a lamp is wholly open or wholly closed, not quite that.
inline bool is_light_missed(std::uint32_t probe, std::uint32_t least, std::uint32_t greatest) {
    return (probe == 0 && least > open_from) || (probe == 255 && greatest < closed_to) ||
           (probe == probe_sees_both && (least == 255 || greatest == 0));
}

/// The same for an octet: marks the lights that are missed.
inline void mark_missed(Lanes& marks, const Lanes& probe, const Lanes& least, const Lanes& greatest) {
    marks |= ((probe == 0) & (least > open_from)) | ((probe == 255u) & (greatest < closed_to)) |
                     ((probe == probe_sees_both) & ((least == 255u) | (greatest == 0u)))
                 ? Lanes{} + 1u
                 : Lanes{};
}

}  // namespace lightmesh::detail
