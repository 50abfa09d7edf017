// SPDX-License-Identifier: MIT
// must not fit: SegmentTracer
#include "wrong.hpp"

void fill(const lightmesh::LightMesh<Tracer>& mesh, const lightmesh::LinkList& list) {
    mesh.fill_links(list, [](const lightmesh::Segment&) { return false; });
}
