// SPDX-License-Identifier: MIT
#pragma once

#include "render/visibility.hpp"

#include <lightmesh/lights.hpp>

#include <span>
#include <string>
#include <vector>

namespace demo {

/// The scene's lights with the sizes that `area` and `cache` give them. Those of `options.light_size`, if it
/// is not 0; else those of the scene (surfaces that shine); else `default_lamp_radius`, and for directional
/// lights the sun's angle. Rectangles always have their own size. A directional light of a given
/// `light_size` is as wide as such a lamp at half of the scene's diagonal.
std::vector<lightmesh::Light> lamps_of(const EmbreeScene& scene, const VisibilityOptions& options);

/// A copy of no more than `lamps_of` looks at.
VisibilityOptions lamp_options(const VisibilityOptions& options);

/// The radii of lamps where shadow rays to them end, `far_away` for directional lights; of rectangles 0.
std::vector<float> sizes_at_ends(std::span<const lightmesh::Light> lamps, float far_away);

/// The radius of lamps of which nothing is known, world units: a third of r. So penumbrae can be seen in the
/// view that r suits.
float default_lamp_radius(const VisibilityOptions& options);

/// The sizes of lamps, for people: "0.333", "0.1 to 0.333, 0.00465 rad"; "-" for rectangles only.
std::string lamp_size_text(std::span<const lightmesh::Light> lamps);

}  // namespace demo
