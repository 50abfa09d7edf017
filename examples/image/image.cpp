// SPDX-License-Identifier: MIT
#include "image.hpp"

#include "part_file.hpp"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#define STB_EASY_FONT_IMPLEMENTATION
#include <stb/stb_easy_font.h>
#define STBI_ONLY_PNG
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#include <stb/stb_image.h>
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <new>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace demo {
namespace {

namespace fs = std::filesystem;

/// Calls `write` with a temporary path and renames the result to `path`; leaves nothing behind if that fails.
void write_whole(const fs::path& path, const std::function<void(const fs::path&)>& write) {
    try {
        if (path.has_parent_path() && !fs::is_directory(path.parent_path())) {
            throw std::runtime_error("there is no folder " + path.parent_path().string());
        }
        if (fs::is_directory(path)) {
            throw std::runtime_error("it is a folder");
        }
        PartFile part(path);
        write(part.path());
        part.finish();
    } catch (const std::exception& error) {
        throw std::runtime_error("cannot write " + path.string() + ": " + error.what());
    }
}

void check_same_size(const Image& a, const Image& b) {
    if (a.width != b.width || a.height != b.height) {
        const auto size = [](const Image& image) {
            return std::to_string(image.width) + "x" + std::to_string(image.height);
        };
        throw std::invalid_argument("images of different size: " + size(a) + " and " + size(b));
    }
}

std::vector<std::uint8_t> to_bytes(const Image& image) {
    std::vector<std::uint8_t> bytes;
    bytes.reserve(3 * image.pixels.size());
    for (const glm::vec3& pixel : image.pixels) {
        for (int channel = 0; channel < 3; ++channel) {
            bytes.push_back(static_cast<std::uint8_t>(std::lround(255.0f * to_srgb(pixel[channel]))));
        }
    }
    return bytes;
}

/// The sum of `term` over all channels of both images, divided by their number.
double mean_over_channels(const Image& a, const Image& b, double (*term)(double)) {
    check_same_size(a, b);
    double sum = 0.0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            sum +=
                term(static_cast<double>(a.pixels[i][channel]) - static_cast<double>(b.pixels[i][channel]));
        }
    }
    return sum / static_cast<double>(3 * a.pixels.size());
}

constexpr std::array<const char*, 3> channel_names{"R", "G", "B"};

Imf::FrameBuffer frame_buffer(glm::vec3* pixels, int width, int left, int top) {
    Imf::FrameBuffer buffer;
    constexpr std::size_t pixel_size = sizeof(glm::vec3);
    const auto row_size = pixel_size * static_cast<std::size_t>(width);
    // OpenEXR addresses pixels by their place in the data window, which need not start at (0, 0).
    const auto to_corner =
        static_cast<std::ptrdiff_t>(pixel_size) * left + static_cast<std::ptrdiff_t>(row_size) * top;
    for (std::size_t channel = 0; channel < channel_names.size(); ++channel) {
        char* base = reinterpret_cast<char*>(pixels) + channel * sizeof(float) - to_corner;
        buffer.insert(channel_names[channel], Imf::Slice{Imf::FLOAT, base, pixel_size, row_size});
    }
    return buffer;
}

/// Fills the pixels of [left, right) x [top, bottom) that lie in the image.
void fill(Image& image, int left, int top, int right, int bottom, glm::vec3 colour) {
    for (int y = (std::max)(top, 0); y < (std::min)(bottom, image.height); ++y) {
        for (int x = (std::max)(left, 0); x < (std::min)(right, image.width); ++x) {
            image.at(x, y) = colour;
        }
    }
}

void paste(Image& sheet, const Image& picture, int left, int top) {
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            sheet.at(left + x, top + y) = picture.at(x, y);
        }
    }
}

std::string png_bytes(const Image& image) {
    const std::vector<std::uint8_t> channels = to_bytes(image);
    std::string bytes;
    const auto append = [](void* all, void* data, int size) {
        static_cast<std::string*>(all)->append(static_cast<const char*>(data),
                                               static_cast<std::size_t>(size));
    };
    if (stbi_write_png_to_func(append, &bytes, image.width, image.height, 3, channels.data(),
                               3 * image.width) == 0)
        throw std::bad_alloc();
    return bytes;
}

/// A file of OpenEXR in memory.
class ExrBytes : public Imf::OStream {
public:
    ExrBytes() : Imf::OStream("a picture in memory") {}

