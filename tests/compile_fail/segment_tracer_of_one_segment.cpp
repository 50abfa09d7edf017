// SPDX-License-Identifier: MIT
// must not fit: SegmentTracer
#include "wrong.hpp"

void fill(const lightmesh::VisibilityCache<Tracer>& cache, const lightmesh::LampRayList& list) {
    cache.fill(list, [](const lightmesh::Segment&) { return false; });
}
