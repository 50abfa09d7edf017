// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/ray_ends.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_order.hpp>
#include <lightmesh/mesh/light_shape.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/check_light.hpp>
#include <lightmesh/support/rounded.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// 64 lights as columns. The direction from P to a light is `at - w * P`: w is 1, or 0 for a
/// directional light, whose `at` is the direction itself. Slots without a light are out of range of
/// everything.
struct LightColumns {
    using Column = std::array<float, lights_per_tile>;
    alignas(64) Column at_x{}, at_y{}, at_z{}, w{};
    std::array<double, lights_per_tile> range_squared = nothing_in_range();
    /// The same, for a first look; NaN where floats can't tell anything.
    alignas(64) Column coarse_range_squared{};
    std::vector<LightCone> cones;  ///< empty, or one a slot
    std::uint64_t exists = 0;      ///< slots with a light
    bool has_ranges = false;
    float largest_at = 0.0f;  ///< the greatest sum of the magnitudes of x, y and z
    ReachBox box;

    void set(std::size_t l, const LightShape& shape) {
        at_x[l] = shape.at.x;
        at_y[l] = shape.at.y;
        at_z[l] = shape.at.z;
        w[l] = shape.is_directional ? 0.0f : 1.0f;
        const auto range = static_cast<double>(shape.range);
        range_squared[l] = shape.reaches_nothing() ? -1.0 : range * range;
        const bool fits = (range_squared[l] > 1e-30 && range_squared[l] < 1e30) || std::isinf(shape.range);
        coarse_range_squared[l] =
            fits ? static_cast<float>(range_squared[l]) : std::numeric_limits<float>::quiet_NaN();
        exists |= std::uint64_t{1} << l;
        has_ranges |= std::isfinite(shape.range);
        largest_at =
            (std::max)(largest_at, std::abs(shape.at.x) + std::abs(shape.at.y) + std::abs(shape.at.z));
        if (!shape.cone.is_everything || !cones.empty()) {
            cones.resize(lights_per_tile);
            cones[l] = shape.cone;
        }
        box.include(ball_of(shape));
    }

    /// chi of equation (3) and the range. Products of two floats are exact in double: the answer does not
    /// depend on whether a compiler fuses them with the sums that follow.
    bool faces_in_range(std::size_t l, const glm::vec3& point, const glm::vec3& normal) const {
        const auto x = static_cast<double>(at_x[l] - w[l] * point.x);
        const auto y = static_cast<double>(at_y[l] - w[l] * point.y);
        const auto z = static_cast<double>(at_z[l] - w[l] * point.z);
        const double height = static_cast<double>(normal.x) * x + static_cast<double>(normal.y) * y +
                              static_cast<double>(normal.z) * z;
        const double distance = static_cast<double>(w[l]) * (x * x + y * y + z * z);
        return (height >= 0.0) & (distance <= range_squared[l]);
    }

    bool inside_cone(std::size_t l, const glm::vec3& point) const {
        return cones.empty() || cones[l].contains(point - glm::vec3(at_x[l], at_y[l], at_z[l]));
    }

    /// True if any point within `radius` of the box can be reached, by range alone.
    bool in_range(std::size_t l, const glm::vec3& low, const glm::vec3& high, float radius) const {
        const glm::vec3 at(at_x[l], at_y[l], at_z[l]);
        const glm::dvec3 offset((glm::max)((glm::max)(low - at, at - high), glm::vec3(0.0f)));
        const double least =
            (std::max)(glm::length(offset) - rounded(1.0001 * static_cast<double>(radius)), 0.0);
        return static_cast<double>(w[l]) * least * least <= range_squared[l];
    }

private:
    static std::array<double, lights_per_tile> nothing_in_range() {
        std::array<double, lights_per_tile> column;
        column.fill(-1.0);
        return column;
    }
};

/// The lights of a mesh, checked and laid out for loops over many of them. A light has a number, the user's
/// own, and a slot: tiles and groups are of lights in neighbouring slots.
class LightTable {
public:
    /// Throws what `check_light` throws.
    LightTable(std::span<const Light> lights, const Grid& grid)
        : LightTable(std::make_shared<const Lights>(lights), grid) {}
    /// The lights of another table, which are shared, for another grid.
    LightTable(const LightTable& other, const Grid& grid) : LightTable(other.lights_, grid) {}

    /// The same with another light in the place of one. Throws what `check_light` throws.
    LightTable with(std::size_t light, const Light& other) const {
        check_light(other, "light " + to_text(light));
        LightTable table = *this;
        table.lights_ = std::make_shared<const Lights>(*lights_, light, shape_of(other));
        return table;
    }

    /// Takes the lights of another table.
    void share(const LightTable& other) { lights_ = other.lights_; }

