// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/support/atomics.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

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

/// The light points of a brick that adaptive long tests sample. Chosen by search: of all sets of 16 the one
/// with the fewest wrong bits over the bricks of a park, some rooms and spheres on a plane.
inline constexpr std::uint64_t brick_samples = 0x8450219409848201u;

/// Finds units of bricks light by light, some bricks at once, and stores them. Lights out of whose range all
/// points within the grid's radius of a cell lie are dark there and cost nothing.
template <class Tracer, class LongTests>
class LongFill {
public:
    LongFill(MeshData& data, const Tracer& tracer, const LongTests& long_tests)
        : data_(data), tracer_(tracer), long_tests_(long_tests) {}

    /// If an adapter throws, nothing is stored of the bricks that it is asked about.
    void run(std::span<const MissingUnits> missing) {
        while (!missing.empty()) {
            const std::size_t tile = missing.front().tile;
            const auto other_tile =
                std::ranges::find_if(missing, [&](const MissingUnits& m) { return m.tile != tile; });
            const std::size_t size =
                (std::min)(static_cast<std::size_t>(other_tile - missing.begin()), bricks_.size());
            fill(missing.first(size), tile);
            missing = missing.subspan(size);
        }
    }

    const LongTestCost& cost() const { return cost_; }

private:
    /// Of a brick that is being filled.
    struct BrickInWork {
        const MissingUnits* missing;
        UniformLights samples;
        std::uint32_t fresh;          ///< groups whose samples are new
        ForgottenLights forgotten;    ///< what is known beside `missing`
        std::uint64_t newly_sampled;  ///< lights of `fresh`, but those whose samples are known still
        BrickWords lit;
        std::array<glm::vec3, 64> positions;
    };

    static constexpr std::size_t most_in_call = most_in_long_test<Tracer>;
    /// So many that their samples fill a call.
    static constexpr std::size_t most_bricks = most_in_call / std::popcount(brick_samples);

    void fill(std::span<const MissingUnits> missing, std::size_t tile) {
        tile_ = tile;
        columns_ = &data_.lights().tile(tile);
        lights_there_ = ~std::uint64_t{0} >> (64 - data_.lights().tile_size(tile));
        brick_count_ = missing.size();
        for (std::size_t b = 0; b < missing.size(); ++b)
            start(bricks_[b], missing[b]);
        if (data_.is_adaptive())
            sample();
        test_mixed();
        for (const BrickInWork& brick : bricks())
            publish(brick);
    }

    std::span<BrickInWork> bricks() { return std::span(bricks_).first(brick_count_); }

    void start(BrickInWork& brick, const MissingUnits& missing) const {
        brick.missing = &missing;
        brick.samples = {};
        brick.fresh = 0;
        brick.newly_sampled = 0;
        brick.forgotten = data_.find_forgotten(*missing.brick, missing.tile);
        brick.lit.fill(0);
        const glm::ivec3 coord = missing.brick->position();
        for (int bit = 0; bit < 64; ++bit)
            brick.positions[static_cast<std::size_t>(bit)] = data_.grid().position(grid_pos_of(coord, bit));
        if (!data_.is_adaptive())
            return;
        // Samples that are known still count as those of groups that were sampled.
        std::uint64_t still_sampled = 0;
        if (const BrickTile* tile = data_.view().find_tile(*missing.brick, missing.tile)) {
            brick.samples.sampled = load_acquire(tile->sampled);
            still_sampled = lights_of_groups(brick.forgotten.sampled) & ~brick.forgotten.lights;
            brick.samples.uniform =
                load_relaxed(tile->uniform) & (lights_of_groups(brick.samples.sampled) | still_sampled);
            brick.samples.lit = load_relaxed(tile->lit) & brick.samples.uniform;
        }
        brick.fresh = groups_with_units(missing.units) & ~brick.samples.sampled;
        brick.newly_sampled = lights_of_groups(brick.fresh) & ~still_sampled;
    }

