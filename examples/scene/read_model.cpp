// SPDX-License-Identifier: MIT
#include "isolated.hpp"
#include "model.hpp"

#include <glm/common.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <exception>
#include <new>
#include <string>

namespace demo {
namespace {

void decode(ModelImage& image) {
    if (image.encoded.empty())
        return;
    try {
        const PictureSize size = picture_size(image.encoded);
        // The decoder's own and its copy.
        allow_memory(8 * static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
        image.texture = decode_texture(image.encoded);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        image.problem = error.what();
    }
    image.encoded = {};
}

}  // namespace

std::string extension_of(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

std::optional<glm::dvec3> far_middle(const glm::dvec3& low, const glm::dvec3& high) {
    constexpr double far_away = 64.0;
    const glm::dvec3 size = high - low;
    const glm::dvec3 farthest = glm::max(glm::abs(low), glm::abs(high));
    const double extent = (std::max)({size.x, size.y, size.z});
    const glm::dvec3 middle = glm::round(0.5 * (low + high));
    if (extent > 0.0 && (std::max)({farthest.x, farthest.y, farthest.z}) > far_away * extent &&
        std::isfinite(middle.x + middle.y + middle.z))
        return middle;
    return {};
}

Model read_model(const std::filesystem::path& file, const ReadOptions& options) {
    const std::string extension = extension_of(file);
    Model model = extension == ".obj"   ? read_obj(file)
                  : extension == ".ply" ? read_ply(file)
                                        : read_gltf(file, options);
    if (options.time && (extension == ".obj" || extension == ".ply"))
        model.notes.emplace_back("the file has no animations: it is the same at all times");
    for (ModelImage& image : model.images)
        decode(image);
    return model;
}

}  // namespace demo
