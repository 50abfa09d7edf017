// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/support/atomics.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// Units (see `BrickTile::known`) of one brick and one tile of lights that are missing.
struct MissingUnits {
    const Brick* brick = nullptr;
    std::size_t tile = 0;
    std::uint64_t units = 0;
};

/// The light points of a brick that adaptive long tests sample. Chosen by search: of all sets of 16 the one
/// with the fewest wrong bits over the bricks of a park, some rooms and spheres on a plane.
inline constexpr std::uint64_t brick_samples = 0x8450219409848201u;

/// A brick while units of it are found: which light points long tests must tell of each light, first the
/// samples and then the others, and what is stored when they have. Lights out of whose range all points
/// within the grid's radius of a cell lie are dark there and cost nothing. Knows no rays.
class BrickFill {
public:
    /// Nothing is told yet.
    void start(const MeshData& data, const MissingUnits& missing) {
        missing_ = missing;
        columns_ = &data.lights().tile(missing.tile);
        lights_there_ = ~std::uint64_t{0} >> (64 - data.lights().tile_size(missing.tile));
        radius_ = data.grid().radius();
        samples_ = {};
        fresh_ = 0;
        newly_sampled_ = 0;
        kept_ = data.find_kept(*missing.brick, missing.tile);
        kept_anywhere_ = kept_.anywhere();
        lit_.fill(0);
        const glm::ivec3 coord = missing.brick->position();
        for (int bit = 0; bit < 64; ++bit)
            positions_[static_cast<std::size_t>(bit)] = data.grid().position(grid_pos_of(coord, bit));
        if (!data.is_adaptive())
            return;
        // Samples that are known still count as those of groups that were sampled.
        std::uint64_t still_sampled = 0;
        if (const BrickTile* tile = data.view().find_tile(*missing.brick, missing.tile)) {
            samples_.sampled = load_acquire(tile->sampled);
            still_sampled = kept_.sampled;
            samples_.uniform =
                load_relaxed(tile->uniform) & (lights_of_groups(samples_.sampled) | still_sampled);
            samples_.lit = load_relaxed(tile->lit) & samples_.uniform;
        }
        fresh_ = groups_with_units(missing.units) & ~samples_.sampled;
        newly_sampled_ = lights_of_groups(fresh_) & ~still_sampled;
    }

    /// The places of the light points, world units.
    const std::array<glm::vec3, 64>& positions() const { return positions_; }
    const Brick& brick() const { return *missing_.brick; }

    /// Light points that are to be tested first, as samples of the light in slot l of the tile.
    std::uint64_t samples_of(std::size_t l) const {
        const bool is_new = (newly_sampled_ & lights_there_) >> l & 1;
        return is_new && in_range(l) != 0 ? brick_samples : 0;
    }

    /// Notes which light points see a light.
    void add_lit(std::size_t l, std::uint64_t points) { lit_[l] |= points; }

    /// When it is known which samples see the light, also for places without a light: they are dark.
    void take_samples(std::size_t l) {
        if ((newly_sampled_ >> l & 1) == 0)
            return;
        if (lit_[l] == 0 || lit_[l] == brick_samples)
            samples_.uniform |= std::uint64_t{1} << l;
        if (lit_[l] == brick_samples)
            samples_.lit |= std::uint64_t{1} << l;
    }
    /// When the samples of all lights are taken.
    void end_samples() { samples_.sampled |= fresh_; }

    /// Light points that samples have not told of the light in slot l.
    std::uint64_t others_of(std::size_t l) const {
        if (((samples_.uniform | ~lights_there_) >> l & 1) != 0)
            return 0;
        std::uint64_t cells = missing_.units >> (l / lights_per_group) & every_byte;
        if ((kept_anywhere_ >> l & 1) != 0)
            cells &= ~kept_.cells_with(l);
        const std::uint64_t sampled = (newly_sampled_ >> l & 1) != 0 ? brick_samples : 0;
        return cells * 0xff & in_range(l) & ~sampled;
    }

    /// Stores what was found. Throws what `MeshData::publish` throws.
    void publish(MeshData& data) const {
        BrickWords lit = lit_;
        if (columns_->has_ranges)
            for (std::size_t l = 0; l < lights_per_tile; ++l)
                if (lit[l] != 0)
                    lit[l] &= in_range(l);
        std::uint64_t known = missing_.units;
        // Where all lights of a group are uniform, it is known in all cells.
        for (std::uint32_t group = 0; group < 8; ++group)
            if ((fresh_ >> group & 1) != 0 && (~samples_.uniform >> (8 * group) & 0xff) == 0)
                known |= every_byte << group;
        data.publish(*missing_.brick, missing_.tile, known, lit, samples_);
    }

private:
    /// The light points of the cells that a light may reach.
    std::uint64_t in_range(std::size_t l) const {
        if (!columns_->has_ranges)
            return ~std::uint64_t{0};
        std::uint64_t points = 0;
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell)
            if (columns_->in_range(l, positions_[8 * cell], positions_[8 * cell + 7], radius_))
                points |= std::uint64_t{0xff} << (8 * cell);
        return points;
    }

    MissingUnits missing_;
    const LightColumns* columns_ = nullptr;
    std::uint64_t lights_there_ = 0;
    float radius_ = 0.0f;
    UniformLights samples_;
    std::uint32_t fresh_ = 0;          ///< groups whose samples are new
    KeptLights kept_;                  ///< what is known beside `missing_`
    std::uint64_t kept_anywhere_ = 0;  ///< lights that it has in some cell
    std::uint64_t newly_sampled_ = 0;  ///< lights of `fresh_`, but those whose samples are known still
    BrickWords lit_;
    std::array<glm::vec3, 64> positions_;
};

}  // namespace lightmesh::detail
