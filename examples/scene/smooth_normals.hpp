// SPDX-License-Identifier: MIT
#pragma once

#include "model.hpp"

namespace demo {

/// Gives a mesh that has no normals smooth ones: the mean over the triangles around a place, as far as they
/// lie within 40 degrees of the corner's own. Vertices on sharper edges are split.
void smooth_normals(ModelMesh& mesh);

}  // namespace demo
