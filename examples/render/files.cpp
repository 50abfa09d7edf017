// SPDX-License-Identifier: MIT
#include "render/files.hpp"

#include "image/part_file.hpp"

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace demo {

std::string read_file(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream content;
    content << stream.rdbuf();
    if (!stream)
        throw std::runtime_error("cannot read " + file.string());
    return content.str();
}

void write_file(const std::filesystem::path& file, const std::string& content) {
    PartFile part(file);
    std::ofstream stream(part.path(), std::ios::binary);
    stream << content;
    stream.close();
    if (!stream)
        throw std::runtime_error("cannot write " + file.string());
    try {
        part.finish();
    } catch (const std::filesystem::filesystem_error&) {
        throw std::runtime_error("cannot write " + file.string());
    }
}

}  // namespace demo