    void write(const char* data, int size) override {
        const auto count = static_cast<std::size_t>(size);
        bytes_.resize((std::max)(bytes_.size(), place_ + count));
        std::copy_n(data, count, bytes_.begin() + static_cast<std::ptrdiff_t>(place_));
        place_ += count;
    }
    std::uint64_t tellp() override { return place_; }
    void seekp(std::uint64_t place) override { place_ = place; }

    std::string take() { return std::move(bytes_); }

private:
    std::string bytes_;
    std::size_t place_ = 0;
};

std::string exr_bytes(const Image& image) {
    Imf::Header header{image.width, image.height};
    for (const char* name : channel_names) {
        header.channels().insert(name, Imf::Channel{Imf::FLOAT});
    }
    std::vector<glm::vec3> copy = image.pixels;  // OpenEXR's slices are not const
    ExrBytes stream;
    {
        Imf::OutputFile file{stream, header};
        file.setFrameBuffer(frame_buffer(copy.data(), image.width, 0, 0));
        file.writePixels(image.height);
    }
    return stream.take();
}

void write_bytes(const std::string& bytes, const fs::path& path) {
    std::ofstream file{path, std::ios::binary};
    if (!file) {
        throw std::system_error(errno, std::generic_category());
    }
    file << bytes;
    file.close();
    if (!file) {
        throw std::runtime_error("the device may be full");
    }
}

std::string printable(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (c == '\n' || (c >= ' ' && c <= '~')) {
            result.push_back(c);
        }
    }
    return result;
}

}  // namespace

Image::Image(int image_width, int image_height, glm::vec3 colour) : width(image_width), height(image_height) {
    if (width < 1 || height < 1) {
        throw std::invalid_argument("an image of " + std::to_string(width) + " x " + std::to_string(height) +
                                    " pixels");
    }
    pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), colour);
}

float to_srgb(float linear) {
    const float value = linear > 0.0f ? (std::min)(linear, 1.0f) : 0.0f;
    return value <= 0.0031308f ? 12.92f * value : 1.055f * std::pow(value, 1.0f / 2.4f) - 0.055f;
}

float from_srgb(float encoded) {
    const float value = encoded > 0.0f ? (std::min)(encoded, 1.0f) : 0.0f;
    return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

Image toned(Image image, Tone tone) {
    if (tone == Tone::linear)
        return image;
    for (glm::vec3& pixel : image.pixels)
        for (int channel = 0; channel < 3; ++channel) {
            // Beyond that the curve is flat; NaN is black, as in `to_srgb`.
            const float x = 0.6f * (pixel[channel] > 0.0f ? (std::min)(pixel[channel], 1e4f) : 0.0f);
            pixel[channel] = (std::min)(x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f), 1.0f);
        }
    return image;
}

void write_png(const Image& image, const fs::path& path) {
    write_whole(path, [&](const fs::path& part) { write_bytes(png_bytes(image), part); });
}

Image read_png(const fs::path& path) {
    int width = 0;
    int height = 0;
    int channels = 0;
    const std::unique_ptr<stbi_uc, void (*)(void*)> bytes{
        stbi_load(path.c_str(), &width, &height, &channels, 3), stbi_image_free};
    if (!bytes) {
        throw std::runtime_error("cannot read " + path.string() + ": " + stbi_failure_reason());
    }
    Image image{width, height};
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            const float encoded = static_cast<float>(bytes.get()[3 * i + channel]) / 255.0f;
            image.pixels[i][static_cast<int>(channel)] = from_srgb(encoded);
        }
    }
    return image;
}

void write_exr(const Image& image, const fs::path& path) {
    write_whole(path, [&](const fs::path& part) { write_bytes(exr_bytes(image), part); });
}

Image read_exr(const fs::path& path) {
    try {
        Imf::InputFile file{path.c_str()};
        const Imath::Box2i window = file.header().dataWindow();
        Image image{window.max.x - window.min.x + 1, window.max.y - window.min.y + 1};
        for (const char* name : channel_names) {
            if (!file.header().channels().findChannel(name)) {
                throw std::runtime_error(std::string{"it has no channel "} + name);
            }
        }
        file.setFrameBuffer(frame_buffer(image.pixels.data(), image.width, window.min.x, window.min.y));
        file.readPixels(window.min.y, window.max.y);
        return image;
    } catch (const std::exception& error) {
        throw std::runtime_error("cannot read " + path.string() + ": " + error.what());
    }
}

