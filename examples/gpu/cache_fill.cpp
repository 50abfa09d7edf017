// SPDX-License-Identifier: MIT
#include "gpu/cache_fill.hpp"

#include <lightmesh/visibility_cache.hpp>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace demo {

namespace {

using Points = std::span<const lightmesh::SurfacePoint>;

/// Points whose records a thread has filled at once: their rays are enough for a dispatch.
constexpr std::size_t points_to_fill = 4096;
/// Points whose lack is listed together.
constexpr std::size_t points_to_list = 64;

/// What is listed for a point tells whether finer records will be needed.
void fill_part(const SceneCache& cache, Points points, const FillList& fill) {
    std::vector<Points> lacking;
    for (std::size_t first = 0; first < points.size(); first += points_to_list)
        lacking.push_back(points.subspan(first, (std::min)(points_to_list, points.size() - first)));
    while (!lacking.empty()) {
        lightmesh::LampRayList all;
        std::erase_if(lacking, [&](Points some) {
            lightmesh::LampRayList list;
            cache.list_lamp_rays(some, list);
            all.add(list);
            return list.is_empty();
        });
        fill(all);
    }
}

}  // namespace

void fill_by_lists(const SceneCache& cache, Points points, const FillList& fill) {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, points.size(), points_to_fill),
        [&](const auto& part) { fill_part(cache, points.subspan(part.begin(), part.size()), fill); });
}

}  // namespace demo
