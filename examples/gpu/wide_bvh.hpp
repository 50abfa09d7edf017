// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace demo {

/// A BVH of up to 8 children a node for shaders, with boxes in bytes: Ylitie, Karras and Laine, "Efficient
/// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017. Shaders see it by bvh.glsl.
///
/// A node is 20 words:
///
///     0-2    the low corner of its box, floats
///     3      the exponents of the steps along x, y and z, 127 more than they are; above: which of the slots
///            hold nodes
///     4, 5   the first child node, and the first triangle of the children that are leaves
///     6, 7   a byte a slot. 0: empty. Node: 1 in the upper 3 bits, 24 + slot below. Leaf: as many bits above
///     as
///            it has triangles, and the number of the first one below
///     8-13   bytes of all slots: the low sides of their boxes, in steps from the corner, along x, y, z
///     14-19  the high sides
///
/// A child lies in the slot whose bits say on which side of each axis it is, as far as there is room: rays
/// visit children in an order by their signs alone.
struct WideBvh {
    static constexpr std::size_t words_of_node = 20;
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
inline constexpr std::uint32_t most_bvh_depth = 48;

}  // namespace demo
