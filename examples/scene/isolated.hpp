// SPDX-License-Identifier: MIT
#pragma once

#include "model.hpp"

#include <cstddef>
#include <filesystem>

namespace demo {

/// Bounds for a reader: what a file can make it take.
struct ReaderLimits {
    std::size_t bytes;  ///< of memory beyond what the program has
    unsigned seconds;   ///< of processor time
};

/// Runs a reader in a child process, since libraries crash, hang and take all memory on files that are made
/// for that. Throws std::runtime_error with what the reader throws, or that it crashed or ran into a limit.
Model read_isolated(Model (*reader)(const std::filesystem::path&), const std::filesystem::path& file,
                    const ReaderLimits& limits);

}  // namespace demo
