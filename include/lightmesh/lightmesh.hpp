// SPDX-License-Identifier: MIT
#pragma once

/// All of the library but `tune.hpp` and `gpu/`. Its rooms, each of which knows only those before it:
///
///     support/   vectors, checks, shared integers
///     adapters/  what a user's program must do, and may do: the contract
///     mesh/      what is stored: grid, lights, bricks; snapshots and merging
///     shadows/   shadow maps and shadow volumes
///     fill/      what is missing is traced, or looked up, and published
///     query/     equations (2) and (3): neighbours, short tests, sums; kernels
///     cache/     the visibility of real lamps at records on surfaces
///     gpu/       what shaders read, and the shaders' side of it
///
/// The words of its comments:
///
///     light point       a point of the grid; the mesh knows which lights it sees
///     step, radius      h between light points, r of the hemisphere of equation (2), world units; q = r / h
///     level             a grid of 2^k times the step and the radius, for wide footprints
///     brick, cell       4x4x4 light points; the eight 2x2x2 light points in it
///     region            8x8x8 bricks, where they are looked up
///     slot              a light's place in the order of storing; also a brick's in a region, a box, a window
///     tile, group       64 lights in neighbouring slots; eight of them
///     unit              a cell and a group: what is known, or not, as one
///     row, words        what a cell's light points see: a byte a light, or words where few are mixed
///     uniform           of a light that all light points of a brick see, or none
///     long, short test  V of light point and light, stored; V of surface point and light point
///     link              whether the segment between neighbouring light points is open
///     seed, flood       a light point that a surface point sees; what is reached from it over open links
///     record, column    of a cache: a place on a surface; the line of the lattice on which it was found
///     tap               a record that a query blends
///
/// A newcomer reads `light_mesh.hpp` with `lights.hpp`, `settings.hpp` and `adapters/concepts.hpp`; then
/// `mesh/brick.hpp` (what is stored), `query/point_query.hpp` (a query's way; of many points
/// `query/block_query.hpp`), `query/hemisphere.hpp` (the neighbours of equation (2)), `query/tally.hpp` and
/// `query/kernels/portable.hpp` (the sum of equation (3)); for the linked short test `mesh/flood.hpp` and
/// `fill/flood_fill.hpp`; for the cache `visibility_cache.hpp`, then `cache/query.hpp`, `cache/taps.hpp` and
/// `cache/store.hpp`.
///
/// Who needs rays only may include `light_mesh.hpp` alone. Namespace `detail` may change at any time.

#include <lightmesh/adapters/check_tracer.hpp>
#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/depth_renderer.hpp>
#include <lightmesh/adapters/depth_view.hpp>
#include <lightmesh/adapters/diagnostics.hpp>
#include <lightmesh/adapters/occluders.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/cache/lamp_ray_list.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/fill/link_list.hpp>
#include <lightmesh/fill/long_test_list.hpp>
#include <lightmesh/fill/map_source.hpp>
#include <lightmesh/fill/segment_tracer.hpp>
#include <lightmesh/fill/share_finder.hpp>
#include <lightmesh/fill/source.hpp>
#include <lightmesh/fill/volume_source.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/shadow_rays.hpp>
#include <lightmesh/shadows/shadow_map.hpp>
#include <lightmesh/shadows/shadow_volume.hpp>
#include <lightmesh/snapshot.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/surface_point.hpp>
#include <lightmesh/visibility_cache.hpp>