    std::size_t size() const { return lights_->shapes.size(); }
    const LightShape& shape(std::size_t light) const { return lights_->shapes[light]; }
    /// True if the order is that of a table that is made of these lights.
    bool has_own_order() const { return order() == LightOrder(lights_->shapes); }
    /// Those of all tables together that share the lights.
    std::size_t bytes() const {
        return sizeof(Lights) + lights_->shapes.capacity() * sizeof(LightShape) + lights_->order.bytes() +
               lights_->tiles.capacity() * sizeof(LightColumns);
    }
    const LightOrder& order() const { return lights_->order; }
    std::size_t tile_count() const { return lights_->tiles.size(); }

    /// Number of lights in a tile, 1..64.
    int tile_size(std::size_t tile) const {
        return static_cast<int>((std::min)(lights_per_tile, size() - tile * lights_per_tile));
    }
    /// Number of groups in a tile, 1..8.
    int tile_groups(std::size_t tile) const { return (tile_size(tile) + 7) / 8; }

    /// The lights of a tile.
    const LightColumns& tile(std::size_t t) const { return lights_->tiles[t]; }

    /// True if a light can reach a point at all: chi of equation (3), range and cone.
    bool can_light(std::size_t light, const glm::vec3& point, const glm::vec3& normal) const {
        const std::size_t slot = order().slot_of(light);
        const LightColumns& tile = lights_->tiles[slot / lights_per_tile];
        return tile.faces_in_range(slot % lights_per_tile, point, normal) &&
               tile.inside_cone(slot % lights_per_tile, point);
    }

    /// The segment of a long test. It starts at the light, so that neighbouring segments are coherent. Those
    /// of a directional light, and of one so far away that floats there are coarse, start at the point.
    Segment long_segment(std::size_t light, const glm::vec3& point) const {
        const LightShape& shape = lights_->shapes[light];
        if (is_far(shape))
            return {point, far_end(shape, point)};
        return {light_end(shape.at, point, step_), point};
    }

    /// The segment of a shadow ray, from a surface end (see `surface_end`).
    Segment shadow_segment(std::size_t light, const glm::vec3& end) const {
        const LightShape& shape = lights_->shapes[light];
        return {end, is_far(shape) ? far_end(shape, end) : light_end(shape.at, end, step_)};
    }

private:
    /// The part that does not depend on the grid.
    struct Lights {
        explicit Lights(std::span<const Light> lights)
            : shapes(checked(lights)), order(shapes),
              tiles((lights.size() + lights_per_tile - 1) / lights_per_tile) {
            for (std::size_t tile = 0; tile < tiles.size(); ++tile)
                fill(tile);
        }
        /// The same slots, with another light.
        Lights(const Lights& others, std::size_t light, const LightShape& shape)
            : shapes(others.shapes), order(others.order), tiles(others.tiles) {
            shapes[light] = shape;
            fill(order.slot_of(light) / lights_per_tile);
        }

        void fill(std::size_t tile) {
            tiles[tile] = {};
            const std::size_t first = tile * lights_per_tile;
            for (std::size_t slot = first; slot < (std::min)(first + lights_per_tile, shapes.size()); ++slot)
                tiles[tile].set(slot - first, shapes[order.light_at(slot)]);
        }

        std::vector<LightShape> shapes;
        LightOrder order;
        std::vector<LightColumns> tiles;
    };

    LightTable(std::shared_ptr<const Lights> lights, const Grid& grid)
        : lights_(std::move(lights)), step_(static_cast<float>(grid.step())),
          reach_(static_cast<float>(grid.step() * Grid::max_index)) {}

    static std::vector<LightShape> checked(std::span<const Light> lights) {
        check_lights(lights);
        std::vector<LightShape> shapes;
        shapes.reserve(lights.size());
        for (const Light& light : lights)
            shapes.push_back(shape_of(light));
        return shapes;
    }

    /// A test for places where neighbouring floats are more than 2^-10 steps apart, or there is no place at
    /// all.
    bool is_far(const LightShape& shape) const {
        return shape.is_directional || largest_component(shape.at) > 0x1p14f * step_;
    }

    /// The end of a segment from `point` to a far light: the light, but no farther than the grid reaches.
    glm::vec3 far_end(const LightShape& shape, const glm::vec3& point) const {
        if (shape.is_directional)
            return point + rounded(shape.at * reach_);
        const glm::vec3 offset = shape.at - point;
        const double distance = glm::length(glm::dvec3(offset));
        if (distance > static_cast<double>(reach_))
            return point + rounded(unit_or_zero(offset) * reach_);
        return light_end(shape.at, point, step_);
    }

    std::shared_ptr<const Lights> lights_;
    float step_;
    float reach_;
};

}  // namespace lightmesh::detail
