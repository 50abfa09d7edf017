// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>

namespace test {

/// A fresh folder that goes with all that is in it.
class TemporaryFolder {
public:
    TemporaryFolder() {
        static int made = 0;
        path_ = std::filesystem::temp_directory_path() /
                ("lightmesh-test-" + std::to_string(::getpid()) + "-" + std::to_string(made++));
        std::filesystem::create_directories(path_);
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::permissions(path_, std::filesystem::perms::owner_all, ignored);
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

    /// Writes a file and returns its path.
    std::filesystem::path write(const std::string& name, const std::string& content) const {
        std::ofstream{path_ / name, std::ios::binary} << content;
        return path_ / name;
    }

    std::size_t file_count() const {
        std::size_t count = 0;
        for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator{path_}) {
            ++count;
        }
        return count;
    }

    /// Whether a file, here or in a folder below, was left half written.
    bool has_part_files() const {
        for (const auto& entry : std::filesystem::recursive_directory_iterator{path_})
            if (entry.path().filename().string().find(".part") != std::string::npos)
                return true;
        return false;
    }

private:
    std::filesystem::path path_;
};

}  // namespace test
