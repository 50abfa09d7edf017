// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/query/neighbours.hpp>
#include <lightmesh/query/query_point.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/statistics.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

/// V(P, x) of equation (2).

namespace lightmesh::detail {

/// The linked short test: adds the neighbours that the flood of a seed reaches, which the point is known to
/// see: reach(entry) returns them. Returns true if that is enough: two thirds of the hemisphere. Else the
/// seed may lie in a hollow that P sees through a crack, and further ones are tried; what is reached from any
/// of them counts.
template <class Reach>
bool link_reached(QueryPoint& point, Reach&& reach) {
    point.linked_count = point.neighbours.link(reach);
    if (3 * point.linked_count < 2 * point.neighbours.point_count())
        return false;
    point.neighbours.keep_linked();
    return true;
}

/// The same for a point alone.
template <class Filler>
bool link_to_seed(const Filler& filler, const MeshView& mesh, QueryPoint& point) {
    const std::uint32_t flood = filler.flood_of(mesh, *point.seed_entry->brick, point.seed);
    const FloodView reached(&mesh.words[flood - 1]);
    const FloodBox box(point.seed, mesh.grid->quality());
    const std::size_t slots = FloodBox::slots(mesh.grid->quality());
    return link_reached(point, [&](const BrickPoints& entry) {
        const glm::ivec3 coord = entry.brick->position();
        return box.contains(coord) ? reached.in_slot(box.slot(coord), slots) : std::uint64_t{0};
    });
}

/// The light points that a seed's flood reaches in the bricks of a `BrickWindow`. The points of a block have
/// few seeds: each is unpacked for many of them.
class WindowFlood {
public:
    /// True if it is that of a seed, and of a window by its number.
    bool is_of(const glm::ivec3& seed, std::uint32_t window) const {
        return is_there_ && seed == seed_ && window == window_;
    }

    void unpack(const FloodView& flood, const glm::ivec3& seed, float quality, const BrickWindow& window,
                std::uint32_t window_number) {
        is_there_ = true;
        seed_ = seed;
        window_ = window_number;
        const FloodBox box(seed, quality);
        const std::size_t words = FloodView::bit_words(FloodBox::slots(quality));
        std::fill_n(reached_.begin(), window.size(), 0);
        const auto side = static_cast<std::size_t>(box.side);
        const std::uint64_t* full = flood.words() + 1;
        const std::uint64_t* partial = full + words;
        const std::uint64_t* masks = partial + words;
        glm::ivec3 coord = box.first;
        std::size_t row = 0;  // the first slot of coord's row along x
        for (std::size_t w = 0; w < words; ++w)
            for (std::uint64_t rest = full[w] | partial[w]; rest != 0; rest &= rest - 1) {
                const std::size_t slot = 64 * w + static_cast<std::size_t>(std::countr_zero(rest));
                for (; slot >= row + side; row += side)
                    if (++coord.y == box.first.y + box.side) {
                        coord.y = box.first.y;
                        ++coord.z;
                    }
                coord.x = box.first.x + static_cast<int>(slot - row);
                const bool is_partial = (partial[w] & rest & (~rest + 1)) != 0;
                if (window.contains(coord))
                    reached_[window.slot_of(coord)] = is_partial ? *masks : ~std::uint64_t{0};
                masks += is_partial ? 1 : 0;
            }
    }

    /// The light points that are reached in a slot of the window.
    std::uint64_t in_slot(std::uint32_t slot) const { return reached_[slot]; }

private:
    bool is_there_ = false;
    glm::ivec3 seed_{0};
    std::uint32_t window_ = 0;
    std::array<std::uint64_t, BrickWindow::most_slots> reached_;
};

/// True if P sees at least one of its neighbours: then the interpolation set is not empty.
template <Intersector Tracer>
bool sees_any_neighbour(const Tracer& tracer, const MeshView& mesh, const QueryPoint& point,
                        QueryStatistics* statistics) {
    const glm::vec3 end = surface_end_of(point, *mesh.grid);
    for (const BrickPoints& entry : point.neighbours.entries()) {
        for (std::uint64_t rest = entry.points; rest != 0; rest &= rest - 1) {
            if (statistics != nullptr)
                ++statistics->short_rays;
            const glm::ivec3 pos = grid_pos_of(entry.brick->position(), std::countr_zero(rest));
            if (!tracer.occluded(Segment{end, mesh.grid->position(pos)}))
                return true;
        }
    }
    return false;
}

/// The exact short test: leaves the neighbours that P sees, by a ray for each.
template <Intersector Tracer>
void test_neighbours(const Tracer& tracer, const MeshView& mesh, QueryPoint& point,
                     QueryStatistics* statistics) {
    const glm::vec3 end = surface_end_of(point, *mesh.grid);
    point.neighbours.narrow([&](const BrickPoints& entry) {
        std::array<Segment, most_segments> segments;
        std::array<std::uint8_t, most_segments> hit;
        std::size_t size = 0;
        for (std::uint64_t rest = entry.points; rest != 0; rest &= rest - 1) {
            const glm::ivec3 pos = grid_pos_of(entry.brick->position(), std::countr_zero(rest));
            segments[size++] = {end, mesh.grid->position(pos)};
        }
        trace(tracer, std::span<const Segment>(segments).first(size), std::span(hit).first(size));
        if (statistics != nullptr)
            statistics->short_rays += size;
        std::uint64_t seen = 0;
        std::size_t i = 0;
        for (std::uint64_t rest = entry.points; rest != 0; rest &= rest - 1)
            if (hit[i++] == 0)
                seen |= rest & (~rest + 1);
        return seen;
    });
}

}  // namespace lightmesh::detail
