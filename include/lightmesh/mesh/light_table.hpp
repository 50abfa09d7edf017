// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/ray_ends.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_order.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/check_light.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace lightmesh::detail {

/// Lights are handled in tiles of 64, and within a tile in groups of 8: the unit of what is stored and of
/// what is traced.
inline constexpr std::size_t lights_per_tile = 64;
inline constexpr std::size_t lights_per_group = 8;

/// One byte for each light of a tile: 1 if it can reach a point, else 0. Places without a light have 0.
using Reaching = std::array<std::uint8_t, lights_per_tile>;

/// The lights of a mesh, checked and laid out for loops over many of them. A light has a number, the user's
/// own, and a place: tiles and groups are of lights in neighbouring places.
class LightTable {
public:
    /// Throws what `check_light` throws.
    LightTable(std::span<const Light> lights, const Grid& grid)
        : lights_(checked(lights)), order_(lights),
          tiles_((lights.size() + lights_per_tile - 1) / lights_per_tile),
          step_(static_cast<float>(grid.step())), reach_(static_cast<float>(grid.step() * Grid::max_index)) {
        for (std::size_t place = 0; place < lights_.size(); ++place) {
            Tile& tile = tiles_[place / lights_per_tile];
            const Light& light = lights_[order_.light_at(place)];
            std::visit([&](const auto& kind) { tile.set(place % lights_per_tile, kind); }, light);
            tile.include(ball_of(light));
        }
    }

    std::size_t size() const { return lights_.size(); }
    std::size_t bytes() const {
        return lights_.capacity() * sizeof(Light) + order_.bytes() + tiles_.capacity() * sizeof(Tile);
    }
    const LightOrder& order() const { return order_; }
    std::size_t tile_count() const { return tiles_.size(); }

    /// Number of lights in a tile, 1..64.
    int tile_size(std::size_t tile) const {
        return static_cast<int>((std::min)(lights_per_tile, lights_.size() - tile * lights_per_tile));
    }
    /// Number of groups in a tile, 1..8.
    int tile_groups(std::size_t tile) const { return (tile_size(tile) + 7) / 8; }

    /// Which lights of a tile can reach a point at all: chi of equation (3), range and cone.
    Reaching find_reaching(std::size_t tile, const glm::vec3& point, const glm::vec3& normal) const {
        return tiles_[tile].may_reach(point) ? tiles_[tile].find_reaching(point, normal) : Reaching{};
    }

    /// `find_reaching` for one light.
    bool reaches(std::size_t light, const glm::vec3& point, const glm::vec3& normal) const {
        const std::size_t place = order_.place_of(light);
        return tiles_[place / lights_per_tile].reaches(place % lights_per_tile, point, normal);
    }

    /// Whether any point within `radius` of the box can be reached, by range alone.
    bool in_range(std::size_t light, const glm::vec3& box_low, const glm::vec3& box_high,
                  float radius) const {
        const std::size_t place = order_.place_of(light);
        return tiles_[place / lights_per_tile].in_range(place % lights_per_tile, box_low, box_high, radius);
    }

    /// The segment of a long test. It starts at the light, so that neighbouring segments are coherent; those
    /// of a directional light start at the point, where coordinates are small.
    Segment long_segment(std::size_t light, const glm::vec3& point) const {
        if (const auto* sun = std::get_if<DirectionalLight>(&lights_[light]))
            return {point, far_end(*sun, point)};
        return {light_end(position_of(light), point, step_), point};
    }

    /// The segment of a shadow ray, from a surface end (see `surface_end`).
    Segment shadow_segment(std::size_t light, const glm::vec3& end) const {
        if (const auto* sun = std::get_if<DirectionalLight>(&lights_[light]))
            return {end, far_end(*sun, end)};
        return {end, light_end(position_of(light), end, step_)};
    }

private:
    static std::vector<Light> checked(std::span<const Light> lights) {
        for (std::size_t i = 0; i < lights.size(); ++i)
            check_light(lights[i], "light " + to_text(i));
        return {lights.begin(), lights.end()};
    }

    const glm::vec3& position_of(std::size_t light) const {
        if (const auto* point = std::get_if<PointLight>(&lights_[light]))
            return point->position;
        return std::get<SpotLight>(lights_[light]).position;
    }

    glm::vec3 far_end(const DirectionalLight& light, const glm::vec3& point) const {
        return point - unit_or_zero(light.direction) * reach_;
    }

