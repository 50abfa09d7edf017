// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace demo {

/// All that decides how the frames of a film look: names and values.
using FilmTraits = std::vector<std::pair<std::string, std::string>>;

/// A line for each.
std::string text_of(const FilmTraits& traits);
/// The differences of a film of which there is such a text: "width is 48 there and 64 here, ..."; empty if it
/// does not.
std::string differences(const std::string& there, const FilmTraits& here);

/// A folder of numbered frames, frame-0001.png and so on, and film.txt, which says what they are of: so a
/// film can be gone on with, and two are never mixed.
class FrameFolder {
public:
    /// `extension`: .png or .exr; the size in pixels. Makes the folder if it is not there.
    FrameFolder(std::filesystem::path folder, std::string extension, int width, int height);

    /// Writes film.txt, or finds that it says the same, and removes what a program that was killed has left
    /// half written. Throws std::runtime_error that names what differs if
    /// there are frames of another film; with `overwrite` they are removed instead.
    void claim(const FilmTraits& traits, bool overwrite) const;

    /// Frames count from 1.
    std::filesystem::path frame(int number) const;
    /// The name of all frames for printf, which puts their number into it.
    std::string pattern() const;
    /// True if a frame is there and can be read, in the right size.
    bool has(int number) const;

private:
    std::vector<std::filesystem::path> files_there(bool (*is_one)(const std::filesystem::path&)) const;

    std::filesystem::path folder_;
    std::string extension_;
    int width_;
    int height_;
};

}  // namespace demo
