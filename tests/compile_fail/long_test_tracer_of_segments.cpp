// SPDX-License-Identifier: MIT
// must not fit: LongTestTracer
#include "wrong.hpp"

void fill(const lightmesh::LightMesh<Tracer>& mesh, const lightmesh::LongTestList& list) {
    mesh.fill(list, [](std::span<const lightmesh::Segment>, std::span<std::uint8_t>) {});
}
