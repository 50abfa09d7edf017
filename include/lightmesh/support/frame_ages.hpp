// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace lightmesh::detail {

/// The time that things have gone unused: how many of them for so many frames.
class FrameAges {
public:
    /// Frames from here on are not told apart.
    static constexpr int oldest = 255;

    void add(int frames_unused) {
        ++counts_[static_cast<std::size_t>((std::min)(frames_unused, oldest))];
        ++all_;
    }

    /// The greatest age for which all that are no older are at most a share of all; 0 at least.
    int most_of(double share) const {
        std::size_t kept = counts_[0];
        int frames = 0;
        while (frames < oldest) {
            kept += counts_[static_cast<std::size_t>(frames + 1)];
            if (static_cast<double>(kept) > share * static_cast<double>(all_))
                break;
            ++frames;
        }
        return frames;
    }

    /// True if any are older.
    bool has_older(int frames) const {
        return std::any_of(counts_.begin() + frames + 1, counts_.end(),
                           [](std::size_t count) { return count != 0; });
    }

private:
    std::array<std::size_t, oldest + 1> counts_{};
    std::size_t all_ = 0;
};

}  // namespace lightmesh::detail
