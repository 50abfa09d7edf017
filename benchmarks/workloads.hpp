// SPDX-License-Identifier: MIT
#pragma once

#include "contestant.hpp"

#include <cstddef>
#include <string>

namespace bench {

/// The points of all rows: a picture of this size, seen by the scene's own camera.
inline constexpr int picture_width = 1920;
inline constexpr int picture_height = 1440;

/// A built-in scene under `lights` lights spread evenly over it. Made when first asked for, and kept.
const Workload& workload(const std::string& scene, std::size_t lights);

/// The points that a row is timed on: all for `most` = 0, else a part of them. Made when first asked for, and
/// kept.
const ShadingPoints& points_of(const std::string& scene, std::size_t most);

}  // namespace bench
