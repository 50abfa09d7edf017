// SPDX-License-Identifier: MIT
#pragma once

/// All that a program needs which has a `DepthRenderer` and no light mesh.

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/depth_view.hpp>
#include <lightmesh/adapters/diagnostics.hpp>
