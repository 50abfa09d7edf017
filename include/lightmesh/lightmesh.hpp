// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/bounds.hpp>
#include <lightmesh/concepts.hpp>
#include <lightmesh/depth_renderer.hpp>
#include <lightmesh/depth_view.hpp>
#include <lightmesh/grid.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/long_test_source.hpp>
#include <lightmesh/occluders.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/shadow_map.hpp>
#include <lightmesh/shadow_volume.hpp>
#include <lightmesh/statistics.hpp>
