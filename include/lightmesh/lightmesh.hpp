// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/concepts.hpp>
#include <lightmesh/grid.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
