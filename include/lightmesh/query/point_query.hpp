// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/long_fill.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/kernels/kernel_types.hpp>
#include <lightmesh/query/kernels/kernels.hpp>
#include <lightmesh/query/neighbours.hpp>
#include <lightmesh/query/query_point.hpp>
#include <lightmesh/query/short_test.hpp>
#include <lightmesh/query/tally.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <limits>

namespace lightmesh::detail {

/// S of one light at one point, as `LightMesh::visibility`.
template <class Filler>
float query_one(const Filler& filler, const glm::vec3& position, const glm::vec3& normal, std::size_t light,
                QueryStatistics* statistics) {
    if (!is_finite(position) || !is_finite(normal))
        return std::numeric_limits<float>::quiet_NaN();
    MeshView mesh = filler.data().view();
    QueryPoint point(position, normal);
    point.grid_pos = mesh.grid->locate(position);
    if (!mesh.lights->can_light(light, position, point.normal))
        return 0.0f;

    const Hemisphere hemisphere(*mesh.grid, point.grid_pos, point.position, point.normal);
    BrickMask masks[Hemisphere::most_bricks];
    BrickPoints entries[Hemisphere::most_bricks];
    const std::size_t size = kernels().find_masks(hemisphere, masks);
    for (std::size_t i = 0; i < size; ++i) {
        const glm::ivec3 coord = hemisphere.first_brick + glm::ivec3(masks[i].x, masks[i].y, masks[i].z);
        entries[i] = {filler.use_brick(mesh, coord), masks[i].points, 0, 0};
    }
    point.neighbours = Neighbours(entries, size);
    mesh = filler.data().view();
    const ShortTest short_test = mesh.settings->short_test;
    const std::size_t slot = mesh.lights->order().slot_of(light);
    const std::size_t tile = slot / lights_per_tile;
    const std::uint64_t bit = std::uint64_t{1} << (slot % lights_per_tile);
    const std::uint64_t group = every_byte << (slot % lights_per_tile / lights_per_group);
    if (short_test == ShortTest::linked) {
        point.is_uniform = bricks_agree(mesh, point.neighbours.entries(), tile, bit);
        point.seeds = {*mesh.grid, point.grid_pos, point.position, point.normal};
        while (point.next_seed()) {
            if (statistics != nullptr)
                ++statistics->short_rays;
            const Segment ray{surface_end_of(point, *mesh.grid), mesh.grid->position(point.seed)};
            if (!filler.tracer().occluded(ray) && (point.is_uniform || link_to_seed(filler, mesh, point)))
                break;
        }
    }

    if (point.is_uniform && point.neighbours.point_count() != 0)
        return mesh.sees_uniform(*point.neighbours.entries().front().brick, tile, bit) ? 1.0f : 0.0f;
    MissingList missing;
    for (const BrickPoints& entry : point.neighbours.entries()) {
        const std::uint64_t units = mesh.missing(*entry.brick, tile, cells_in(entry.points) & group);
        if (units != 0 && !missing.add(*entry.brick, tile, units)) {
            filler.fill(missing);
            missing.clear();
            missing.add(*entry.brick, tile, units);
        }
    }
    if (!missing.entries().empty()) {
        filler.fill(missing);
        mesh = filler.data().view();
    }
    const auto lit = [&] {
        return count_lit(mesh, point.neighbours.entries(), tile, slot % lights_per_tile);
    };
    if (short_test == ShortTest::exact && point.neighbours.point_count() != 0) {
        const int seen = lit();
        if ((seen == 0 || seen == point.neighbours.point_count()) &&
            sees_any_neighbour(filler.tracer(), mesh, point, statistics))
            return seen == 0 ? 0.0f : 1.0f;
        test_neighbours(filler.tracer(), mesh, point, statistics);
    }
    if (point.neighbours.point_count() != 0)
        return static_cast<float>(lit()) / static_cast<float>(point.neighbours.point_count());
    if (statistics != nullptr) {
        ++statistics->empty_points;
        ++statistics->shadow_rays;
    }
    const Segment ray = mesh.lights->shadow_segment(light, surface_end_of(point, *mesh.grid));
    return filler.tracer().occluded(ray) ? 0.0f : 1.0f;
}

}  // namespace lightmesh::detail
