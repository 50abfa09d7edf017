// SPDX-License-Identifier: MIT
#include "timing.hpp"

#include "workloads.hpp"

#include <benchmark/benchmark.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace bench {

namespace {

using Clock = std::chrono::steady_clock;

/// Takes tiles until none is left.
void work(const Contestant& contestant, const ShadingPoints& points, std::atomic<std::size_t>& next,
          std::span<float> lit, std::size_t lights) {
    for (std::size_t t = next++; t < points.tile_count(); t = next++) {
        const Points tile = points.tile(t);
        contestant.find(tile, lit.first(tile.size() * lights));
        benchmark::DoNotOptimize(lit.data());
        benchmark::ClobberMemory();
    }
}

}  // namespace

Timing time_pass(const Row& row) {
    const ShadingPoints& points = points_of(row.scene, row.most_points);
    const auto threads = static_cast<std::size_t>(row.threads);
    std::vector<std::vector<float>> lit(threads,
                                        std::vector<float>(ShadingPoints::most_in_tile * row.lights));
    std::atomic<std::size_t> next{0};
    std::shared_ptr<const Contestant> asked = row.cold ? nullptr : contestant(row);

    const auto start = Clock::now();
    if (row.cold)
        asked = contestant(row);
    {
        std::vector<std::jthread> others;
        for (std::size_t i = 1; i < threads; ++i)
            others.emplace_back([&, i] { work(*asked, points, next, lit[i], row.lights); });
        work(*asked, points, next, lit[0], row.lights);
    }
    const std::chrono::duration<double> seconds = Clock::now() - start;
    return {seconds.count(), std::move(asked)};
}

}  // namespace bench
