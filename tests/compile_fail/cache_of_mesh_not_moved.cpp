// SPDX-License-Identifier: MIT
// must call what is deleted: LightMesh
#include "wrong.hpp"

lightmesh::LightMesh mesh{Tracer{}, lights, lightmesh::Settings{}};
const lightmesh::VisibilityCache blur{mesh, lightmesh::CacheSettings{}};
