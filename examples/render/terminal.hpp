// SPDX-License-Identifier: MIT
#pragma once

#include "render/renderer.hpp"

#include <atomic>
#include <chrono>
#include <string>

namespace demo {

/// A progress bar on the error stream if that is a terminal, else nothing. It goes when this goes.
class ProgressBar {
public:
    /// The progress where there is no terminal: nothing, or a line now and then, for those who see the
    /// program through another one.
    enum class Elsewhere { nothing, lines };

    explicit ProgressBar(std::string caption, Elsewhere elsewhere = Elsewhere::nothing);
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    /// `note`: a few words behind the bar, such as the time left.
    void show(double done, const std::string& note = "");

private:
    std::string caption_;
    bool is_terminal_;
    Elsewhere elsewhere_;
    std::chrono::steady_clock::time_point line_shown_ = std::chrono::steady_clock::now();
    int shown_percent_ = -1;
    std::string shown_note_;
};

/// True once the user has pressed Ctrl-C, or the program was told to end (SIGTERM). From the first call on
/// these do nothing else, but that a second one ends the program.
const std::atomic<bool>& interrupted();

}  // namespace demo
