// SPDX-License-Identifier: MIT
// must not fit: LinkTracer
#include "wrong.hpp"

void fill(const lightmesh::LightMesh<Tracer>& mesh, const lightmesh::LinkList& list) {
    mesh.fill_links(list, [](std::span<const lightmesh::Segment>, std::span<std::uint8_t>) {});
}
