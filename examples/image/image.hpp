// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace demo {

/// A picture of linear RGB values; row-major, row 0 on top.
struct Image {
    int width = 0;
    int height = 0;
    std::vector<glm::vec3> pixels;

    Image() = default;
    /// Throws std::invalid_argument for a size below 1 x 1.
    Image(int image_width, int image_height, glm::vec3 colour = glm::vec3{0.0f});

    glm::vec3& at(int x, int y) { return pixels[index(x, y)]; }
    const glm::vec3& at(int x, int y) const { return pixels[index(x, y)]; }

private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
};

/// The sRGB curve and its inverse, for one channel; values outside [0, 1] are clamped first, NaN counts as 0.
float to_srgb(float linear);
float from_srgb(float encoded);

// Files. Writers write beside the target and rename at the end: a file is either whole or not there (an older
// one of the same name stays as it was). All throw std::runtime_error that names the path and what went
// wrong.

/// 8 bits per channel, sRGB.
void write_png(const Image& image, const std::filesystem::path& path);
Image read_png(const std::filesystem::path& path);

/// 32-bit float RGB, linear, nothing lost.
void write_exr(const Image& image, const std::filesystem::path& path);
Image read_exr(const std::filesystem::path& path);

/// By the file's extension, .png or .exr; any other is an error.
void write_image(const Image& image, const std::filesystem::path& path);
/// The kind of data that `write_image` writes into a file of that extension.
std::string encoded(const Image& image, const std::string& extension);

/// The curve that makes a picture's values ready for a screen.
enum class Tone {
    linear,  ///< as they are; what is above 1 is white
    filmic   ///< keeps mid grey, turns 1 into 0.67, and keeps highlights apart up to 13
};

/// The picture by a curve, channel by channel. Filmic: Narkowicz, "ACES Filmic Tone Mapping Curve", 2015.
Image toned(Image image, Tone tone);

/// Mean over all channels of |a - b|, linear values. The images must have one size (std::invalid_argument).
double mean_absolute_difference(const Image& a, const Image& b);
/// Root of the mean over all channels of (a - b)^2, linear values.
double rms_difference(const Image& a, const Image& b);

/// The share of pixels that differ by more than one step of 8 bits of the sRGB values in some channel. The
/// images must have one size.
double share_beyond_one_step(const Image& a, const Image& b);

/// The difference as one sees it, negated: white where the pictures are equal, darker by `amplification`
/// times the absolute difference of the sRGB values in each channel (figure 4 of the paper).
Image difference_picture(const Image& a, const Image& b, float amplification);

struct CaptionedImage {
    Image image;
    std::string caption;  ///< printable ASCII; may have several lines
};

/// The pictures in rows of `columns`, each with its caption below, on a dark ground. Throws
/// std::invalid_argument for no pictures or no columns.
Image contact_sheet(const std::vector<CaptionedImage>& pictures, int columns);

/// The pictures beside each other in one row.
Image side_by_side(const std::vector<CaptionedImage>& pictures);

/// Writes text with its upper left corner at (x, y); capitals are about 7 * scale pixels high. What lies
/// outside of the image is cut off. Anything but printable ASCII and line breaks is left out.
void draw_text(Image& image, int x, int y, int scale, const std::string& text, glm::vec3 colour);

}  // namespace demo