void write_image(const Image& image, const fs::path& path) {
    if (path.extension() == ".png") {
        write_png(image, path);
    } else if (path.extension() == ".exr") {
        write_exr(image, path);
    } else {
        throw std::runtime_error("cannot write " + path.string() + ": its name must end in .png or .exr");
    }
}

std::string encoded(const Image& image, const std::string& extension) {
    return extension == ".png" ? png_bytes(image) : exr_bytes(image);
}

double mean_absolute_difference(const Image& a, const Image& b) {
    return mean_over_channels(a, b, [](double difference) { return std::abs(difference); });
}

double rms_difference(const Image& a, const Image& b) {
    return std::sqrt(mean_over_channels(a, b, [](double difference) { return difference * difference; }));
}

double share_beyond_one_step(const Image& a, const Image& b) {
    check_same_size(a, b);
    std::size_t others = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        for (int channel = 0; channel < 3; ++channel) {
            const float difference = to_srgb(a.pixels[i][channel]) - to_srgb(b.pixels[i][channel]);
            if (std::abs(std::round(255.0f * difference)) > 1.0f) {
                ++others;
                break;
            }
        }
    return static_cast<double>(others) / static_cast<double>(a.pixels.size());
}

Image difference_picture(const Image& a, const Image& b, float amplification) {
    check_same_size(a, b);
    Image result = a;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            const float difference = std::abs(to_srgb(a.pixels[i][channel]) - to_srgb(b.pixels[i][channel]));
            result.pixels[i][channel] = from_srgb(1.0f - amplification * difference);
        }
    }
    return result;
}

void draw_text(Image& image, int x, int y, int scale, const std::string& text, glm::vec3 colour) {
    struct Corner {  // as stb_easy_font lays it out
        float x, y, z;
        std::uint8_t colour[4];
    };
    std::string line = printable(text);
    std::vector<Corner> corners(70 * line.size() +
                                4);  // a character has at most some 17 strokes of 4 corners
    const int strokes = stb_easy_font_print(0, 0, line.data(), nullptr, corners.data(),
                                            static_cast<int>(corners.size() * sizeof(Corner)));
    for (int i = 0; i < strokes; ++i) {
        const Corner& upper_left = corners[4 * static_cast<std::size_t>(i)];
        const Corner& lower_right = corners[4 * static_cast<std::size_t>(i) + 2];
        const auto pixel = [scale](float value) {
            return scale * static_cast<int>(value);
        };
        fill(image, x + pixel(upper_left.x), y + pixel(upper_left.y), x + pixel(lower_right.x),
             y + pixel(lower_right.y), colour);
    }
}

Image contact_sheet(const std::vector<CaptionedImage>& pictures, int columns) {
    if (pictures.empty() || columns < 1) {
        throw std::invalid_argument("a sheet of " + std::to_string(pictures.size()) + " pictures in " +
                                    std::to_string(columns) + " columns");
    }
    int cell_width = 0;
    int cell_height = 0;
    std::ptrdiff_t lines = 1;
    for (const CaptionedImage& picture : pictures) {
        cell_width = (std::max)(cell_width, picture.image.width);
        cell_height = (std::max)(cell_height, picture.image.height);
        lines = (std::max)(lines, 1 + std::count(picture.caption.begin(), picture.caption.end(), '\n'));
    }
    const int scale = std::clamp(cell_width / 320, 1, 4);
    const int margin = 6 * scale;
    const int caption_height = scale * 12 * static_cast<int>(lines) + margin;
    const int count = static_cast<int>(pictures.size());
    const int used_columns = (std::min)(columns, count);
    const int rows = (count + columns - 1) / columns;
    Image sheet{margin + used_columns * (cell_width + margin),
                margin + rows * (cell_height + caption_height + margin), glm::vec3{0.015f}};
    for (int i = 0; i < count; ++i) {
        const CaptionedImage& picture = pictures[static_cast<std::size_t>(i)];
        const int left = margin + i % columns * (cell_width + margin);
        const int top = margin + i / columns * (cell_height + caption_height + margin);
        paste(sheet, picture.image, left, top);
        draw_text(sheet, left, top + cell_height + margin, scale, picture.caption, glm::vec3{0.75f});
    }
    return sheet;
}

Image side_by_side(const std::vector<CaptionedImage>& pictures) {
    return contact_sheet(pictures, static_cast<int>(pictures.size()));
}

}  // namespace demo
