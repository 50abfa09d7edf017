// SPDX-License-Identifier: MIT
#pragma once

#include "render/files.hpp"
#include "temporary_folder.hpp"

#include <doctest/doctest.h>

#include <filesystem>
#include <string>

namespace test {

/// The file of a frame, below 10, of the film in a folder of `folder`.
inline std::string frame(const TemporaryFolder& folder, const std::string& name, int number,
                         const std::string& extension = ".png") {
    return (folder / (name + "/frame-000" + std::to_string(number) + extension)).string();
}

/// Checks that those of the first frames of a film which are there are those of `whole`. Returns how many.
inline int check_frames(const TemporaryFolder& folder, const std::string& name, const std::string& whole,
                        int count) {
    int there = 0;
    for (int number = 1; number <= count; ++number)
        if (std::filesystem::exists(frame(folder, name, number))) {
            ++there;
            CHECK(demo::read_file(frame(folder, name, number)) ==
                  demo::read_file(frame(folder, whole, number)));
        }
    return there;
}

/// So many milliseconds, below 100, as `sleep` takes them.
inline std::string in_seconds(int milliseconds) {
    return (milliseconds < 10 ? "0.00" : "0.0") + std::to_string(milliseconds);
}

}  // namespace test
