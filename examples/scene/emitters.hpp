// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <cstddef>
#include <span>

namespace demo {

/// Triangles of one mesh: [first, last).
struct TriangleRange {
    std::size_t first;
    std::size_t last;
};

/// Adds lamps of the power of all surfaces that shine: to a flat patch one, or four to a large one, which
/// fall off by the cosine, and one to a piece of any other shape. Rectangles become `RectLight`s, one for
/// each side that is not turned inwards. At most `most_emitter_lights`; what is weaker than those is added to
/// them. Returns the number of pieces that shine.
std::size_t add_emitter_lights(Scene& scene, std::span<const TriangleRange> meshes);

inline constexpr std::size_t most_emitter_lights = 128;

/// Lets light pass through surfaces that shine and lie around a lamp: bulbs and shades. What lies around is
/// seen from the lamp under more than half of all directions.
void open_bulbs(Scene& scene, std::span<const TriangleRange> meshes);

}  // namespace demo
