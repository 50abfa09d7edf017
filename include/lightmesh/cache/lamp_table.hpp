// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/lanes.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/check_light.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

namespace lightmesh::detail {

/// The lights of a cache, checked, with what decides whether they reach a point in columns of 64.
class LampTable {
public:
    /// Throws what `check_light` throws.
    explicit LampTable(std::span<const Light> lights)
        : tiles_((lights.size() + lamps_per_tile - 1) / lamps_per_tile) {
        lamps_.reserve(lights.size());
        for (std::size_t i = 0; i < lights.size(); ++i) {
            check_light(lights[i], "light " + to_text(i));
            lamps_.emplace_back(lights[i]);
            tiles_[i / lamps_per_tile].set(i % lamps_per_tile, lamps_.back());
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
        return tiles_[tile].reaching(tile_size(tile), point, normal);
    }

    /// The lights of a tile of which some part may be nearer to a point's tangent plane, or farther below it,
    /// than an angle of which the squared sine is given.
    std::uint64_t grazing(std::size_t tile, const glm::vec3& point, const glm::vec3& normal,
                          float sine_squared) const {
        return tiles_[tile].grazing(tile_size(tile), point, normal, sine_squared);
    }

private:
    /// The way from P to a light is `at - nearness * P`: nearness is 1, or 0 for a directional light, whose
    /// `at` is the way itself. Products of two floats are exact in double.
    struct Tile {
        std::array<double, lamps_per_tile> at_x{}, at_y{}, at_z{}, nearness{}, range_squared{}, extent{};
        std::vector<LightCone> cones;  // empty, or one for each light
        bool has_ranges = false;

        void set(std::size_t l, const Lamp& lamp) {
            const LightShape& shape = lamp.shape();
            extent[l] = lamp.extent();
            at_x[l] = static_cast<double>(shape.at.x);
            at_y[l] = static_cast<double>(shape.at.y);
            at_z[l] = static_cast<double>(shape.at.z);
            nearness[l] = shape.is_directional ? 0.0 : 1.0;
            const auto range = static_cast<double>(shape.range);
            range_squared[l] = range * range;
            has_ranges |= shape.range < std::numeric_limits<float>::infinity();
            if (shape.cone.is_everything && cones.empty())
                return;
            cones.resize(lamps_per_tile);
            cones[l] = shape.cone;
        }

        std::uint64_t grazing(std::size_t size, const glm::vec3& point, const glm::vec3& normal,
                              float sine_squared) const {
            const glm::dvec3 n(normal);
            const glm::dvec3 p(point);
            std::uint64_t mask = 0;
            for (std::size_t i = 0; i < size; ++i) {
                // Rounded to float, so that products are exact.
                const auto x = static_cast<double>(static_cast<float>(at_x[i] - nearness[i] * p.x));
                const auto y = static_cast<double>(static_cast<float>(at_y[i] - nearness[i] * p.y));
                const auto z = static_cast<double>(static_cast<float>(at_z[i] - nearness[i] * p.z));
                const auto height =
                    static_cast<double>(static_cast<float>(n.x * x + n.y * y + n.z * z - extent[i]));
                const auto squared = static_cast<double>(static_cast<float>(x * x + y * y + z * z));
                const bool is_low =
                    height < 0.0 || height * height < static_cast<double>(sine_squared) * squared;
                mask |= std::uint64_t{is_low} << i;
            }
            return mask;
        }

        std::uint64_t reaching(std::size_t size, const glm::vec3& point, const glm::vec3& normal) const {
            const glm::dvec3 n(normal);
            const glm::dvec3 p(point);
            const double height = n.x * p.x + n.y * p.y + n.z * p.z;
            std::array<std::uint8_t, lamps_per_tile> flags{};
            const std::size_t padded = (size + 7) / 8 * 8;
            for (std::size_t first = 0; first < padded; first += 8) {
                std::array<std::uint8_t, 8> octet;
                for (std::size_t l = 0; l < 8; ++l) {
                    const std::size_t i = first + l;
                    const double facing =
                        n.x * at_x[i] + n.y * at_y[i] + n.z * at_z[i] - nearness[i] * height;
                    octet[l] = facing >= 0.0 ? 1 : 0;
                }
                if (has_ranges) {
                    for (std::size_t l = 0; l < 8; ++l) {
                        const std::size_t i = first + l;
                        // Rounded to float, so that squares are exact.
                        const auto x = static_cast<double>(static_cast<float>(at_x[i] - p.x));
                        const auto y = static_cast<double>(static_cast<float>(at_y[i] - p.y));
                        const auto z = static_cast<double>(static_cast<float>(at_z[i] - p.z));
                        const bool in_range = x * x + y * y + z * z <= range_squared[i];
                        octet[l] = octet[l] != 0 && (in_range || nearness[i] == 0.0) ? 1 : 0;
                    }
                }
                std::memcpy(flags.data() + first, octet.data(), 8);
            }
            std::uint64_t mask = 0;
            for (std::size_t o = 0; o < padded / 8; ++o) {
                std::uint64_t bytes = 0;  // the first flag is the lowest byte, whatever the processor
                if constexpr (std::endian::native == std::endian::little)
                    std::memcpy(&bytes, flags.data() + 8 * o, 8);
                else
                    for (std::size_t b = 0; b < 8; ++b)
                        bytes |= static_cast<std::uint64_t>(flags[8 * o + b]) << 8 * b;
                mask |= gather_low_bits(bytes) << 8 * o;
            }
            if (size < 64)
                mask &= (std::uint64_t{1} << size) - 1u;
            if (!cones.empty())
                for (std::uint64_t rest = mask; rest != 0; rest &= rest - 1) {
                    const auto l = static_cast<std::size_t>(std::countr_zero(rest));
                    const glm::vec3 at(at_x[l], at_y[l], at_z[l]);
                    if (!cones[l].contains(point - at))
                        mask &= ~(std::uint64_t{1} << l);
                }
            return mask;
        }
    };

    std::vector<Lamp> lamps_;
    std::vector<Tile> tiles_;
};

}  // namespace lightmesh::detail
