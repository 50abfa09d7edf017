// SPDX-License-Identifier: MIT
#include "render/terminal.hpp"

#include "image/part_file.hpp"

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <utility>

namespace demo {

namespace {

constexpr int bar_width = 40;
constexpr std::chrono::seconds between_lines{5};

std::atomic<bool> was_interrupted{false};

/// The first signal asks the program to end, the second one ends it.
void note_interrupt(int signal) {
    if (!was_interrupted.exchange(true, std::memory_order_relaxed))
        return;
    remove_part_files();
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

}  // namespace

ProgressBar::ProgressBar(std::string caption, Elsewhere elsewhere)
    : caption_(std::move(caption)), is_terminal_(isatty(STDERR_FILENO) != 0), elsewhere_(elsewhere) {
    show(0.0);
}

ProgressBar::~ProgressBar() {
    if (is_terminal_)
        std::fprintf(stderr, "\r\033[K");
}

void ProgressBar::show(double done, const std::string& note) {
    const int percent = static_cast<int>(100.0 * done);
    if (!is_terminal_ && elsewhere_ == Elsewhere::lines) {
        const auto now = std::chrono::steady_clock::now();
        if (now - line_shown_ < between_lines)
            return;
        line_shown_ = now;
        std::fprintf(stderr, "%s: %d %% %s\n", caption_.c_str(), percent, note.c_str());
        return;
    }
    if (!is_terminal_ || (percent == shown_percent_ && note == shown_note_))
        return;
    shown_percent_ = percent;
    shown_note_ = note;
    const int full = percent * bar_width / 100;
    std::fprintf(stderr, "\r%s [%s%s] %3d %% %s\033[K", caption_.c_str(), std::string(full, '#').c_str(),
                 std::string(bar_width - full, '.').c_str(), percent, note.c_str());
    std::fflush(stderr);
}

const std::atomic<bool>& interrupted() {
    static const bool watches = [] {
        std::signal(SIGINT, note_interrupt);
        std::signal(SIGTERM, note_interrupt);
        return true;
    }();
    static_cast<void>(watches);
    return was_interrupted;
}

}  // namespace demo
