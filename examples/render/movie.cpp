// SPDX-License-Identifier: MIT
#include "render/movie.hpp"

#include "image/part_file.hpp"
#include "render/text_table.hpp"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

namespace demo {

namespace {

constexpr const char* program = "ffmpeg";

/// Runs a program of PATH to its end; returns its exit status, or -1 if a signal ended it.
int run_program(std::vector<std::string> words) {
    std::vector<char*> arguments;
    for (std::string& word : words)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_t child = 0;
    if (const int error = posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), environ);
        error != 0)
        throw std::runtime_error("cannot run " + words[0] + ": " +
                                 std::error_code(error, std::generic_category()).message());
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

void require_ffmpeg() {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path != nullptr ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');)
        if (access((std::filesystem::path(folder) / program).c_str(), X_OK) == 0)
            return;
    throw std::runtime_error("MP4 films are made by ffmpeg, which is not installed (Debian: apt-get install "
                             "ffmpeg); a folder as --output takes numbered frames");
}

void write_movie(const std::string& pattern, int frames, double frames_per_second,
                 const std::filesystem::path& file) {
    PartFile part(file);
    const int status = run_program(
        {program, "-nostdin", "-loglevel", "error", "-y", "-framerate", exactly(frames_per_second),
         "-start_number", "1", "-i", pattern, "-frames:v", std::to_string(frames),
         // H.264 of this pixel format, which all players know, has even sides only.
         "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf", "16", "-pix_fmt", "yuv420p", "-f",
         "mp4", part.path().string()});
    if (status != 0)
        throw std::runtime_error(
            "ffmpeg could not make " + file.string() +
            (status < 0 ? ": it was stopped" : " and ended with status " + std::to_string(status)) +
            "; the frames are there");
    part.finish();
}

}  // namespace demo
