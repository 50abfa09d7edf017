// SPDX-License-Identifier: MIT

// Time, rays, memory and error of light meshes beside those of shadow rays and shadow maps. Each repetition
// of a row is one pass of fixed work, so that cold rows are cold.

#include "checks.hpp"
#include "context.hpp"
#include "rows.hpp"
#include "timing.hpp"
#include "workloads.hpp"

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>

namespace {

using namespace bench;

void set_counters(benchmark::State& state, const Row& row, const Checked& checked, const Timing& timing) {
    const auto points = static_cast<double>(points_of(row.scene, row.most_points).size());
    const auto lights = static_cast<double>(row.lights);
    const auto cached_rays = row.cold ? static_cast<double>(timing.contestant->cached_rays()) : 0.0;
    state.counters["lights"] = lights;
    state.counters["points"] = points;
    state.counters["ns_per_point"] = 1e9 * timing.seconds / points;
    state.counters["ns_per_point_and_light"] = 1e9 * timing.seconds / (points * lights);
    state.counters["rays_per_point"] = checked.rays_per_point + cached_rays / points;
    state.counters["error"] = checked.error;
    state.counters["error_rms"] = checked.error_rms;
    if (const std::size_t light_points = timing.contestant->light_points(); light_points > 0) {
        state.counters["light_points"] = static_cast<double>(light_points);
        state.counters["bytes_per_light_point"] =
            static_cast<double>(timing.contestant->bytes()) / static_cast<double>(light_points);
    }
}

/// Interleaved rows are reported when the last of them is done, so a terminal is told what goes on.
void show_progress(const Row& row) {
    static int pass = 0;
    ++pass;
    if (isatty(STDERR_FILENO))
        std::cerr << "\r\033[K"
                  << "pass " << pass << ": " << row.name() << std::flush;
}

void run(benchmark::State& state, const Row& row) {
    show_progress(row);
    const Checked& checked = check(row);
    if (!checked.problem.empty()) {
        state.SkipWithError(checked.problem.c_str());
        return;
    }
    for (auto _ : state) {
        const Timing timing = time_pass(row);
        state.SetIterationTime(timing.seconds);
        set_counters(state, row, checked, timing);
        if (row.cold && !same_values(row, *timing.contestant))
            state.SkipWithError(
                "the mesh that was filled in this row gives other values than the one checked");
    }
}

double least(const std::vector<double>& values) {
    return *std::ranges::min_element(values);
}

}  // namespace

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv))
        return 1;
    describe_context();
    for (const Row& row : all_rows()) {
        benchmark::RegisterBenchmark(row.name().c_str(), run, row)
            ->Iterations(1)
            ->Repetitions(row.repetitions)
            ->UseManualTime()
            ->ComputeStatistics("min", least)
            ->ReportAggregatesOnly()
            ->Unit(benchmark::kMillisecond);
    }
    benchmark::RunSpecifiedBenchmarks();
    if (isatty(STDERR_FILENO))
        std::cerr << "\r\033[K";
    benchmark::Shutdown();
}
