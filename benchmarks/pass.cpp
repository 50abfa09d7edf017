// SPDX-License-Identifier: MIT
#include "pass.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <thread>

namespace bench {

Pass::Pass(const ShadingPoints& points, std::size_t lights, int threads) : points_(points), lights_(lights) {
    const unsigned count =
        threads > 0 ? static_cast<unsigned>(threads) : (std::max)(1u, std::thread::hardware_concurrency());
    lit_.assign(count, std::vector<float>(ShadingPoints::most_in_tile * lights));
}

void Pass::run(const Contestant& contestant) {
    std::atomic<std::size_t> next{0};
    const auto work = [&](std::vector<float>& lit) {
        for (std::size_t t = next++; t < points_.tile_count(); t = next++) {
            const Points tile = points_.tile(t);
            contestant.find(tile, std::span(lit).first(tile.size() * lights_));
            benchmark::DoNotOptimize(lit.data());
            benchmark::ClobberMemory();
        }
    };
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < lit_.size(); ++i)
        others.emplace_back(work, std::ref(lit_[i]));
    work(lit_[0]);
}

}  // namespace bench
