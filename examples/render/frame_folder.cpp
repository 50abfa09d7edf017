// SPDX-License-Identifier: MIT
#include "render/frame_folder.hpp"

#include "image/image.hpp"
#include "render/files.hpp"
#include "render/run.hpp"

#include <signal.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <exception>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace demo {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view frame_start = "frame-";
constexpr const char* traits_name = "film.txt";

std::map<std::string, std::string> traits_in(const std::string& text) {
    std::map<std::string, std::string> traits;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (const std::size_t colon = line.find(": "); colon != std::string::npos)
            traits[line.substr(0, colon)] = line.substr(colon + 2);
    return traits;
}

bool is_frame(const fs::path& file) {
    const std::string name = file.stem().string();
    return (file.extension() == ".png" || file.extension() == ".exr") && name.starts_with(frame_start) &&
           name.size() > frame_start.size() &&
           std::ranges::all_of(name.substr(frame_start.size()),
                               [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// True if a file is a frame that a process has begun to write, which is there no more: see `PartFile`.
bool is_left_over(const fs::path& file) {
    constexpr std::string_view mark = ".part";
    const std::string end = file.extension().string();
    if (!file.filename().string().starts_with(frame_start) || !end.starts_with(mark))
        return false;
    const std::string digits = end.substr(mark.size());
    pid_t process = 0;
    const auto [last, error] = std::from_chars(digits.data(), digits.data() + digits.size(), process);
    return error == std::errc() && last == digits.data() + digits.size() && process > 0 &&
           ::kill(process, 0) != 0 && errno == ESRCH;
}

}  // namespace

std::string text_of(const FilmTraits& traits) {
    std::string text;
    for (const auto& [name, value] : traits)
        text += name + ": " + value + '\n';
    return text;
}

std::string differences(const std::string& there, const FilmTraits& here) {
    const std::map<std::string, std::string> known = traits_in(there);
    std::string text;
    for (const auto& [name, value] : here) {
        const auto found = known.find(name);
        const std::string other = found == known.end() ? "not known" : found->second;
        if (other != value)
            text += (text.empty() ? "" : ", ") + name + " is " + other + " there and " + value + " here";
    }
    return text;
}

FrameFolder::FrameFolder(fs::path folder, std::string extension, int width, int height)
    : folder_(std::move(folder)), extension_(std::move(extension)), width_(width), height_(height) {
    prepare_folder(folder_);
}

void FrameFolder::claim(const FilmTraits& traits, bool overwrite) const {
    const fs::path file = folder_ / traits_name;
    const std::vector<fs::path> frames = files_there(is_frame);
    if (overwrite) {
        for (const fs::path& frame : frames)
            fs::remove(frame);
    } else if (!frames.empty()) {
        const std::string there = fs::exists(file) ? read_file(file) : "";
        if (const std::string differing = differences(there, traits); !differing.empty())
            throw std::runtime_error(folder_.string() + " holds frames of another film: " +
                                     (there.empty() ? "there is no " + std::string(traits_name) : differing) +
                                     "; --overwrite removes them");
    }
    for (const fs::path& left_over : files_there(is_left_over))
        fs::remove(left_over);
    write_file(file, text_of(traits));
}

fs::path FrameFolder::frame(int number) const {
    char digits[16];
    std::snprintf(digits, sizeof digits, "%04d", number);
    return folder_ / (std::string(frame_start) + digits + extension_);
}

std::string FrameFolder::pattern() const {
    std::string pattern;
    for (const char c : (folder_ / frame_start).string())
        pattern += c == '%' ? "%%" : std::string(1, c);
    return pattern + "%04d" + extension_;
}

bool FrameFolder::has(int number) const {
    const fs::path file = frame(number);
    if (!fs::exists(file))
        return false;
    try {
        const Image image = extension_ == ".png" ? read_png(file) : read_exr(file);
        return image.width == width_ && image.height == height_;
    } catch (const std::exception&) {
        return false;
    }
}

std::vector<fs::path> FrameFolder::files_there(bool (*is_one)(const fs::path&)) const {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
        if (is_one(entry.path()))
            files.push_back(entry.path());
    return files;
}

}  // namespace demo
