// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/support/rounded.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

/// Which records serve a point, and with what weights. Weights are integers, one_weight for 1, and what they
/// are made of is exact or rounded once: so they are the same whatever compiler and processor.

namespace lightmesh::detail {

inline constexpr std::int32_t one_weight = 1 << 15;

inline std::int32_t weight_of(double share) {
    return floor_to_int(std::clamp(share, 0.0, 1.0) * one_weight + 0.5);
}

/// The facings of a point's records, with weights that sum to one_weight: against its normal's
/// greatest component, and against others within a tenth of that, so that nothing jumps where they change.
struct WeightedFacings {
    static constexpr std::size_t most = 3;

    std::array<Facing, most> all;
    std::array<std::int32_t, most> weights{};
    std::size_t count = 0;
};

inline WeightedFacings facings_of(const glm::vec3& unit_normal) {
    const double largest = static_cast<double>(largest_component(unit_normal));
    WeightedFacings found;
    std::int32_t sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const auto component = static_cast<double>(std::abs(unit_normal[axis]));
        if (component < 0.9 * largest)
            continue;
        const double ratio = component / largest;
        const std::int32_t weight = weight_of((ratio - 0.9) / 0.1);
        if (weight == 0)
            continue;
        const std::size_t i = found.count++;
        found.all[i] = {axis, unit_normal[axis] < 0.0f ? -1.0f : 1.0f};
        found.weights[i] = weight;
        sum += weight;
    }
    std::int32_t rest = one_weight;
    for (std::size_t i = 1; i < found.count; ++i) {
        found.weights[i] =
            static_cast<std::int32_t>(static_cast<std::int64_t>(found.weights[i]) * one_weight / sum);
        rest -= found.weights[i];
    }
    found.weights[0] = rest;
    return found;
}

/// Four lattice points whose columns surround points: (0, 0), (1, 0), (0, 1), (1, 1) along (u, v).
struct CellCorners {
    std::int32_t u;                     ///< the lesser index along u
    std::int32_t v;                     ///< the lesser index along v
    std::array<std::int32_t, 4> along;  ///< the indices along the axis of the records' facing

    /// One after the other: they were written one by one a moment ago, and several at once would have to
    /// wait for that.
    bool operator==(const CellCorners& other) const {
        return u == other.u && v == other.v && along[0] == other.along[0] && along[1] == other.along[1] &&
               along[2] == other.along[2] && along[3] == other.along[3];
    }

    glm::ivec3 index(std::size_t k, const Facing& facing) const {
        glm::ivec3 index;
        index[facing.u()] = u + static_cast<std::int32_t>(k & 1);
        index[facing.v()] = v + static_cast<std::int32_t>(k >> 1);
        index[facing.axis] = along[k];
        return index;
    }
};

/// The cell of a point, each corner the first at least a quarter of a step before the point's tangent plane.
struct CellStencil {
    CellCorners corners;
    std::array<std::int32_t, 2> at;  ///< the point's coordinates in the cell, 0 to one_weight

    /// Bilinear weights, which sum to one_weight.
    std::array<std::int32_t, 4> weights() const {
        const std::int32_t both = static_cast<std::int32_t>(static_cast<std::uint32_t>(at[0]) *
                                                            static_cast<std::uint32_t>(at[1]) / one_weight);
        return {one_weight - at[0] - at[1] + both, at[0] - both, at[1] - both, both};
    }
};

/// The tangent plane of a point, as the lattice points of one facing see it.
struct TangentPlane {
    Facing facing;
    double slope_u = 0.0;
    double slope_v = 0.0;

    TangentPlane() = default;
    TangentPlane(const glm::vec3& unit_normal, const Facing& along)
        : facing(along), slope_u(static_cast<double>(unit_normal[along.u()] / unit_normal[along.axis])),
          slope_v(static_cast<double>(unit_normal[along.v()] / unit_normal[along.axis])) {}
};

inline void find_stencil(const Lattice& lattice, const glm::vec3& point, const TangentPlane& tangent,
                         int level, CellStencil& stencil) {
    const glm::dvec3 located = lattice.locate(point, level);
    const double u = located[tangent.facing.u()];
    const double v = located[tangent.facing.v()];
    // Upwards, or downwards where the facing's sign is negative.
    const bool is_up = tangent.facing.sign > 0.0f;
    const double height = is_up ? -located[tangent.facing.axis] : located[tangent.facing.axis];
    CellCorners& corners = stencil.corners;
    corners.u = floor_to_int(u);
    corners.v = floor_to_int(v);
    // Rounded to float, so that products below are exact.
    const auto fu = static_cast<float>(u - corners.u);
    const auto fv = static_cast<float>(v - corners.v);
    stencil.at = {static_cast<std::int32_t>(fu * static_cast<float>(one_weight)),
                  static_cast<std::int32_t>(fv * static_cast<float>(one_weight))};
    const auto first_before = [is_up](double plane) {
        const int below = floor_to_int(plane - 0.25);
        return is_up ? -below : below;
    };
    if (tangent.slope_u == 0.0 && tangent.slope_v == 0.0) {
        corners.along.fill(first_before(height));
        return;
    }
    const double sign = is_up ? 1.0 : -1.0;
    const std::array<double, 2> rise_u{sign * static_cast<double>(fu) * tangent.slope_u,
                                       sign * static_cast<double>(fu - 1.0f) * tangent.slope_u};
    const std::array<double, 2> rise_v{sign * static_cast<double>(fv) * tangent.slope_v,
                                       sign * static_cast<double>(fv - 1.0f) * tangent.slope_v};
    for (std::size_t k = 0; k < 4; ++k)
        corners.along[k] = first_before(height - (rounded(rise_u[k & 1]) + rounded(rise_v[k >> 1])));
}

