// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/support/atomics.hpp>

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

/// The light points of a brick that adaptive long tests sample. Chosen by search: of all sets of 14 the one
/// with the fewest wrong bits over the bricks of a park, some rooms and spheres on a plane.
inline constexpr std::uint64_t brick_samples = 0x8250211408840601u;

/// Finds units of one brick light by light, and stores them. Lights out of whose range all points within the
/// grid's radius of a cell lie are dark there and cost nothing.
template <class Tracer, class LongTests>
class BrickFill {
public:
    BrickFill(MeshData& data, const Tracer& tracer, const LongTests& long_tests, const MissingUnits& missing,
              LongTestCost& cost)
        : data_(data), tracer_(tracer), long_tests_(long_tests), missing_(missing), cost_(cost),
          lights_(data.lights()), columns_(lights_.tile(missing.tile)) {
        const glm::ivec3 coord = missing.brick->position();
        for (int bit = 0; bit < 64; ++bit)
            positions_[static_cast<std::size_t>(bit)] = data.grid().position(grid_pos_of(coord, bit));
    }

    /// Nothing is stored if an adapter throws.
    void run() {
        const std::uint32_t groups = groups_with_units(missing_.units);
        std::uint32_t fresh = 0;
        std::uint64_t known = missing_.units;
        if (data_.is_adaptive()) {
            read_samples();
            fresh = groups & ~samples_.sampled;
            sample(fresh);
            // Where all lights of a group are uniform, it is known in all cells.
            for (std::uint32_t group = 0; group < 8; ++group)
                if ((fresh >> group & 1) != 0 && (~samples_.uniform >> (8 * group) & 0xff) == 0)
                    known |= every_byte << group;
        }
        const std::uint64_t mixed = lights_of_groups(groups) & ~samples_.uniform & lights_there();
        for (std::uint64_t rest = mixed; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const std::size_t group = l / lights_per_group;
            const std::uint64_t reached = in_range(l);
            const std::uint64_t asked = (missing_.units >> group & every_byte) * 0xff & reached;
            const std::uint64_t sampled = (fresh >> group & 1) != 0 ? brick_samples : 0;
            lit_[l] = (lit_[l] | test(l, asked & ~sampled)) & reached;
        }
        data_.publish(*missing_.brick, missing_.tile, known, lit_, samples_);
    }

private:
    std::uint64_t lights_there() const {
        return ~std::uint64_t{0} >> (64 - lights_.tile_size(missing_.tile));
    }

    /// One bit for each group of which a unit is set.
    static std::uint32_t groups_with_units(std::uint64_t units) {
        units |= units >> 32;
        units |= units >> 16;
        units |= units >> 8;
        return static_cast<std::uint32_t>(units & 0xff);
    }

    void read_samples() {
        if (const BrickTile* tile = data_.view().find_tile(*missing_.brick, missing_.tile)) {
            samples_.sampled = load_acquire(tile->sampled);
            samples_.uniform = load_relaxed(tile->uniform) & lights_of_groups(samples_.sampled);
            samples_.lit = load_relaxed(tile->lit) & samples_.uniform;
        }
    }

    /// Places without a light are dark.
    void sample(std::uint32_t groups) {
        samples_.sampled |= groups;
        for (std::uint64_t rest = lights_of_groups(groups); rest != 0; rest &= rest - 1) {
            const std::uint64_t light = rest & (~rest + 1);
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const bool can_be_lit = (light & lights_there()) != 0 && in_range(l) != 0;
            lit_[l] = can_be_lit ? test(l, brick_samples) : 0;
            if (lit_[l] == 0 || lit_[l] == brick_samples)
                samples_.uniform |= light;
            if (lit_[l] == brick_samples)
                samples_.lit |= light;
        }
    }

    /// The light points of the cells that a light may reach.
    std::uint64_t in_range(std::size_t l) const {
        if (!columns_.has_ranges)
            return ~std::uint64_t{0};
        std::uint64_t points = 0;
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell)
            if (columns_.in_range(l, positions_[8 * cell], positions_[8 * cell + 7], data_.grid().radius()))
                points |= std::uint64_t{0xff} << (8 * cell);
        return points;
    }

    /// Those of some light points of the brick that see a light.
    std::uint64_t test(std::size_t l, std::uint64_t points) const {
        std::array<glm::vec3, most_in_long_test> tested;
        std::size_t size = 0;
        for (std::uint64_t rest = points; rest != 0; rest &= rest - 1)
            tested[size++] = positions_[static_cast<std::size_t>(std::countr_zero(rest))];
        if (size == 0)
            return 0;
        const std::size_t light = lights_.order().light_at(missing_.tile * lights_per_tile + l);
        const std::uint64_t seen =
            long_tests_(tracer_, lights_, light, std::span<const glm::vec3>(tested).first(size), cost_);
        std::uint64_t lit = 0;
        std::size_t i = 0;
        for (std::uint64_t rest = points; rest != 0; rest &= rest - 1, ++i)
            lit |= (seen >> i & 1) != 0 ? rest & (~rest + 1) : 0;
        return lit;
    }

    MeshData& data_;
    const Tracer& tracer_;
    const LongTests& long_tests_;
    const MissingUnits& missing_;
    LongTestCost& cost_;
    const LightTable& lights_;
    const LightColumns& columns_;
    UniformLights samples_;
    BrickWords lit_{};
    std::array<glm::vec3, 64> positions_;
};

}  // namespace lightmesh::detail
