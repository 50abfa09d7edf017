// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/map_source.hpp>
#include <lightmesh/fill/volume_source.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/shadows/shadow_map.hpp>
#include <lightmesh/shadows/shadow_volume.hpp>
#include <lightmesh/snapshot.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// What programs that must not compile have in common. Each begins with the sentence that the compiler must
/// give, and no other of ours; or with the name of what is deleted, or of the concept that its callable does
/// not fit.

inline const std::vector<lightmesh::Light> lights{lightmesh::PointLight{}};

struct Tracer {
    bool occluded(const lightmesh::Segment&) const { return false; }
};