    /// 64 lights as columns. The way from P to a light is `at - nearness * P`: nearness is 1, or 0 for a
    /// directional light, whose `at` is the way itself.
    struct Tile {
        using Column = std::array<float, lights_per_tile>;
        Column at_x{}, at_y{}, at_z{}, nearness{};
        Column range_squared = filled(-1.0f);  // less than any distance where there is no light
        Column axis_x{}, axis_y{}, axis_z{}, cos_cone{};
        bool has_cones = false;
        // The box around all that the lights can reach.
        glm::vec3 box_low{std::numeric_limits<float>::infinity()};
        glm::vec3 box_high{-std::numeric_limits<float>::infinity()};

        static Column filled(float value) {
            Column column;
            column.fill(value);
            return column;
        }

        void set(std::size_t l, const PointLight& light) { place(l, light.position, 1.0f, light.range); }
        void set(std::size_t l, const DirectionalLight& light) {
            place(l, -unit_or_zero(light.direction), 0.0f, std::numeric_limits<float>::infinity());
        }
        void set(std::size_t l, const SpotLight& light) {
            place(l, light.position, 1.0f, light.range);
            const glm::vec3 axis = unit_or_zero(light.axis);
            axis_x[l] = axis.x;
            axis_y[l] = axis.y;
            axis_z[l] = axis.z;
            cos_cone[l] = std::cos(light.cone);
            has_cones = true;
        }

        void place(std::size_t l, const glm::vec3& at, float near_by, float range) {
            at_x[l] = at.x;
            at_y[l] = at.y;
            at_z[l] = at.z;
            nearness[l] = near_by;
            range_squared[l] = range * range;
            cos_cone[l] = -2.0f;  // every direction lies inside
        }

        void include(const LightBall& ball) {
            // Wider by some roundings, so that no point is left out that is in range.
            const float range = 1.00001f * ball.range + 1e-6f * largest_component(ball.middle);
            box_low = (glm::min)(box_low, ball.middle - range);
            box_high = (glm::max)(box_high, ball.middle + range);
        }

        bool may_reach(const glm::vec3& point) const {
            return (point.x >= box_low.x) & (point.y >= box_low.y) & (point.z >= box_low.z) &
                   (point.x <= box_high.x) & (point.y <= box_high.y) & (point.z <= box_high.z);
        }

        Reaching find_reaching(const glm::vec3& point, const glm::vec3& normal) const {
            Reaching reaches;
            for (std::size_t l = 0; l < lights_per_tile; ++l) {
                const float x = at_x[l] - nearness[l] * point.x;
                const float y = at_y[l] - nearness[l] * point.y;
                const float z = at_z[l] - nearness[l] * point.z;
                const bool faces = normal.x * x + normal.y * y + normal.z * z >= 0.0f;
                const bool near_enough = nearness[l] * (x * x + y * y + z * z) <= range_squared[l];
                reaches[l] = static_cast<std::uint8_t>(faces & near_enough);
            }
            if (has_cones)
                for (std::size_t l = 0; l < lights_per_tile; ++l)
                    reaches[l] &= inside_cone(l, point);
            return reaches;
        }

        bool reaches(std::size_t l, const glm::vec3& point, const glm::vec3& normal) const {
            const float x = at_x[l] - nearness[l] * point.x;
            const float y = at_y[l] - nearness[l] * point.y;
            const float z = at_z[l] - nearness[l] * point.z;
            return normal.x * x + normal.y * y + normal.z * z >= 0.0f &&
                   nearness[l] * (x * x + y * y + z * z) <= range_squared[l] && inside_cone(l, point);
        }

        bool inside_cone(std::size_t l, const glm::vec3& point) const {
            const float x = point.x - at_x[l];
            const float y = point.y - at_y[l];
            const float z = point.z - at_z[l];
            return axis_x[l] * x + axis_y[l] * y + axis_z[l] * z >=
                   cos_cone[l] * std::sqrt(x * x + y * y + z * z);
        }

        bool in_range(std::size_t l, const glm::vec3& low, const glm::vec3& high, float radius) const {
            const glm::vec3 at(at_x[l], at_y[l], at_z[l]);
            const glm::vec3 way = (glm::max)((glm::max)(low - at, at - high), glm::vec3(0.0f));
            const float least = (std::max)(glm::length(way) - 1.0001f * radius, 0.0f);
            return nearness[l] * least * least <= range_squared[l];
        }
    };

    std::vector<Light> lights_;
    LightOrder order_;
    std::vector<Tile> tiles_;
    float step_;
    float reach_;
};

}  // namespace lightmesh::detail
