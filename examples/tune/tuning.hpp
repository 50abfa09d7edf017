// SPDX-License-Identifier: MIT
#pragma once

#include "render/embree_scene.hpp"
#include "tune/options.hpp"
#include "tune/sampling.hpp"

#include <lightmesh/tune.hpp>

#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace demo {

/// All that is known after a while, or in the end.
struct Tuning {
    float middle_radius = 0.0f;                           ///< of the mesh that is recommended
    std::optional<lightmesh::tune::RadiusAdvice> advice;  ///< unless the user gave radii
    double shadow_ray_ns_per_point = 0.0;                 ///< hard shadows, one ray per facing light
    double forecast_seconds = 0.0;
    std::vector<lightmesh::tune::Measurement> measurements;
    bool finished = false;
};

/// The number that `lamps_of` needs to give lamps the sizes that `lightmesh-render` gives them by default.
VisibilityOptions lamp_options(const EmbreeScene& scene, const TuneOptions& options);

/// Predicts, says so on the screen, and measures with a progress bar until all is done or Ctrl-C is pressed.
/// `done` is what an earlier run has found; `save` is called whenever there is something new.
Tuning tune_scene(const EmbreeScene& scene, const ShadingPoints& samples, const TuneOptions& options,
                  std::span<const lightmesh::tune::Measurement> done,
                  const std::function<void(const Tuning&)>& save);

}  // namespace demo
