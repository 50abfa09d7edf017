// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/fill/flood_fill.hpp>
#include <lightmesh/fill/link_fill.hpp>
#include <lightmesh/fill/link_list.hpp>
#include <lightmesh/fill/list_fill.hpp>
#include <lightmesh/fill/long_fill.hpp>
#include <lightmesh/fill/long_test_list.hpp>
#include <lightmesh/fill/unit_table.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/merge.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/statistics.hpp>

#include <glm/vec3.hpp>

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace lightmesh::detail {

/// A mesh's data with the adapters that add to it when queries lack something. To its users it is constant,
/// and any number of threads may ask. The adapters are somebody else's.
template <Intersector Tracer, class LongTests>
class MeshFiller {
public:
    /// The other arguments are those of `MeshData`.
    template <class... DataArguments>
    MeshFiller(const Tracer& tracer, const LongTests& long_tests, const DataArguments&... data)
        : tracer_(tracer), long_tests_(long_tests), data_(data...) {}

    const Tracer& tracer() const { return tracer_; }
    MeshData& data() const { return data_; }

    /// The brick of these coordinates, made if it is not there, for a query.
    const Brick* use_brick(const MeshView& mesh, const glm::ivec3& coord) const {
        const Brick* brick = mesh.find_brick(coord);
        if (brick == nullptr)
            brick = &data_.find_or_make_brick(coord);
        data_.mark_used(*brick);
        return brick;
    }

    /// Afterwards all units of the list are known.
    void fill(const MissingList& missing) const {
        LongFill long_fill(data_, tracer_, long_tests_);
        long_fill.run(missing.entries());
        long_tests_done_.fetch_add(long_fill.cost().tests, std::memory_order_relaxed);
        long_rays_.fetch_add(long_fill.cost().rays, std::memory_order_relaxed);
    }

    /// The same for many units of this level, by a caller's own tracer.
    template <LongTestTracer Trace>
    void fill(std::span<const UnitTable::Entry> missing, std::uint32_t level, Trace& trace) const {
        ListFill<Trace> list_fill(data_, level, trace);
        list_fill.run(missing);
        long_tests_done_.fetch_add(list_fill.rays(), std::memory_order_relaxed);
        listed_rays_.fetch_add(list_fill.rays(), std::memory_order_relaxed);
    }

    /// Finds and stores links of cells of bricks of this level (one bit a cell) by a caller's own tracer.
    template <LinkTracer Trace>
    void fill_links(std::span<const UnitTable::Entry> missing, std::uint32_t level, Trace& trace) const {
        LinkListFill<Trace> link_fill(data_, level, trace);
        link_fill.run(missing);
        listed_link_rays_.fetch_add(link_fill.rays(), std::memory_order_relaxed);
    }

    /// Index plus one of the flood of a light point of the brick, found if nobody has yet.
    std::uint32_t flood_of(const MeshView& mesh, const Brick& brick, const glm::ivec3& seed) const {
        if (const std::uint32_t known = find_flood(mesh, brick, bit_in_brick(seed)); known != 0)
            return known;
        FloodSearch<Tracer> search(tracer_, data_, brick, seed);
        const std::uint32_t found = search.find();
        link_rays_.fetch_add(search.rays(), std::memory_order_relaxed);
        return found + 1;
    }

    /// Takes over what another mesh knows, as `copy_level`, and what that has cost.
    template <class Keep>
    void copy(const MeshFiller& other, const Keep& keep, bool keeps_lights) const {
        copy_level(other.data_, data_, keep, keeps_lights);
        long_tests_done_.store(other.long_tests_done_.load(std::memory_order_relaxed),
                               std::memory_order_relaxed);
        long_rays_.store(other.long_rays_.load(std::memory_order_relaxed), std::memory_order_relaxed);
        listed_rays_.store(other.listed_rays_.load(std::memory_order_relaxed), std::memory_order_relaxed);
        link_rays_.store(other.link_rays_.load(std::memory_order_relaxed), std::memory_order_relaxed);
        listed_link_rays_.store(other.listed_link_rays_.load(std::memory_order_relaxed),
                                std::memory_order_relaxed);
    }

    /// Walks over all that is stored. Without what adapters and lights take.
    MeshStatistics statistics() const {
        MeshStatistics sum;
        const MeshView mesh = data_.view();
        data_.for_each_brick([&](const Brick& brick) {
            std::uint64_t cells = 0;
            for (std::size_t t = 0; t < mesh.lights->tile_count(); ++t)
                if (const BrickTile* tile = mesh.find_tile(brick, t))
                    cells |= cells_in(load_acquire(tile->known));
            // 8 bits for each cell of 8 light points.
            sum.light_points += static_cast<std::size_t>(std::popcount(cells));
            ++sum.bricks;
        });
        sum.long_tests = long_tests_done_.load(std::memory_order_relaxed);
        sum.long_rays = long_rays_.load(std::memory_order_relaxed);
        sum.listed_rays = listed_rays_.load(std::memory_order_relaxed);
        sum.link_rays = link_rays_.load(std::memory_order_relaxed);
        sum.listed_link_rays = listed_link_rays_.load(std::memory_order_relaxed);
        sum.bytes = data_.bytes() + sizeof *this - sizeof data_;
        return sum;
    }

private:
    const Tracer& tracer_;
    const LongTests& long_tests_;
    mutable MeshData data_;
    mutable std::atomic<std::uint64_t> long_tests_done_{0};
    mutable std::atomic<std::uint64_t> long_rays_{0};
    mutable std::atomic<std::uint64_t> listed_rays_{0};
    mutable std::atomic<std::uint64_t> link_rays_{0};
    mutable std::atomic<std::uint64_t> listed_link_rays_{0};
};

}  // namespace lightmesh::detail
