// SPDX-License-Identifier: MIT
#pragma once

#include "render/ranks.hpp"
#include "render/renderer.hpp"

#include <functional>

namespace demo {

/// As `render`, by all ranks, which must call this together with the same scene, kind of visibility and
/// options: pieces of it are shared out. Returns the picture on rank 0, and an empty one elsewhere.
/// `statistics` is of this rank's tiles; progress is called on rank 0, with the share that all have done.
/// The picture is made in `together_rounds` rounds, each with tiles from everywhere: after_round() is called
/// on all ranks after each, and may let them know what the others have found. Throws also what `share_out`
/// throws, `Interrupted` if the program was told to end.
Image render_together(Ranks& ranks, const EmbreeScene& scene, const Visibility& visibility,
                      const RenderOptions& options, RenderStatistics& statistics, const Progress& progress,
                      const std::function<void()>& after_round);

/// Things that two parts of a picture need, seen in a mirror say, both would find if they were rendered at
/// once: it is found twice only by those of the same round.
inline constexpr int together_rounds = 7;

}  // namespace demo
