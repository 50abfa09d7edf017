// SPDX-License-Identifier: MIT
#include "texture.hpp"

#include "image.hpp"

#include <cstdlib>

// Damaged pictures make the decoder read tables that they do not have: these are zeros, not what lay there.
#define STBI_MALLOC(size) std::calloc(1, size)
#define STBI_REALLOC(block, size) std::realloc(block, size)
#define STBI_FREE(block) std::free(block)
#define STBI_NO_STDIO
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string_view>

namespace demo {
namespace {

constexpr std::int64_t most_pixels = std::int64_t{1} << 26;

const std::array<float, 256>& linear_values() {
    static const std::array<float, 256> values = [] {
        std::array<float, 256> made{};
        for (std::size_t i = 0; i < made.size(); ++i)
            made[i] = from_srgb(static_cast<float>(i) / 255.0f);
        return made;
    }();
    return values;
}

/// The texel that lies at `index`, which may be beyond the edges.
int wrapped(int index, int size, Wrap wrap) {
    if (wrap == Wrap::clamp)
        return std::clamp(index, 0, size - 1);
    const int period = wrap == Wrap::mirror ? 2 * size : size;
    const int rest = (index % period + period) % period;
    return rest < size ? rest : period - 1 - rest;
}

/// A coordinate in texels, small enough to be an integer: repeats and mirror images are 2 apart.
float in_texels(float coordinate, int size, Wrap wrap) {
    if (!std::isfinite(coordinate))
        return 0.0f;
    const float near = wrap == Wrap::clamp ? std::clamp(coordinate, -1.0f, 2.0f)
                                           : coordinate - 2.0f * std::floor(0.5f * coordinate);
    return near * static_cast<float>(size) - 0.5f;
}

}  // namespace

glm::vec4 Texture::texel(int column, int row) const {
    const std::size_t first = 4 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                                   static_cast<std::size_t>(column));
    const std::array<float, 256>& linear = linear_values();
    const float alpha = static_cast<float>(rgba[first + 3]) / 255.0f;
    if (is_linear || blends_encoded)
        return {static_cast<float>(rgba[first]) / 255.0f, static_cast<float>(rgba[first + 1]) / 255.0f,
                static_cast<float>(rgba[first + 2]) / 255.0f, alpha};
    return {linear[rgba[first]], linear[rgba[first + 1]], linear[rgba[first + 2]], alpha};
}

glm::vec4 Texture::sample(glm::vec2 place, Wrap wrap_u, Wrap wrap_v) const {
    const float x = in_texels(place.x, width, wrap_u);
    const float y = in_texels(place.y, height, wrap_v);
    const int left = static_cast<int>(std::floor(x));
    const int top = static_cast<int>(std::floor(y));
    const float share_x = x - static_cast<float>(left);
    const float share_y = y - static_cast<float>(top);
    const int columns[2] = {wrapped(left, width, wrap_u), wrapped(left + 1, width, wrap_u)};
    const int rows[2] = {wrapped(top, height, wrap_v), wrapped(top + 1, height, wrap_v)};
    const glm::vec4 above =
        texel(columns[0], rows[0]) * (1.0f - share_x) + texel(columns[1], rows[0]) * share_x;
    const glm::vec4 below =
        texel(columns[0], rows[1]) * (1.0f - share_x) + texel(columns[1], rows[1]) * share_x;
    glm::vec4 blend = above * (1.0f - share_y) + below * share_y;
    if (blends_encoded && !is_linear)
        for (int channel = 0; channel < 3; ++channel)
            blend[channel] = from_srgb(blend[channel]);
    return blend;
}

PictureSize picture_size(std::span<const std::uint8_t> encoded) {
    if (encoded.size() > static_cast<std::size_t>(INT_MAX))
        throw std::runtime_error("has more than 2 GB");
    PictureSize found;
    int channels = 0;
    if (stbi_info_from_memory(encoded.data(), static_cast<int>(encoded.size()), &found.width, &found.height,
                              &channels) == 0) {
        const std::string format = picture_format(encoded);
        throw std::runtime_error(format.empty() ? "is in no format that can be read"
                                                : "is " + format + ", which cannot be read");
    }
    if (std::int64_t{found.width} * found.height > most_pixels)
        throw std::runtime_error("has " + std::to_string(found.width) + " x " + std::to_string(found.height) +
                                 " pixels, more than 2^26");
    return found;
}

Texture decode_texture(std::span<const std::uint8_t> encoded) {
    static_cast<void>(picture_size(encoded));  // fits, or throws
    const auto size = static_cast<int>(encoded.size());
    Texture texture;
    int channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> bytes{
        stbi_load_from_memory(encoded.data(), size, &texture.width, &texture.height, &channels, 4),
        stbi_image_free};
    if (!bytes)
        throw std::runtime_error(std::string("is damaged: ") + stbi_failure_reason());
    const std::size_t count =
        4 * static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height);
    texture.rgba.assign(bytes.get(), bytes.get() + count);
    for (std::size_t i = 3; i < count && !texture.has_alpha; i += 4)
        texture.has_alpha = texture.rgba[i] < 255;
    return texture;
}

std::string picture_format(std::span<const std::uint8_t> encoded) {
    const std::string_view start(reinterpret_cast<const char*>(encoded.data()),
                                 (std::min)(encoded.size(), std::size_t{16}));
    if (start.starts_with("\x89PNG"))
        return "PNG";
    if (start.starts_with("\xff\xd8\xff"))
        return "JPEG";
    if (start.starts_with("\xabKTX 20\xbb"))
        return "KTX2";
    if (start.starts_with("\xabKTX 11\xbb"))
        return "KTX";
    if (start.starts_with("RIFF") && start.substr(8, 4) == "WEBP")
        return "WebP";
    if (start.starts_with("DDS "))
        return "DDS";
    if (start.size() >= 12 && start.substr(4, 8) == "ftypavif")
        return "AVIF";
    if (start.starts_with("\x76\x2f\x31\x01"))
        return "OpenEXR";
    if (start.starts_with("II*") || start.starts_with("MM"))
        return "TIFF";
    return {};
}

}  // namespace demo
