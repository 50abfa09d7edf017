// SPDX-License-Identifier: MIT
#pragma once

#include "render/ranks.hpp"

#include <CLI/CLI.hpp>

namespace demo {

/// Exit status of a program that the user has stopped, as shells have it.
inline constexpr int exit_interrupted = 130;

// The commands of lightmesh-render. Each adds itself, its options and what it does; `status` becomes the
// program's exit status. They throw std::exception for what goes wrong. Where `ranks` are more than one, all
// of them must run the same command.

/// One picture by one algorithm.
void add_picture_command(CLI::App& program, Ranks& ranks, int& status);
/// A film of a scene that moves.
void add_film_command(CLI::App& program, Ranks& ranks, int& status);
/// One view by several algorithms, and how they differ.
void add_compare_command(CLI::App& program, int& status);
/// The two tables of the paper, on this machine.
void add_tables_command(CLI::App& program, int& status);
/// The contents of a file.
void add_info_command(CLI::App& program, int& status);

}  // namespace demo
