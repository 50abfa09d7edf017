// SPDX-License-Identifier: MIT
#include "render/merge_ranks.hpp"

#include "render/stopwatch.hpp"

#include <utility>

namespace demo {

namespace {

constexpr int tag_known = 16000;

}  // namespace

/// Up a tree, pairs first, then pairs of pairs; and what rank 0 knows then goes to all. Ranks that have found
/// nothing new send nothing.
void RankMerge::run(Ranks& ranks, Visibility& visibility) {
    if (ranks.size() == 1)
        return;
    const Stopwatch stopwatch;
    const auto merge = [&](const Bytes& known) {
        if (!known.empty())
            visibility.merge(known);
    };
    bool has_news = kept_rays(visibility) != merged_rays_;
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
        ranks.send(rank - step, tag_known, has_news ? visibility.snapshot() : Bytes{});
    const Bytes all = ranks.broadcast(ranks.is_first() && has_news ? visibility.snapshot() : Bytes{});
    if (!ranks.is_first())
        merge(all);
    merged_rays_ = kept_rays(visibility);
    count_ += all.empty() ? 0 : 1;
    bytes_ += all.size();
    seconds_ += stopwatch.seconds();
}

}  // namespace demo
