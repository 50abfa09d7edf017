// SPDX-License-Identifier: MIT

// libFuzzer's target over the readers of files and pictures. The first byte chooses the format, and
// whether animations are sampled. Readers may throw; all else is a fault. Build with clang,
// -DLIGHTMESH_FUZZ=ON and -DLIGHTMESH_SANITIZE=address, then
//     TMPDIR=/dev/shm tests/lightmesh-fuzz-import -max_total_time=3600 -rss_limit_mb=4096 corpus tests/field
// Without a child process, which would be most of the time: Assimp may crash here on what `read_isolated`
// answers with a sentence (-fork=1 -ignore_crashes=1 goes on after it).

#include "image/texture.hpp"
#include "scene/model.hpp"
#include "scene/obj_text.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>

namespace {

/// A folder of this process for the files.
const std::filesystem::path& folder() {
    static const std::filesystem::path the_folder = [] {
        auto made = std::filesystem::temp_directory_path() / ("lightmesh-fuzz-" + std::to_string(getpid()));
        std::filesystem::create_directories(made);
        return made;
    }();
    return the_folder;
}

void write(const std::filesystem::path& file, const std::uint8_t* data, std::size_t size) {
    const int handle = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (handle < 0 || ::write(handle, data, size) != static_cast<ssize_t>(size))
        throw std::runtime_error("cannot write " + file.string());
    close(handle);
}

#ifndef LIGHTMESH_OBJ_OF
/// One of so many OBJ files goes to Assimp, which clears 16 MB for each; the others to our own checks only.
#define LIGHTMESH_OBJ_OF 1
#endif

bool is_for_assimp(const std::uint8_t* data, std::size_t size) {
    std::uint64_t hash = 14695981039346656037ULL;
    for (std::size_t i = 0; i < size; ++i)
        hash = (hash ^ data[i]) * 1099511628211ULL;
    return (hash >> 32) % LIGHTMESH_OBJ_OF == 0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0)
        return 0;
    constexpr const char* names[] = {"a.gltf", "a.glb", "a.obj", "a.ply"};
    constexpr std::int64_t most_pixels = 1 << 20;
    const std::size_t format = data[0] % 5;
    try {
        if (format == 4) {
            const demo::PictureSize picture = demo::picture_size(std::span(data + 1, size - 1));
            if (std::int64_t{picture.width} * picture.height <= most_pixels)
                demo::decode_texture(std::span(data + 1, size - 1));
            return 0;
        }
        if (format == 2 && !is_for_assimp(data, size)) {
            demo::prepare_obj(std::string(reinterpret_cast<const char*>(data + 1), size - 1));
            return 0;
        }
        const std::filesystem::path file = folder() / names[format];
        write(file, data + 1, size - 1);
        demo::ReadOptions options;
        if (data[0] >= 128)
            options.time = 0.5;
        demo::read_model(file, options);
    } catch (const std::exception&) {
        return 0;
    }
    return 0;
}
