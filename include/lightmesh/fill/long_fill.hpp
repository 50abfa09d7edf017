// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/mesh_data.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

/// What queries lack, found by long tests and stored.

namespace lightmesh::detail {

/// Units (see `BrickTile::known`) of one brick and one tile of lights that are missing.
struct MissingUnits {
    const Brick* brick = nullptr;
    std::size_t tile = 0;
    std::uint64_t units = 0;
};

/// The units that a block of points lacks, each named once.
class MissingList {
public:
    static constexpr std::size_t capacity = 256;

    /// Returns false if the list is full: then it must be filled and cleared first.
    bool add(const Brick& brick, std::size_t tile, std::uint64_t units) {
        const auto address = reinterpret_cast<std::uintptr_t>(&brick);
        std::size_t at = (address / sizeof(Brick) + 31 * tile) % table_.size();
        for (; table_[at] != 0; at = (at + 1) % table_.size()) {
            MissingUnits& known = entries_[table_[at] - 1u];
            if (known.brick == &brick && known.tile == tile) {
                known.units |= units;
                return true;
            }
        }
        if (size_ == capacity)
            return false;
        entries_[size_++] = {&brick, tile, units};
        table_[at] = static_cast<std::uint16_t>(size_);
        return true;
    }

    std::span<const MissingUnits> entries() const { return std::span(entries_).first(size_); }

    void clear() {
        if (size_ != 0)
            table_.fill(0);
        size_ = 0;
    }

private:
    std::size_t size_ = 0;
    std::array<MissingUnits, capacity> entries_;
    std::array<std::uint16_t, 2 * capacity> table_{};
};

/// Finds units light by light, all light points of the brick that miss one at once, and stores them. Lights
/// out of whose range all points within the grid's radius of a cell lie are dark there and cost nothing.
/// Nothing is stored if an adapter throws.
template <class Tracer, class LongTests>
void fill_long_tests(MeshData& data, const Tracer& tracer, const LongTests& long_tests,
                     const MissingUnits& missing, LongTestCost& cost) {
    const LightTable& lights = data.lights();
    const LightColumns& columns = lights.tile(missing.tile);
    std::array<glm::vec3, 64> positions;
    const glm::ivec3 coord = missing.brick->position();
    for (int bit = 0; bit < 64; ++bit)
        positions[static_cast<std::size_t>(bit)] = data.grid().position(grid_pos_of(coord, bit));
    const auto in_range = [&](std::size_t l, std::size_t cell) {
        return !columns.has_ranges ||
               columns.in_range(l, positions[8 * cell], positions[8 * cell + 7], data.grid().radius());
    };

    BrickWords lit{};
    const auto tile_size = static_cast<std::size_t>(lights.tile_size(missing.tile));
    for (std::size_t l = 0; l < tile_size; ++l) {
        const std::uint64_t cells = missing.units >> (l / lights_per_group) & every_byte;
        std::array<glm::vec3, most_in_long_test> points;
        std::array<std::uint8_t, most_in_long_test> bits;
        std::size_t size = 0;
        for (std::uint64_t rest = cells; rest != 0; rest &= rest - 1) {
            const auto first = static_cast<std::size_t>(std::countr_zero(rest));
            if (!in_range(l, first / 8))
                continue;
            for (std::size_t bit = first; bit < first + 8; ++bit) {
                points[size] = positions[bit];
                bits[size++] = static_cast<std::uint8_t>(bit);
            }
        }
        if (size == 0)
            continue;
        const std::size_t light = lights.order().light_at(missing.tile * lights_per_tile + l);
        const std::uint64_t seen =
            long_tests(tracer, lights, light, std::span<const glm::vec3>(points).first(size), cost);
        for (std::size_t i = 0; i < size; i += 8)
            lit[l] |= (seen >> i & 0xff) << bits[i];
    }
    data.publish(*missing.brick, missing.tile, missing.units, lit);
}

}  // namespace lightmesh::detail