/// Which links between a cell's lattice points are open, and where that leads to. Sets of lattice points are
/// masks of four bits.
struct CellLinks {
    std::uint32_t along_u = 0;  ///< bit 0: from 0 to 1; bit 2: from 2 to 3
    std::uint32_t along_v = 0;  ///< bit 0: from 0 to 2; bit 1: from 1 to 3

    bool are_all_open() const { return along_u == 5 && along_v == 3; }
    /// All that links lead to from some lattice points, without those to and from others.
    std::uint32_t reach(std::uint32_t from, std::uint32_t without) const {
        const std::uint32_t u = along_u & ~(without | without >> 1);
        const std::uint32_t v = along_v & ~(without | without >> 2);
        // No way is longer than three links, and u and v take turns.
        for (int pass = 0; pass < 2; ++pass) {
            from |= (from & u) << 1 | (from >> 1 & u);
            from |= (from & v) << 2 | (from >> 2 & v);
        }
        return from;
    }
};

/// The places of the records of a cell's four columns, and their normals, side by side.
struct CellSurface {
    std::array<float, 4> x, y, z;
    std::array<float, 4> normal_x, normal_y, normal_z;  ///< 0 where there is no surface

    void set(std::size_t k, const glm::vec3& position, const glm::vec3& normal) {
        x[k] = position.x;
        y[k] = position.y;
        z[k] = position.z;
        normal_x[k] = normal.x;
        normal_y[k] = normal.y;
        normal_z[k] = normal.z;
    }
};

/// The fit of records to a point, 0 to 256, and between which of them and the point something may lie, or
/// clearly nothing of what the record lies on. One bit for each.
struct Fits {
    std::array<std::int32_t, 4> shares;
    std::array<std::int32_t, 4> alike;  ///< by normals alone
    std::uint32_t suspect;
    std::uint32_t clear;

    /// True if nothing stands out between the point and the records, if links between these are open: all fit
    /// it, or one does wholly, and no other one
    /// contradicts.
    bool are_enough() const {
        std::uint32_t wholly = 0;
        std::uint32_t at_all = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            wholly |= static_cast<std::uint32_t>(shares[k] == 256) << k;
            at_all |= static_cast<std::uint32_t>(shares[k] != 0) << k;
        }
        return suspect == 0 && (at_all == 15 || (wholly != 0 && (wholly | clear) == 15));
    }
};

/// A record fits if it lies near the point's tangent plane and its normal is similar; both fade.
inline Fits fits_of(const CellSurface& surface, const glm::vec3& point, const glm::vec3& unit_normal,
                    double step) {
    using Floats [[gnu::vector_size(16)]] = float;
    using Integers [[gnu::vector_size(16)]] = std::int32_t;
    using Doubles [[gnu::vector_size(32)]] = double;
    const auto load = [](const std::array<float, 4>& values, Doubles& doubles, float less) {
        Floats floats;
        std::memcpy(&floats, values.data(), sizeof floats);
        doubles = __builtin_convertvector(floats - less, Doubles);
    };
    Doubles x, y, z, m_x, m_y, m_z;
    load(surface.x, x, point.x);
    load(surface.y, y, point.y);
    load(surface.z, z, point.z);
    load(surface.normal_x, m_x, 0.0f);
    load(surface.normal_y, m_y, 0.0f);
    load(surface.normal_z, m_z, 0.0f);
    const glm::dvec3 n(unit_normal);
    const Doubles before = n.x * x + n.y * y + n.z * z;
    const Doubles behind = m_x * x + m_y * y + m_z * z;
    const Doubles cosine = n.x * m_x + n.y * m_y + n.z * m_z;
    const Doubles distance = before < 0.0 ? -before : before;
    const auto parts_of_256 = [](const Doubles& value, Integers& parts) {
        const Doubles least = value < 0.0 ? Doubles{} : value;
        parts = __builtin_convertvector(256.0 * (least > 1.0 ? Doubles{} + 1.0 : least), Integers);
    };
    Integers near_plane, alike;
    parts_of_256((rounded(0.45 * step) - distance) * (5.0 / step), near_plane);
    parts_of_256((cosine - 0.65) * 10.0, alike);
    const Integers shares = near_plane * alike >> 8;
    // Of two places on one surface either both lie before the other's plane, in a hollow, or neither. The
    // floor under a sheet is behind the sheet, and the sheet before the floor.
    const double least = rounded(0.003 * step) + static_cast<double>(largest_component(point)) * 0x1p-21;
    const auto is_suspect = (before > least) & (behind > least);
    // Where there is no surface the column is free until behind the point's plane.
    const auto is_clear =
        (before < -least) | (behind < -least) | ((m_x == 0.0) & (m_y == 0.0) & (m_z == 0.0));
    Fits fits;
    std::memcpy(fits.shares.data(), &shares, sizeof shares);
    std::memcpy(fits.alike.data(), &alike, sizeof alike);
    fits.suspect = 0;
    fits.clear = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        fits.suspect |= static_cast<std::uint32_t>(is_suspect[k] & 1) << k;
        fits.clear |= static_cast<std::uint32_t>(is_clear[k] & 1) << k;
    }
    return fits;
}

/// The same for one record: only how well it fits.
inline std::int32_t fit_of(const glm::vec3& position, const glm::vec3& normal, const glm::vec3& point,
                           const glm::vec3& unit_normal, double step) {
    CellSurface surface;
    for (std::size_t k = 0; k < 4; ++k)
        surface.set(k, position, normal);
    return fits_of(surface, point, unit_normal, step).shares[0];
}

}  // namespace lightmesh::detail
