// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/host_rays.hpp"
#include "render/scene_cache.hpp"

#include <lightmesh/surface_point.hpp>

#include <span>

namespace demo {

/// Makes a cache know what queries at some points need, but for rays from the points themselves: on all
/// threads, level by level, with rays to lamps by `trace`, which any of them may call. Throws what that
/// throws, and what the cache does.
void fill_by_lists(const SceneCache& cache, std::span<const lightmesh::SurfacePoint> points,
                   const TraceSegments& trace);

}  // namespace demo
