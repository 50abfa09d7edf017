// SPDX-License-Identifier: MIT
#pragma once

#include "model.hpp"

#include <cstddef>
#include <functional>

namespace demo {

/// Bounds for a reader: what a file can make it take.
struct ReaderLimits {
    std::size_t bytes;       ///< of memory beyond what the program has
    std::size_t most_bytes;  ///< what `allow_memory` can raise them to
    unsigned seconds;        ///< of processor time
};

/// Memory for each byte of a file: to read it, and at most to unpack it.
inline constexpr std::size_t read_factor = 4;
inline constexpr std::size_t unpacked_factor = 24;

/// Runs a reader in a child process, since libraries crash, hang and take all memory on files that are made
/// for that. Throws std::runtime_error with what the reader throws, or that it crashed or ran into a limit.
Model read_isolated(const std::function<Model()>& reader, const ReaderLimits& limits);

/// Raises the child's limit on memory by so many bytes, for what a file says to unpack: pictures, compressed
/// meshes, meshes that are there many times. Does nothing outside of a child.
void allow_memory(std::size_t bytes);

/// As `allow_memory`, for a file of so many bytes that the first one refers to: what it may take at once, and
/// what unpacking may raise that to.
void allow_file(std::size_t bytes);

}  // namespace demo
