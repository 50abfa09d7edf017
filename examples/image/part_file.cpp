// SPDX-License-Identifier: MIT
#include "part_file.hpp"

#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <string>
#include <system_error>

namespace demo {
namespace {

/// Names of files that are being written, for a handler of signals: it may take no lock and no memory.
struct Slot {
    std::atomic<bool> is_taken{false};
    std::atomic<bool> is_set{false};
    std::array<char, 4096> name{};
};

std::array<Slot, 4> slots;

/// -1 if all are taken, or the name is too long.
int take_slot(const std::string& name) {
    if (name.size() >= slots[0].name.size())
        return -1;
    for (std::size_t i = 0; i < slots.size(); ++i) {
        if (slots[i].is_taken.exchange(true))
            continue;
        std::memcpy(slots[i].name.data(), name.c_str(), name.size() + 1);
        slots[i].is_set = true;
        return static_cast<int>(i);
    }
    return -1;
}

void free_slot(int slot) {
    if (slot < 0)
        return;
    slots[static_cast<std::size_t>(slot)].is_set = false;
    slots[static_cast<std::size_t>(slot)].is_taken = false;
}

std::filesystem::path beside(const std::filesystem::path& target) {
    std::filesystem::path name = target.filename();
    name += ".part" + std::to_string(::getpid());
    return target.parent_path() / name;
}

}  // namespace

PartFile::PartFile(const std::filesystem::path& target)
    : target_(target), path_(beside(target)), slot_(take_slot(path_.string())) {}

PartFile::~PartFile() {
    free_slot(slot_);
    std::error_code ignored;
    if (!path_.empty())
        std::filesystem::remove(path_, ignored);
}

void PartFile::finish() {
    std::filesystem::rename(path_, target_);
    path_.clear();
}

void remove_part_files() noexcept {
    for (const Slot& slot : slots)
        if (slot.is_set)
            ::unlink(slot.name.data());
}

}  // namespace demo
