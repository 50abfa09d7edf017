// SPDX-License-Identifier: MIT
#pragma once

#include "gltf_file.hpp"

#include <string>

namespace demo {

/// Poses the nodes of a file, and the weights of their morph targets, as an animation has them at `time`
/// seconds. Before its first key and after its last one a channel keeps that one's value. Returns when the
/// last key of all is; 0 for a file without animations. `animation`: by its name, or its number from 0;
/// empty: the first one. Notes say what was chosen. Throws std::runtime_error for an animation that is not
/// there, or damaged.
double pose_at(GltfFile& file, double time, const std::string& animation);

}  // namespace demo
