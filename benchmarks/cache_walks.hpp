// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace bench {

/// What the eye sees first in shadows that a visibility cache interpolates, as a table: whether thin things
/// keep their contact shadows, whether a slow walk over a surface meets steps, whether a soft edge has waves,
/// and whether anything changes from frame to frame where nothing moves but the camera.
std::string cache_walks();

}  // namespace bench
