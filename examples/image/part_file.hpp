// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace demo {

/// A file that is written beside its target and renamed at the end. What is not finished goes with the
/// object, or by `remove_part_files` if a signal ends the program.
class PartFile {
public:
    explicit PartFile(const std::filesystem::path& target);
    ~PartFile();
    PartFile(const PartFile&) = delete;
    PartFile& operator=(const PartFile&) = delete;

    /// The name to write to; in the target's own folder, since a rename only works within a file system.
    const std::filesystem::path& path() const { return path_; }
    /// Puts the file, written and closed, in the target's place. Throws std::filesystem::filesystem_error.
    void finish();

private:
    std::filesystem::path target_;
    std::filesystem::path path_;
    int slot_;
};

/// Removes the files that are being written. For handlers of signals, before the program ends.
void remove_part_files() noexcept;

}  // namespace demo
