// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

namespace demo {

/// Things in a row, of which each rank takes one after another. Neighbours have most in common: so each
/// begins with a run of its own, and whose run is at its end goes on with the back half of the longest one.
class Runs {
public:
    Runs(std::size_t count, int ranks) {
        const auto parts = static_cast<std::size_t>(ranks);
        for (std::size_t i = 0; i < parts; ++i)
            runs_.push_back({i * count / parts, (i + 1) * count / parts});
    }

    /// Nothing if all are taken.
    std::optional<std::size_t> next(int rank) {
        Run& mine = runs_[static_cast<std::size_t>(rank)];
        if (mine.size() == 0) {
            Run& longest = *std::ranges::max_element(runs_, {}, &Run::size);
            if (longest.size() == 0)
                return std::nullopt;
            const std::size_t middle = longest.begin + longest.size() / 2;
            mine = {middle, longest.end};
            longest.end = middle;
        }
        return mine.begin++;
    }

private:
    struct Run {
        std::size_t begin;
        std::size_t end;

        std::size_t size() const { return end - begin; }
    };

    std::vector<Run> runs_;
};

/// Which of some things in a row come first, so that what all others are between is known: the first, then
/// the one in the middle, then those in the middle of the halves, and so on: step by step, until there are at
/// least so many as ranks, or all.
inline std::vector<std::vector<std::size_t>> key_steps(std::size_t count, int ranks) {
    std::vector<std::vector<std::size_t>> steps;
    if (count == 0)
        return steps;
    std::vector<std::size_t> bounds{0, count};
    steps.push_back({0});
    while (bounds.size() - 1 < (std::min)(static_cast<std::size_t>(ranks), count)) {
        std::vector<std::size_t> halved;
        steps.emplace_back();
        for (std::size_t i = 0; i + 1 < bounds.size(); ++i) {
            halved.push_back(bounds[i]);
            if (bounds[i + 1] - bounds[i] < 2)
                continue;
            steps.back().push_back(bounds[i] + (bounds[i + 1] - bounds[i]) / 2);
            halved.push_back(steps.back().back());
        }
        halved.push_back(count);
        bounds = std::move(halved);
    }
    return steps;
}

}  // namespace demo
