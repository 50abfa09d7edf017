// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/query/kernels/kernel_types.hpp>

#include <glm/vec3.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// Which lights of a tile can reach a point at all: chi of equation (3), range and cone.
inline std::uint64_t find_reaching(const LightTable& lights, const Kernels& kernels, std::size_t tile,
                                   const glm::vec3& point, const glm::vec3& unit_normal) {
    const LightColumns& columns = lights.tile(tile);
    if (!columns.box.holds(point))
        return 0;
    std::uint64_t reaching = kernels.find_facing(columns, point, unit_normal);
    if (!columns.cones.empty())
        for (std::uint64_t rest = reaching; rest != 0; rest &= rest - 1)
            if (!columns.inside_cone(static_cast<std::size_t>(std::countr_zero(rest)), point))
                reaching ^= rest & (~rest + 1);
    return reaching;
}

}  // namespace lightmesh::detail
