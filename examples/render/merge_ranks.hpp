// SPDX-License-Identifier: MIT
#pragma once

#include "render/ranks.hpp"
#include "render/stopwatch.hpp"
#include "render/visibility.hpp"

#include <cstddef>
#include <cstdint>

namespace demo {

/// Brings what the meshes or caches of all ranks know together, time and again, and keeps count.
class RankMerge {
public:
    /// All ranks must call this together, with the scene in the same pose; each `shadows` (a `Visibility`, or
    /// what else has snapshots, merges them and counts rays) must have been told of it: then what has moved
    /// has been forgotten, and contributes nothing. Afterwards each knows what all know, unless nobody has
    /// traced anything since the last time. Throws what waiting and merging throw.
    template <class Shadows>
    void run(Ranks& ranks, Shadows& shadows);

    int count() const { return count_; }          ///< those in which there was something to merge
    std::size_t bytes() const { return bytes_; }  ///< of what all know, each time, summed
    double seconds() const { return seconds_; }   ///< of this rank, with what it waited for others

private:
    static constexpr int tag_known = 16000;

    std::uint64_t merged_rays_ = 0;
    int count_ = 0;
    std::size_t bytes_ = 0;
    double seconds_ = 0.0;
};

/// Up a tree, pairs first, then pairs of pairs; and what rank 0 knows then goes to all. Ranks that have found
/// nothing new send nothing.
template <class Shadows>
void RankMerge::run(Ranks& ranks, Shadows& shadows) {
    if (ranks.size() == 1)
        return;
    const Stopwatch stopwatch;
    const auto merge = [&](const Bytes& known) {
        if (!known.empty())
            shadows.merge(known);
    };
    bool has_news = kept_rays(shadows) != merged_rays_;
    const int rank = ranks.rank();
    int step = 1;
    for (; step < ranks.size() && rank % (2 * step) == 0; step *= 2) {
        if (rank + step >= ranks.size())
            continue;
        const Bytes known = ranks.receive(rank + step, tag_known);
        has_news = has_news || !known.empty();
        merge(known);
    }
    if (!ranks.is_first())
        ranks.send(rank - step, tag_known, has_news ? shadows.snapshot() : Bytes{});
    const Bytes all = ranks.broadcast(ranks.is_first() && has_news ? shadows.snapshot() : Bytes{});
    if (!ranks.is_first())
        merge(all);
    merged_rays_ = kept_rays(shadows);
    count_ += all.empty() ? 0 : 1;
    bytes_ += all.size();
    seconds_ += stopwatch.seconds();
}

}  // namespace demo
