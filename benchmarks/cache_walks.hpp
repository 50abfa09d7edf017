// SPDX-License-Identifier: MIT
#pragma once

namespace bench {

/// What the eye sees first in shadows that a visibility cache interpolates, as rows of a table: whether thin
/// things keep their contact shadows, whether a slow walk over a surface meets steps, whether a soft edge has
/// waves, and whether more changes from frame to frame than rays would.
void print_cache_walks();

}  // namespace bench
