// SPDX-License-Identifier: MIT
// must call what is deleted: VisibilityCache
#include "wrong.hpp"

const lightmesh::VisibilityCache cache{Tracer{}, lights, lightmesh::CacheSettings{}};
const auto copy = cache;
