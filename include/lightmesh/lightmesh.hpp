// SPDX-License-Identifier: MIT
#pragma once

/// All of the library but `tune.hpp`. A newcomer reads, in this order:
///
/// 1. the class that users meet: `light_mesh.hpp`, with `lights.hpp` and `settings.hpp`;
/// 2. what a ray tracer must do: `concepts.hpp`; and what it may do beyond that, for shadow maps and shadow
///    volumes: `depth_renderer.hpp` and `occluders.hpp`; `check_tracer.hpp` tests a ray tracer at run time;
/// 3. how a query works: `query/query.hpp`, then `query/hemisphere.hpp` (the neighbours of equation (2)),
///    `detail/neighbours.hpp` and `detail/kernels/portable.hpp` (the sum of equation (3));
/// 4. what is stored: `detail/visibility_store.hpp`, `detail/brick.hpp` and `detail/brick_map.hpp`;
/// 5. the linked short test: `detail/links.hpp`, `detail/reach.hpp` and `detail/reach_search.hpp`;
/// 6. long tests: `detail/long_test.hpp`, `shadow_map.hpp` and `shadow_volume.hpp`.
/// 7. the cache of visibilities of real lamps: `visibility_cache.hpp`, then `cache/query.hpp` (levels and
/// taps),
///    `cache/taps.hpp`, `cache/blend.hpp`, and what is kept: `cache/store.hpp`, `cache/record.hpp`.
///
/// What lies in `detail/`, as in namespace `detail`, may change at any time.

#include <lightmesh/adapters/check_tracer.hpp>
#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/depth_renderer.hpp>
#include <lightmesh/adapters/depth_view.hpp>
#include <lightmesh/adapters/occluders.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/fill/source.hpp>
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
