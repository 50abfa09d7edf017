// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/brick_fill.hpp>
#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/support/room_for.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

/// Finds what queries lack, by long tests and stored.

namespace lightmesh::detail {

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
        entries_.make(size_++, MissingUnits{&brick, tile, units});
        table_[at] = static_cast<std::uint16_t>(size_);
        return true;
    }

    std::span<const MissingUnits> entries() const { return {entries_.data(), size_}; }

    void clear() {
        if (size_ != 0)
            table_.fill(0);
        size_ = 0;
    }

private:
    std::size_t size_ = 0;
    RoomFor<MissingUnits, capacity> entries_;
    std::array<std::uint16_t, 2 * capacity> table_{};
};

/// Finds units of bricks light by light, some bricks at once, and stores them.
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
    static constexpr std::size_t most_in_call = most_in_long_test<Tracer>;
    /// So many that their samples fill a call.
    static constexpr std::size_t most_bricks = most_in_call / std::popcount(brick_samples);

    void fill(std::span<const MissingUnits> missing, std::size_t tile) {
        tile_ = tile;
        brick_count_ = missing.size();
        for (std::size_t b = 0; b < missing.size(); ++b)
            bricks_[b].start(data_, missing[b]);
        if (data_.is_adaptive())
            sample();
        for (std::size_t l = 0; l < static_cast<std::size_t>(data_.lights().tile_size(tile)); ++l)
            test(l, [&](const BrickFill& brick) { return brick.others_of(l); });
        for (const BrickFill& brick : bricks())
            brick.publish(data_);
    }

    std::span<BrickFill> bricks() { return std::span(bricks_).first(brick_count_); }

    void sample() {
        for (std::size_t l = 0; l < lights_per_tile; ++l) {
            test(l, [&](const BrickFill& brick) { return brick.samples_of(l); });
            for (BrickFill& brick : bricks())
                brick.take_samples(l);
        }
        for (BrickFill& brick : bricks())
            brick.end_samples();
    }

    /// Tests points_of(brick) of each brick, and notes which of them see the light.
    template <class PointsOf>
    void test(std::size_t l, PointsOf&& points_of) {
        for (std::size_t b = 0; b < brick_count_; ++b) {
            for (std::uint64_t rest = points_of(std::as_const(bricks_[b])); rest != 0; rest &= rest - 1) {
                const auto bit = static_cast<std::size_t>(std::countr_zero(rest));
                places_[size_] = static_cast<std::uint16_t>(64 * b + bit);
                points_[size_] = bricks_[b].positions()[bit];
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
            bricks_[places_[i] / 64].add_lit(l, std::uint64_t{seen_[i]} << (places_[i] % 64));
    }

    MeshData& data_;
    const Tracer& tracer_;
    const LongTests& long_tests_;
    LongTestCost cost_;
    std::size_t tile_ = 0;
    std::size_t brick_count_ = 0;
    std::size_t size_ = 0;  ///< of what is listed
    std::array<std::uint16_t, most_in_call> places_;
    std::array<glm::vec3, most_in_call> points_;
    std::array<std::uint8_t, most_in_call> seen_;
    std::array<BrickFill, most_bricks> bricks_;
};

}  // namespace lightmesh::detail
