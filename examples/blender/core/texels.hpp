// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace demo {

/// The part that the texels of an image show of some triangles; rows from the bottom up.
struct CoveredTexels {
    int width;
    int height;
    std::span<std::int32_t> triangles;  ///< one a texel; -1: none
    std::span<float> weights;           ///< of its second and third corner, 2 a texel
    std::span<std::int32_t> others;     ///< another triangle that has the texel's middle too; -1: none
};

/// Finds the triangle of each texel and the place on it, by 6 texture coordinates a triangle: (0, 0) is the
/// image's lower left corner, (1, 1) its upper right one. A texel shows the first triangle that has its
/// middle, there; if none has, but some touch the texel, the place on them that is nearest to its middle, and
/// inside by a quarter of a texel. Corners are rounded to 1/256 of a texel, and middles on an edge that two
/// triangles share are one's. Triangles without an area, with coordinates that are not finite or farther from
/// 0 than 2^20 texels, and what lies outside the image show nowhere.
void cover_texels(std::span<const float> uvs, const CoveredTexels& texels);

/// Gives texels that are not filled, up to `margin` steps away from those that are, the mean of their eight
/// neighbours that are nearer by a step, those at the sides counting twice; then they are filled, too.
/// `values` has `channels` of them a texel, `filled` 1 or 0.
void fill_margin(int width, int height, int channels, std::span<float> values, std::span<std::uint8_t> filled,
                 int margin);

}  // namespace demo
