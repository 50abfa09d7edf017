// SPDX-License-Identifier: MIT
// must say: lightmesh: lights must be a contiguous range of `Light`, such as a `std::vector<Light>`, which
// holds lights of all kinds
#include "wrong.hpp"

const std::vector<lightmesh::PointLight> lamps(3);
const lightmesh::VisibilityCache cache{Tracer{}, lamps, lightmesh::CacheSettings{}};
