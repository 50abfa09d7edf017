// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace lightmesh {

/// Levels of a light mesh, by `SurfacePoint::footprint`, are 0 .. `most_mesh_levels` - 1.
inline constexpr std::size_t most_mesh_levels = 25;

/// The contents of a light mesh and what it took to fill it, all levels together: `LightMesh::statistics()`.
struct MeshStatistics {
    std::size_t light_points = 0;              ///< those whose visibility of at least one light is stored
    std::size_t bricks = 0;                    ///< blocks of 4x4x4 light points
    std::uint64_t long_tests = 0;              ///< V(L, x) computed: by rays, or looked up
    std::uint64_t long_rays = 0;               ///< rays of the Intersector spent on them
    std::uint64_t listed_rays = 0;             ///< rays of the caller's own tracer spent on them
    std::uint64_t link_rays = 0;               ///< rays of the Intersector between neighbouring light points
    std::uint64_t listed_link_rays = 0;        ///< the same of the caller's own tracer
    std::uint64_t depth_pictures = 0;          ///< views that the DepthRenderer has rendered
    std::uint64_t volume_grids = 0;            ///< grids of shadow volumes made, each of a view of a light
    std::uint64_t forgotten_visibilities = 0;  ///< V(L, x) that updates have forgotten
    std::uint64_t forgotten_links = 0;         ///< between neighbouring light points, the same
    std::uint64_t forgotten_floods = 0;        ///< what light points see over links, the same
    std::uint64_t forgotten_pictures = 0;      ///< of the views that were rendered, the same
    std::uint64_t forgotten_grids = 0;         ///< of the grids that were made, the same
    std::uint64_t evicted_bricks = 0;          ///< that `begin_frame` has forgotten for `memory_budget`
    std::size_t bytes = 0;                     ///< all memory of the mesh but its adapters
    /// The same for each level: the one of radius 2^k r at [k]; 0 where there is none.
    std::array<std::size_t, most_mesh_levels> light_points_of_level{};
    std::array<std::size_t, most_mesh_levels> bytes_of_level{};  ///< without what levels share

    /// Rays that were traced for what the mesh keeps, by whatever tracer.
    std::uint64_t kept_rays() const { return long_rays + listed_rays + link_rays + listed_link_rays; }

    /// Adds another mesh's work: long tests and rays.
    void add_work(const MeshStatistics& other) {
        long_tests += other.long_tests;
        long_rays += other.long_rays;
        listed_rays += other.listed_rays;
        link_rays += other.link_rays;
        listed_link_rays += other.listed_link_rays;
    }

    /// Adds what a mesh holds that has the radius of a level, which must be one.
    void add_level(std::size_t level, const MeshStatistics& held) {
        add_work(held);
        light_points += held.light_points;
        bricks += held.bricks;
        forgotten_visibilities += held.forgotten_visibilities;
        forgotten_links += held.forgotten_links;
        forgotten_floods += held.forgotten_floods;
        evicted_bricks += held.evicted_bricks;
        bytes += held.bytes;
        light_points_of_level[level] += held.light_points;
        bytes_of_level[level] += held.bytes;
    }
};

/// The cost of queries, for those that ask: pass a pointer to one, for each thread its own. A point between
/// two levels spends rays for both, and may be empty in both.
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

/// The contents of a visibility cache and what it took to fill it: `VisibilityCache::statistics()`. Rays that
/// two threads spent on the same thing count twice.
struct CacheStatistics {
    std::size_t records = 0;                         ///< places on surfaces and in the air
    std::size_t rows = 0;                            ///< blocks of visibilities of 8 lights, over all records
    std::array<std::size_t, 16> records_of_level{};  ///< [9] has step g; each has half the step of the last
    std::uint64_t lamp_rays = 0;                     ///< rays of the Intersector from records to lamps
    std::uint64_t listed_rays = 0;  ///< rays of the caller's own tracer from records to lamps
    std::uint64_t drop_rays = 0;    ///< rays that found the records' places
    std::uint64_t link_rays = 0;    ///< rays between neighbouring lattice points
    /// Rays from points, which nothing keeps: which lattice points a point sees, so that nothing leaks, and
    /// to lamps where no records serve, or `exact_edges` asks for it.
    std::uint64_t point_rays = 0;
    std::uint64_t forgotten_records = 0;  ///< that had to do with changes of the scene, over all updates
    std::uint64_t forgotten_values = 0;   ///< shares of lamps that updates have forgotten
    std::uint64_t evicted_records = 0;    ///< that `begin_frame` has forgotten for `memory_budget`
    std::size_t bytes = 0;                ///< all memory of the cache but its adapters

    /// Rays that were traced for what the cache keeps, by whatever tracer.
    std::uint64_t kept_rays() const { return lamp_rays + listed_rays + drop_rays + link_rays; }

    /// Adds another cache's work: rays of all kinds.
    void add_work(const CacheStatistics& other) {
        lamp_rays += other.lamp_rays;
        listed_rays += other.listed_rays;
        drop_rays += other.drop_rays;
        link_rays += other.link_rays;
        point_rays += other.point_rays;
    }
};

}  // namespace lightmesh
