// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/mesh/light_order.hpp>
#include <lightmesh/mesh/light_shape.hpp>

#include <array>
#include <cstddef>
#include <limits>

namespace lightmesh::detail {

/// The centres of a tile of lights, coordinate by coordinate. The direction from P to a light is
/// `at - w * P`: w is 1, or 0 for a directional light, whose `at` is the direction itself.
struct LampColumns {
    std::array<double, lamps_per_tile> at_x{}, at_y{}, at_z{}, w{}, range_squared{}, extent{};
    bool has_ranges = false;
    ReachBox box;

    void set(std::size_t l, const Lamp& lamp) {
        const LightShape& shape = lamp.shape();
        extent[l] = lamp.extent();
        at_x[l] = static_cast<double>(shape.at.x);
        at_y[l] = static_cast<double>(shape.at.y);
        at_z[l] = static_cast<double>(shape.at.z);
        w[l] = shape.is_directional ? 0.0 : 1.0;
        const auto range = static_cast<double>(shape.range);
        range_squared[l] = shape.reaches_nothing() ? -1.0 : range * range;
        has_ranges |= shape.range < std::numeric_limits<float>::infinity();
        box.include(ball_of(shape));
    }
};

}  // namespace lightmesh::detail
