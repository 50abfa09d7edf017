// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

namespace demo {

/// Throws std::runtime_error that says what to install if the program ffmpeg is not in PATH.
void require_ffmpeg();

/// Makes an MP4 (H.264) of `frames` pictures, numbered from 1 by printf's %d in `pattern`, by the program
/// ffmpeg. The file is whole, or stays as it was. Throws std::runtime_error that names it.
void write_movie(const std::string& pattern, int frames, double frames_per_second,
                 const std::filesystem::path& file);

}  // namespace demo
