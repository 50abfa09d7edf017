// SPDX-License-Identifier: MIT
#pragma once

#include "render/files.hpp"
#include "temporary_folder.hpp"

#include <sys/wait.h>

#include <cstdlib>
#include <string>

/// Programs run as their users run them.

namespace test {

struct Finished {
    int status;  ///< -1 if a signal ended it
    std::string output;
    std::string errors;
};

/// Runs a command of the shell; what it prints lies in the folder while it runs.
inline Finished run(const TemporaryFolder& folder, const std::string& command) {
    const std::string output = (folder / "output.txt").string();
    const std::string errors = (folder / "errors.txt").string();
    const int ended = std::system(("{ " + command + " ; } >" + output + " 2>" + errors).c_str());
    return {WIFEXITED(ended) ? WEXITSTATUS(ended) : -1, demo::read_file(output), demo::read_file(errors)};
}

}  // namespace test
