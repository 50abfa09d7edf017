// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/brick_map.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/query/hemisphere.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace lightmesh::detail {

/// Light points of one brick that belong to an interpolation set.
struct BrickPoints {
    Brick* brick;
    std::uint64_t points;  ///< bits as in `bit_of`
};

/// An interpolation set, brick by brick, in memory of the caller's.
class Neighbours {
public:
    /// The hemisphere neighbours; makes the bricks that are missing. `memory` has a place for each brick of
    /// the hemisphere's box.
    template <class Kernel>
    void find(const Hemisphere& hemisphere, BrickMap& bricks, BrickPoints* memory) {
        entries_ = memory;
        first_brick_ = hemisphere.first_brick();
        bricks_ = hemisphere.bricks();
        RegionWindow regions(hemisphere, bricks);
        const glm::ivec3 first = hemisphere.first_brick();
        const int columns = hemisphere.bricks().x;
        size_ = 0;
        point_count_ = 0;
        hemisphere.for_each_row<Kernel>([&](int y, int z, const std::uint64_t* masks) {
            const RegionWindow::Row row = regions.row(first.y + y, first.z + z);
            for (int x = 0; x < columns; ++x) {
                if (masks[x] == 0)
                    continue;
                Brick* brick = row.find(first.x + x);
                if (brick == nullptr) [[unlikely]]
                    brick = &regions.make_brick({first.x + x, first.y + y, first.z + z}, bricks);
                entries_[size_++] = {brick, masks[x]};
                point_count_ += std::popcount(masks[x]);
            }
        });
    }

    std::span<BrickPoints> entries() { return {entries_, size_}; }
    std::span<const BrickPoints> entries() const { return {entries_, size_}; }

    /// The box of bricks: index of its first brick, and number of bricks, in each axis.
    const glm::ivec3& first_brick() const { return first_brick_; }
    const glm::ivec3& bricks() const { return bricks_; }

    /// The brick of a light point if that is one of the neighbours, else null.
    const Brick* brick_with(const glm::ivec3& index) const {
        const glm::ivec3 place(index.x >> 2, index.y >> 2, index.z >> 2);
        const int bit = bit_of(index.x & 3, index.y & 3, index.z & 3);
        for (const BrickPoints& entry : entries())
            if (entry.brick->place() == place)
                return (entry.points >> bit & 1) != 0 ? entry.brick : nullptr;
        return nullptr;
    }

    /// m of equation (3).
    int point_count() const { return point_count_; }

    void clear() {
        size_ = 0;
        point_count_ = 0;
    }

    /// Removes light points: keep(entry) returns those of an entry that stay.
    template <class Keep>
    void narrow(Keep&& keep) {
        std::size_t kept = 0;
        point_count_ = 0;
        for (const BrickPoints& entry : entries()) {
            const std::uint64_t points = entry.points & keep(entry);
            if (points == 0)
                continue;
            entries_[kept++] = {entry.brick, points};
            point_count_ += std::popcount(points);
        }
        size_ = kept;
    }

private:
    /// The regions that a hemisphere touches, each looked up once.
    class RegionWindow {
    public:
        RegionWindow(const Hemisphere& hemisphere, const BrickMap& bricks)
            : first_(region_of(hemisphere.first_brick())) {
            const glm::ivec3 last = region_of(hemisphere.first_brick() + hemisphere.bricks() - 1);
            for (int z = first_.z; z <= last.z; ++z)
                for (int y = first_.y; y <= last.y; ++y)
                    for (int x = first_.x; x <= last.x; ++x)
                        at({x, y, z}) = bricks.find_region({x, y, z});
        }

        /// The bricks along x at one y and z.
        struct Row {
            Region* const* regions;
            int first_region;
            std::size_t slot;

            Brick* find(int x) const {
                const Region* region = regions[(x >> 3) - first_region];
                return region != nullptr ? region->find_in_slot(slot | static_cast<std::size_t>(x & 7))
                                         : nullptr;
            }
        };

        Row row(int y, int z) { return {&at({first_.x, y >> 3, z >> 3}), first_.x, Region::slot({0, y, z})}; }

        Brick& make_brick(const glm::ivec3& place, BrickMap& bricks) {
            Brick& made = bricks.make_brick(place);
            at(region_of(place)) = bricks.find_region(region_of(place));
            return made;
        }

    private:
        static constexpr int side = (Hemisphere::max_bricks_per_axis - 2) / region_side + 2;

        static glm::ivec3 region_of(const glm::ivec3& brick) {
            return {brick.x >> 3, brick.y >> 3, brick.z >> 3};
        }

        Region*& at(const glm::ivec3& region) {
            const glm::ivec3 p = region - first_;
            return regions_[static_cast<std::size_t>(p.x + side * (p.y + side * p.z))];
        }

        glm::ivec3 first_;
        std::array<Region*, side * side * side> regions_;
    };

    BrickPoints* entries_ = nullptr;
    std::size_t size_ = 0;
    int point_count_ = 0;
    glm::ivec3 first_brick_{0};
    glm::ivec3 bricks_{0};
};

}  // namespace lightmesh::detail
