// SPDX-License-Identifier: MIT
#include "render/files.hpp"

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

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
    std::filesystem::path beside = file;
    beside += ".part";
    std::ofstream stream(beside, std::ios::binary);
    stream << content;
    stream.close();
    std::error_code error;
    if (stream)
        std::filesystem::rename(beside, file, error);
    if (!stream || error) {
        std::error_code ignored;
        std::filesystem::remove(beside, ignored);
        throw std::runtime_error("cannot write " + file.string());
    }
}

}  // namespace demo
