// SPDX-License-Identifier: MIT
// must not fit: SegmentTracer
#include "wrong.hpp"

void fill(const lightmesh::VisibilityCache<Tracer>& cache, const lightmesh::LampRayList& list) {
    cache.fill(list, [](std::span<const lightmesh::Segment>, std::span<bool>) {});
}