    /// Samples of groups that have none; places without a light are dark.
    void sample() {
        for (std::size_t l = 0; l < lights_per_tile; ++l) {
            const bool is_there = (lights_there_ >> l & 1) != 0;
            test(l, [&](const BrickInWork& brick) {
                return is_there && (brick.newly_sampled >> l & 1) != 0 && in_range(brick, l) != 0
                           ? brick_samples
                           : std::uint64_t{0};
            });
            for (BrickInWork& brick : bricks()) {
                if ((brick.newly_sampled >> l & 1) == 0)
                    continue;
                if (brick.lit[l] == 0 || brick.lit[l] == brick_samples)
                    brick.samples.uniform |= std::uint64_t{1} << l;
                if (brick.lit[l] == brick_samples)
                    brick.samples.lit |= std::uint64_t{1} << l;
            }
        }
        for (BrickInWork& brick : bricks())
            brick.samples.sampled |= brick.fresh;
    }

    /// What samples have not told.
    void test_mixed() {
        for (std::uint64_t rest = lights_there_; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const std::size_t group = l / lights_per_group;
            test(l, [&](const BrickInWork& brick) {
                if ((brick.samples.uniform >> l & 1) != 0)
                    return std::uint64_t{0};
                const std::uint64_t cells =
                    brick.missing->units >> group & every_byte & ~brick.forgotten.cells_with(l);
                const std::uint64_t sampled = (brick.newly_sampled >> l & 1) != 0 ? brick_samples : 0;
                return cells * 0xff & in_range(brick, l) & ~sampled;
            });
        }
    }

    void publish(const BrickInWork& brick) {
        BrickWords lit = brick.lit;
        if (columns_->has_ranges)
            for (std::size_t l = 0; l < lights_per_tile; ++l)
                if (lit[l] != 0)
                    lit[l] &= in_range(brick, l);
        std::uint64_t known = brick.missing->units;
        // Where all lights of a group are uniform, it is known in all cells.
        for (std::uint32_t group = 0; group < 8; ++group)
            if ((brick.fresh >> group & 1) != 0 && (~brick.samples.uniform >> (8 * group) & 0xff) == 0)
                known |= every_byte << group;
        data_.publish(*brick.missing->brick, tile_, known, lit, brick.samples);
    }

    /// The light points of the cells that a light may reach.
    std::uint64_t in_range(const BrickInWork& brick, std::size_t l) const {
        if (!columns_->has_ranges)
            return ~std::uint64_t{0};
        std::uint64_t points = 0;
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell)
            if (columns_->in_range(l, brick.positions[8 * cell], brick.positions[8 * cell + 7],
                                   data_.grid().radius()))
                points |= std::uint64_t{0xff} << (8 * cell);
        return points;
    }

    /// Tests points_of(brick) of each brick, and notes in `lit` which of them see the light.
    template <class PointsOf>
    void test(std::size_t l, PointsOf&& points_of) {
        for (std::size_t b = 0; b < brick_count_; ++b) {
            for (std::uint64_t rest = points_of(std::as_const(bricks_[b])); rest != 0; rest &= rest - 1) {
                const auto bit = static_cast<std::size_t>(std::countr_zero(rest));
                places_[size_] = static_cast<std::uint16_t>(64 * b + bit);
                points_[size_] = bricks_[b].positions[bit];
                if (++size_ == most_in_call)
                    test_listed(l);
            }
        }
        test_listed(l);
    }

    void test_listed(std::size_t l) {
        const std::size_t size = std::exchange(size_, 0);
        if (size == 0)
            return;
        const std::size_t light = data_.lights().order().light_at(tile_ * lights_per_tile + l);
        long_tests_(tracer_, data_.lights(), light, std::span<const glm::vec3>(points_).first(size),
                    std::span(seen_).first(size), cost_);
        for (std::size_t i = 0; i < size; ++i)
            bricks_[places_[i] / 64].lit[l] |= std::uint64_t{seen_[i]} << (places_[i] % 64);
    }

    MeshData& data_;
    const Tracer& tracer_;
    const LongTests& long_tests_;
    LongTestCost cost_;
    std::size_t tile_ = 0;
    const LightColumns* columns_ = nullptr;
    std::uint64_t lights_there_ = 0;
    std::size_t brick_count_ = 0;
    std::size_t size_ = 0;  ///< of what is listed
    std::array<std::uint16_t, most_in_call> places_;
    std::array<glm::vec3, most_in_call> points_;
    std::array<std::uint8_t, most_in_call> seen_;
    std::array<BrickInWork, most_bricks> bricks_;
};

}  // namespace lightmesh::detail
