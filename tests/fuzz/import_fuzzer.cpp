// SPDX-License-Identifier: MIT

// libFuzzer's target over the readers of files. The first byte chooses the format. Readers may throw; all
// else is a fault. Build with clang and -DLIGHTMESH_FUZZ=ON, then
//     tests/lightmesh-fuzz-import -max_total_time=3600 -rss_limit_mb=4096 corpus tests/field/hostile

#include "scene/model.hpp"

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0)
        return 0;
    constexpr const char* names[] = {"a.gltf", "a.glb", "a.obj", "a.ply"};
    const auto folder =
        std::filesystem::temp_directory_path() / ("lightmesh-fuzz-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder);
    const auto file = folder / names[data[0] % 4];
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(data + 1), static_cast<std::streamsize>(size - 1));
    try {
        if (data[0] % 4 < 2)
            demo::read_gltf(file);
        else
            demo::read_by_assimp(file);
    } catch (const std::exception&) {
        return 0;
    }
    return 0;
}
