// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace demo {

/// The texels beyond the edges of a texture.
enum class Wrap : std::uint32_t { repeat, mirror, clamp };

/// A picture to look up, in 8 bits per channel: sRGB and alpha; row-major, row 0 on top.
struct Texture {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgba;
    bool has_alpha = false;       ///< whether any texel's alpha is below 1
    bool is_linear = false;       ///< whether the channels hold linear values, not sRGB
    bool blends_encoded = false;  ///< whether texels are blended as they are stored, and made linear after

    /// Bilinear, as linear values; (0, 0) is the upper left corner, (1, 1) the lower right one. Coordinates
    /// that are not finite count as 0.
    glm::vec4 sample(glm::vec2 place, Wrap wrap_u, Wrap wrap_v) const;

private:
    glm::vec4 texel(int column, int row) const;
};

struct PictureSize {
    int width = 0;
    int height = 0;
};

/// The size of a picture before it is decoded. Throws as `decode_texture`.
PictureSize picture_size(std::span<const std::uint8_t> encoded);

/// Decodes PNG, JPEG, BMP, TGA or what else the decoder knows. Throws std::runtime_error that says what is
/// wrong; pictures of more than 2^26 pixels are refused before they take memory.
Texture decode_texture(std::span<const std::uint8_t> encoded);

/// The format of a picture by its first bytes, such as "PNG" or "KTX2"; empty if it is not known.
std::string picture_format(std::span<const std::uint8_t> encoded);

}  // namespace demo
