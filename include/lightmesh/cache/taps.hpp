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

/// The ways along which a point's records fall, with weights that sum to one_weight: against its normal's
/// greatest component, and against others within a tenth of that, so that nothing jumps where they change.
struct WeightedWays {
    std::array<Way, 3> ways;
    std::array<std::int32_t, 3> weights{};
    int count = 0;
};

inline WeightedWays ways_of(const glm::vec3& unit_normal) {
    const double largest = static_cast<double>(largest_component(unit_normal));
    WeightedWays found;
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
        found.ways[i] = {axis, unit_normal[axis] < 0.0f ? -1.0f : 1.0f};
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

/// The four lattice points whose columns surround a point, (0, 0), (1, 0), (0, 1), (1, 1) along (u, v), each
/// the first at least a quarter of a step before the point's tangent plane.
struct CellPlace {
    std::array<glm::ivec3, 4> index;
    std::array<float, 2> at;  ///< the point's place in the cell, 0 to 1

    /// Bilinear weights, which sum to about one_weight.
    std::array<std::int32_t, 4> weights() const {
        const auto u = static_cast<double>(at[0]);
        const auto v = static_cast<double>(at[1]);
        const auto other_u = static_cast<double>(1.0f - at[0]);
        const auto other_v = static_cast<double>(1.0f - at[1]);
        return {weight_of(other_u * other_v), weight_of(u * other_v), weight_of(other_u * v),
                weight_of(u * v)};
    }
};

/// The tangent plane of a point, as the lattice points along one way see it.
struct TangentPlane {
    Way way;
    double slope_u = 0.0;
    double slope_v = 0.0;

    TangentPlane() = default;
    TangentPlane(const glm::vec3& unit_normal, const Way& along)
        : way(along), slope_u(static_cast<double>(unit_normal[along.u()] / unit_normal[along.axis])),
          slope_v(static_cast<double>(unit_normal[along.v()] / unit_normal[along.axis])) {}
};

inline CellPlace place_in_cell(const Lattice& lattice, const glm::vec3& point, const TangentPlane& tangent,
                               int level) {
    const glm::dvec3 located = lattice.locate(point, level);
    const std::array<double, 3> x{located.x, located.y, located.z};
    const auto axis = static_cast<std::size_t>(tangent.way.axis);
    const auto u = static_cast<std::size_t>(tangent.way.u());
    const auto v = static_cast<std::size_t>(tangent.way.v());
    const int iu = floor_to_int(x[u]);
    const int iv = floor_to_int(x[v]);
    // Rounded to float, so that products below are exact.
    const auto fu = static_cast<float>(x[u] - iu);
    const auto fv = static_cast<float>(x[v] - iv);
    // Upwards, or downwards where the way's sign is negative.
    const double sign = static_cast<double>(tangent.way.sign);
    const std::array<double, 2> rise_u{static_cast<double>(fu) * tangent.slope_u,
                                       static_cast<double>(fu - 1.0f) * tangent.slope_u};
    const std::array<double, 2> rise_v{static_cast<double>(fv) * tangent.slope_v,
                                       static_cast<double>(fv - 1.0f) * tangent.slope_v};
    CellPlace place;
    place.at = {fu, fv};
    for (std::size_t k = 0; k < 4; ++k) {
        const double plane = x[axis] + (rounded(rise_u[k & 1]) + rounded(rise_v[k >> 1]));
        std::array<int, 3> index;
        index[u] = iu + static_cast<int>(k & 1);
        index[v] = iv + static_cast<int>(k >> 1);
        const int below = floor_to_int(-sign * plane - 0.25);
        index[axis] = tangent.way.sign > 0.0f ? -below : below;
        place.index[k] = {index[0], index[1], index[2]};
    }
    return place;
}

/// How well a record fits a point, 0 to 256, and whether something may lie between them.
struct Fit {
    std::int32_t share = 0;
    bool is_suspect = false;
};

/// A record fits if it lies near the point's tangent plane and its normal is similar; both fade.
inline Fit fit_of(const glm::vec3& place, const glm::vec3& normal, const glm::vec3& point,
                  const glm::vec3& unit_normal, double step) {
    const glm::dvec3 way(place - point);
    const glm::dvec3 n(unit_normal);
    const glm::dvec3 m(normal);
    const double before = n.x * way.x + n.y * way.y + n.z * way.z;
    const double behind = m.x * way.x + m.y * way.y + m.z * way.z;
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
