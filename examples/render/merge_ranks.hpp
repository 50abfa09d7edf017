// SPDX-License-Identifier: MIT
#pragma once

#include "render/ranks.hpp"
#include "render/visibility.hpp"

#include <cstddef>
#include <cstdint>

namespace demo {

/// Brings what the meshes or caches of all ranks know together, time and again, and keeps count.
class RankMerge {
public:
    /// All ranks must call this together, with the scene in the same pose; each `visibility` must have been
    /// told of it: then what has moved has been forgotten, and contributes nothing. Afterwards each knows
    /// what all know, unless nobody has traced anything since the last time. Throws what waiting and merging
    /// throw.
    void run(Ranks& ranks, Visibility& visibility);

    int count() const { return count_; }          ///< those in which there was something to merge
    std::size_t bytes() const { return bytes_; }  ///< of what all know, each time, summed
    double seconds() const { return seconds_; }   ///< of this rank, with what it waited for others

private:
    std::uint64_t merged_rays_ = 0;
    int count_ = 0;
    std::size_t bytes_ = 0;
    double seconds_ = 0.0;
};

}  // namespace demo
