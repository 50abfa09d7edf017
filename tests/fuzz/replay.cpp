// SPDX-License-Identifier: MIT

// Runs the fuzzer's target over files and over mutations of them, where the compiler has no libFuzzer: each
// file as it is, cut off at each of some places, and with single bytes changed, always the same.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

std::uint8_t format_of(const std::filesystem::path& file) {
    const std::string extension = file.extension().string();
    if (extension == ".glb")
        return 1;
    if (extension == ".obj")
        return 2;
    if (extension == ".ply")
        return 3;
    return extension == ".jpg" || extension == ".png" ? 4 : 0;
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 3) {
        std::cerr << "replay MUTATIONS FOLDER...\n";
        return 2;
    }
    const int mutations = std::atoi(arguments[1]);
    std::mt19937 random(1);
    std::size_t runs = 0;
    for (int i = 2; i < count; ++i) {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(arguments[i])) {
            if (!entry.is_regular_file())
                continue;
            std::ifstream stream(entry.path(), std::ios::binary);
            std::vector<std::uint8_t> whole{format_of(entry.path())};
            whole.insert(whole.end(), std::istreambuf_iterator<char>(stream),
                         std::istreambuf_iterator<char>());
            for (int m = 0; m <= mutations; ++m, ++runs) {
                std::vector<std::uint8_t> changed = whole;
                for (int k = 0; k < m % 4 && changed.size() > 1; ++k)
                    changed[1 + random() % (changed.size() - 1)] = static_cast<std::uint8_t>(random());
                if (m % 3 == 2)
                    changed.resize(1 + random() % changed.size());
                LLVMFuzzerTestOneInput(changed.data(), changed.size());
            }
        }
    }
    std::cout << runs << " runs\n";
    return 0;
}
