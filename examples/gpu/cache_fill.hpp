// SPDX-License-Identifier: MIT
#pragma once

#include "render/scene_cache.hpp"

#include <lightmesh/cache/lamp_ray_list.hpp>
#include <lightmesh/surface_point.hpp>

#include <functional>
#include <span>

namespace demo {

/// Finds what is listed: by `SceneCache::fill_shares`, or `fill`.
using FillList = std::function<void(const lightmesh::LampRayList&)>;

/// Makes a cache know what queries at some points need, but for rays from the points themselves: on all
/// threads, level by level, by `fill`, which any of them may call. Throws what that throws, and what the
/// cache does.
void fill_by_lists(const SceneCache& cache, std::span<const lightmesh::SurfacePoint> points,
                   const FillList& fill);

}  // namespace demo
