// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <ios>
#include <stdexcept>

namespace demo {

/// All bytes of a file, in a string or a vector. Throws std::runtime_error that names the file if it cannot
/// be read.
template <class Container>
Container read_whole(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary | std::ios::ate);
    std::error_code ignored;
    if (!stream || std::filesystem::is_directory(file, ignored))
        throw std::runtime_error("cannot open '" + file.filename().string() + "'");
    const std::streamoff size = stream.tellg();
    Container bytes;
    bytes.resize(static_cast<std::size_t>((std::max)(size, std::streamoff{0})));
    stream.seekg(0);
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!stream)
        throw std::runtime_error("cannot read '" + file.filename().string() + "'");
    return bytes;
}

}  // namespace demo
