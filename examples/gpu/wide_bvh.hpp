// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace demo {

/// A BVH of up to 4 children a node for shaders, which see it by bvh.glsl.
///
/// A node is 28 words, four of each kind, one a child:
///
///     0-3, 4-7      the low and the high sides of their boxes along x, floats
///     8-15, 16-23   the same along y and along z
///     24-27         what they are. A node: where it begins, in fours of words. A leaf: `leaf`, its first
///                   triangle from bit 2 on, how many it has below; with none there is no child
struct WideBvh {
    static constexpr std::size_t words_of_node = 28;
    static constexpr std::size_t children_of_node = 4;
    static constexpr std::uint32_t leaf = std::uint32_t{1} << 31;
    /// Of three corners, with a fourth word each: the triangle's number in the scene, whether light may pass
    /// it (1), nothing.
    static constexpr std::size_t words_of_triangle = 12;

    std::vector<std::uint32_t> nodes;
    std::vector<std::uint32_t> triangles;
    std::uint32_t depth = 0;  ///< nodes from the root to the deepest one
};

/// Of all of a scene's triangles, by Embree's builder. Throws std::runtime_error with Embree's own words, and
/// for a scene whose tree is deeper than shaders' stacks: `most_bvh_depth` nodes.
WideBvh build_wide_bvh(const Scene& scene);

/// After the triangles of that scene have moved: fits the boxes to them. The tree keeps its shape.
void fit(WideBvh& bvh, const Scene& scene);

/// As bvh.glsl has it.
inline constexpr std::uint32_t most_bvh_depth = 32;

}  // namespace demo
