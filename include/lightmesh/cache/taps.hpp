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
    std::array<Facing, 3> all;
    std::array<std::int32_t, 3> weights{};
    int count = 0;
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
        const auto i = static_cast<std::size_t>(found.count++);
        found.all[i] = {axis, unit_normal[axis] < 0.0f ? -1.0f : 1.0f};
        found.weights[i] = weight;
        sum += weight;
    }
    std::int32_t rest = one_weight;
    for (std::size_t i = 1; i < static_cast<std::size_t>(found.count); ++i) {
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

    bool operator==(const CellCorners& other) const {
        std::int32_t difference = (u ^ other.u) | (v ^ other.v);
        for (std::size_t k = 0; k < 4; ++k)
            difference |= along[k] ^ other.along[k];
        return difference == 0;
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

inline CellStencil stencil_at(const Lattice& lattice, const glm::vec3& point, const TangentPlane& tangent,
                              int level) {
    const glm::dvec3 located = lattice.locate(point, level);
    const double u = located[tangent.facing.u()];
    const double v = located[tangent.facing.v()];
    // Upwards, or downwards where the facing's sign is negative.
    const bool is_up = tangent.facing.sign > 0.0f;
    const double height = is_up ? -located[tangent.facing.axis] : located[tangent.facing.axis];
    CellStencil stencil;
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
        return stencil;
    }
    const double sign = is_up ? 1.0 : -1.0;
    const std::array<double, 2> rise_u{sign * static_cast<double>(fu) * tangent.slope_u,
                                       sign * static_cast<double>(fu - 1.0f) * tangent.slope_u};
    const std::array<double, 2> rise_v{sign * static_cast<double>(fv) * tangent.slope_v,
                                       sign * static_cast<double>(fv - 1.0f) * tangent.slope_v};
    for (std::size_t k = 0; k < 4; ++k)
        corners.along[k] = first_before(height - (rounded(rise_u[k & 1]) + rounded(rise_v[k >> 1])));
    return stencil;
}

/// How well a record fits a point, 0 to 256, and whether something may lie between them.
struct Fit {
    std::int32_t share = 0;
    bool is_suspect = false;
};

/// A record fits if it lies near the point's tangent plane and its normal is similar; both fade.
inline Fit fit_of(const glm::vec3& position, const glm::vec3& normal, const glm::vec3& point,
                  const glm::vec3& unit_normal, double step) {
    const glm::dvec3 offset(position - point);
    const glm::dvec3 n(unit_normal);
    const glm::dvec3 m(normal);
    const double before = n.x * offset.x + n.y * offset.y + n.z * offset.z;
    const double behind = m.x * offset.x + m.y * offset.y + m.z * offset.z;
    const double cosine = n.x * m.x + n.y * m.y + n.z * m.z;
    const double near_plane = (0.45 * step - std::abs(before)) * (5.0 / step);
    const double similar = (cosine - 0.65) * 10.0;
    Fit fit;
    fit.share = static_cast<std::int32_t>(256.0 * std::clamp(near_plane, 0.0, 1.0)) *
                    static_cast<std::int32_t>(256.0 * std::clamp(similar, 0.0, 1.0)) >>
                8;
    // Of two places on one surface either both lie before the other's plane, in a hollow, or neither. The
    // floor under a sheet is behind the sheet, and the sheet before the floor.
    const double least = 0.003 * step + static_cast<double>(largest_component(point)) * 0x1p-21;
    fit.is_suspect = before > least && behind > least;
    return fit;
}

}  // namespace lightmesh::detail
