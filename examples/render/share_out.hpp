// SPDX-License-Identifier: MIT
#pragma once

#include "render/ranks.hpp"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>

namespace demo {

/// Lets long work notice that it is in vain, because the program was told to end or another rank has failed.
class WorkWatch {
public:
    /// `is_over` says of rank 0 whether another thread of it has learned of a failure.
    explicit WorkWatch(Ranks& ranks, const std::atomic<bool>* is_over = nullptr)
        : ranks_(ranks), is_over_(is_over) {}

    /// To be called now and then, by one thread at a time.
    void look();
    /// Does work while another thread looks, again and again: for work that is long between two chances to
    /// look, and may be told by `is_in_vain` at any moment. Work must not look itself. Throws what work and
    /// looking throw.
    void look_during(const std::function<void()>& work);
    /// Set by `look`: what is worked on need not be finished.
    const std::atomic<bool>& is_in_vain() const { return is_in_vain_; }

private:
    Ranks& ranks_;
    const std::atomic<bool>* is_over_;
    std::atomic<bool> is_in_vain_{false};
    std::chrono::steady_clock::time_point looked_{};
};

/// Does something on some rank; what comes of it goes to rank 0. `watch.look()` must be called now and then;
/// what is returned after it is in vain does not matter.
using Work = std::function<Bytes(std::size_t item, WorkWatch& watch)>;
/// Takes, on rank 0, what has come of it; by one thread at a time.
using TakeResult = std::function<void(std::size_t item, int rank, Bytes result)>;

/// Shares `count` things out over all ranks as these become free, in runs of neighbours: see `Runs`. All
/// ranks must call this together, with the same number. Rank 0 works like the others, while a thread of it
/// hands out; alone it does all in their order, without another thread. On rank 0 all has been taken on
/// return; the others return as soon as there is no more to do. Throws what work, taking and waiting throw:
/// see `Ranks`.
void share_out(Ranks& ranks, std::size_t count, const Work& work, const TakeResult& take);

}  // namespace demo
