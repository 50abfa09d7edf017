// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

namespace lightmesh {

/// What a light mesh holds and what it took to fill it: `LightMesh::statistics()`.
struct MeshStatistics {
    std::size_t light_points = 0;  ///< those whose visibility of at least one light is stored
    std::size_t bricks = 0;        ///< blocks of 4x4x4 light points
    std::uint64_t long_tests = 0;  ///< V(L, x) computed: by rays, or looked up
    std::uint64_t long_rays = 0;   ///< rays of the Intersector spent on them
    std::uint64_t link_rays = 0;   ///< rays of the Intersector between neighbouring light points
    std::size_t bytes = 0;         ///< all memory of the mesh but its adapters
};

/// What queries spent, for those that ask: pass a pointer to one, for each thread its own.
struct QueryStatistics {
    std::uint64_t points = 0;        ///< surface points queried
    std::uint64_t short_rays = 0;    ///< rays from surface points to light points
    std::uint64_t shadow_rays = 0;   ///< rays from surface points to lights, for those without neighbours
    std::uint64_t empty_points = 0;  ///< surface points with m = 0 that needed such rays

    /// Adds another thread's.
    QueryStatistics& operator+=(const QueryStatistics& other) {
        points += other.points;
        short_rays += other.short_rays;
        shadow_rays += other.shadow_rays;
        empty_points += other.empty_points;
        return *this;
    }
};

}  // namespace lightmesh
