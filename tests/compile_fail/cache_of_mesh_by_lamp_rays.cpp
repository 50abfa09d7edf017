// SPDX-License-Identifier: MIT
// must not fit: same_as
#include "wrong.hpp"

using Mesh = lightmesh::LightMesh<Tracer>;

void fill(const lightmesh::VisibilityCache<Tracer, lightmesh::MeshRows<Mesh>>& blur,
          const lightmesh::LampRayList& list) {
    blur.fill(list, [](std::span<const lightmesh::Segment>, std::span<std::uint8_t>) {});
}
