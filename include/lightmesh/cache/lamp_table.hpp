// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/kernels/kernels.hpp>
#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/lamp_columns.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/check_light.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// The lights of a cache, checked, with what decides whether they reach a point in columns of 64.
class LampTable {
public:
    /// Rows have 16 bits for the number of a tile.
    static constexpr std::size_t most_lights = lamps_per_tile << 16;

    /// Throws std::invalid_argument if there are more than `most_lights`, and what `check_light` throws.
    explicit LampTable(std::span<const Light> lights) {
        check_count(lights.size());
        check_lights(lights);
        lamps_.reserve(lights.size());
        for (const Light& light : lights)
            lamps_.emplace_back(light);
        tiles_.reserve((lights.size() + lamps_per_tile - 1) / lamps_per_tile);
        while (tiles_.size() * lamps_per_tile < lamps_.size())
            tiles_.push_back(tile_of(tiles_.size()));
    }

    /// A lamp that was replaced, with its tile.
    struct Replaced;
    /// Puts a light in the place of another; `restore` takes that back. Throws as above, and std::bad_alloc;
    /// nothing has changed then. Nobody may use the table meanwhile.
    Replaced set(std::size_t i, const Light& light);
    void restore(Replaced&& replaced) noexcept;
    /// The same for a light behind all others.
    void add(const Light& light) {
        check_count(size() + 1);
        check_light(light, "light " + to_text(size()));
        if (size() % lamps_per_tile == 0)
            tiles_.reserve(tile_count() + 1);
        lamps_.emplace_back(light);
        try {
            Tile last = tile_of((size() - 1) / lamps_per_tile);
            if ((size() - 1) % lamps_per_tile == 0)
                tiles_.push_back(std::move(last));
            else
                tiles_.back() = std::move(last);
        } catch (...) {
            lamps_.pop_back();
            throw;
        }
    }

    std::size_t size() const { return lamps_.size(); }
    std::size_t tile_count() const { return tiles_.size(); }
    std::size_t tile_size(std::size_t tile) const {
        return (std::min)(lamps_per_tile, lamps_.size() - tile * lamps_per_tile);
    }
    const Lamp& lamp(std::size_t i) const { return lamps_[i]; }
    std::size_t bytes() const { return lamps_.capacity() * sizeof(Lamp) + tiles_.capacity() * sizeof(Tile); }

    /// Which lights of a tile can reach a point: chi of equation (3), range and cone, of their centres. A
    /// normal of 0 faces all.
    std::uint64_t reaching(std::size_t tile, const glm::vec3& point, const glm::vec3& normal) const {
        return tiles_[tile].reaching(*kernels_, tile_size(tile), point, normal);
    }

    /// The lights of a tile of which some part may be nearer to a point's tangent plane, or farther below it,
    /// than an angle of which the squared sine is given.
    std::uint64_t grazing(std::size_t tile, const glm::vec3& point, const glm::vec3& normal,
                          float sine_squared) const {
        return tiles_[tile].grazing(tile_size(tile), point, normal, sine_squared);
    }

private:
    struct Tile {
        LampColumns columns;
        std::vector<LightCone> cones;  // empty, or one for each light

        void set(std::size_t l, const Lamp& lamp) {
            columns.set(l, lamp);
            const LightCone& cone = lamp.shape().cone;
            if (cone.is_everything && cones.empty())
                return;
            cones.resize(lamps_per_tile);
            cones[l] = cone;
        }

        std::uint64_t grazing(std::size_t size, const glm::vec3& point, const glm::vec3& normal,
                              float sine_squared) const {
            const auto& [at_x, at_y, at_z, w, range_squared, extent, has_ranges, box] = columns;
            const glm::dvec3 n(normal);
            const glm::dvec3 p(point);
            std::uint64_t mask = 0;
            for (std::size_t i = 0; i < size; ++i) {
                // Rounded to float, so that products are exact.
                const auto x = static_cast<double>(static_cast<float>(at_x[i] - w[i] * p.x));
                const auto y = static_cast<double>(static_cast<float>(at_y[i] - w[i] * p.y));
                const auto z = static_cast<double>(static_cast<float>(at_z[i] - w[i] * p.z));
                const auto height =
                    static_cast<double>(static_cast<float>(n.x * x + n.y * y + n.z * z - extent[i]));
                const auto squared = static_cast<double>(static_cast<float>(x * x + y * y + z * z));
                const bool is_low =
                    height < 0.0 || height * height < static_cast<double>(sine_squared) * squared;
                mask |= std::uint64_t{is_low} << i;
            }
            return mask;
        }

        std::uint64_t reaching(const CacheKernels& kernels, std::size_t size, const glm::vec3& point,
                               const glm::vec3& normal) const {
            if (!columns.box.holds(point))
                return 0;
            std::uint64_t mask = kernels.find_reaching(columns, size, point, normal);
            if (size < 64)
                mask &= (std::uint64_t{1} << size) - 1u;
            if (!cones.empty())
                for (std::uint64_t rest = mask; rest != 0; rest &= rest - 1) {
                    const auto l = static_cast<std::size_t>(std::countr_zero(rest));
                    const glm::vec3 at(columns.at_x[l], columns.at_y[l], columns.at_z[l]);
                    if (!cones[l].contains(point - at))
                        mask &= ~(std::uint64_t{1} << l);
                }
            return mask;
        }
    };

    static void check_count(std::size_t count) {
        require(count <= most_lights, "the number of lights", count, "at most 4,194,304");
    }

    Tile tile_of(std::size_t t) const {
        Tile tile;
        for (std::size_t i = t * lamps_per_tile; i < (std::min)(size(), (t + 1) * lamps_per_tile); ++i)
            tile.set(i % lamps_per_tile, lamps_[i]);
        return tile;
    }

    const CacheKernels* kernels_ = &cache_kernels();
    std::vector<Lamp> lamps_;
    std::vector<Tile> tiles_;
};

struct LampTable::Replaced {
    std::size_t light;
    Lamp lamp;
    Tile tile;
};

inline LampTable::Replaced LampTable::set(std::size_t i, const Light& light) {
    check_light(light, "light " + to_text(i));
    const std::size_t t = i / lamps_per_tile;
    Replaced replaced{i, lamps_[i], {}};
    lamps_[i] = Lamp(light);
    try {
        replaced.tile = std::exchange(tiles_[t], tile_of(t));
    } catch (...) {
        lamps_[i] = replaced.lamp;
        throw;
    }
    return replaced;
}

inline void LampTable::restore(Replaced&& replaced) noexcept {
    lamps_[replaced.light] = replaced.lamp;
    tiles_[replaced.light / lamps_per_tile] = std::move(replaced.tile);
}

}  // namespace lightmesh::detail
