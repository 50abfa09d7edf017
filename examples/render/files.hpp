// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

namespace demo {

/// All of a file. Throws std::runtime_error that names it if it cannot be read.
std::string read_file(const std::filesystem::path& file);

/// Writes beside the file and renames at the end, so that it is always whole: the old one or the new one.
/// Throws std::runtime_error that names it if it cannot be written.
void write_file(const std::filesystem::path& file, const std::string& content);

}  // namespace demo
