// SPDX-License-Identifier: MIT

// From how many lights on a filled mesh pays: as many as, where they reach a point, take hard shadow rays
// longer. A row for each scene, on one thread.

#include "mesh_frame.hpp"
#include "render/text_table.hpp"
#include "workloads.hpp"

#include <lightmesh/lightmesh.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace {

using bench::Mesh;
using lightmesh::ShortTest;

constexpr std::size_t most_points = 30000;
constexpr int repetitions = 7;

/// A number of lights, and what they take.
struct Sample {
    double in_reach = 0.0;  ///< that a point faces, in the mean
    double gain = 0.0;      ///< times that rays take as long as the mesh
    double mesh_ns = 0.0;   ///< a point
    double rays_ns = 0.0;
};

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double lights_in_reach(const bench::Workload& workload, const bench::ShadingPoints& points) {
    double sum = 0.0;
    for (std::size_t t = 0; t < points.tile_count(); ++t) {
        const bench::Points tile = points.tile(t);
        for (std::size_t i = 0; i < tile.size(); ++i)
            for (std::size_t l = 0; l < workload.lights.size(); ++l)
                sum += workload.faces(l, tile.positions[i], tile.normals[i]) ? 1.0 : 0.0;
    }
    return sum / static_cast<double>(points.size());
}

void trace(const bench::Contestant& rays, const bench::Workload& workload,
           const bench::ShadingPoints& points) {
    std::vector<float> values;
    for (std::size_t t = 0; t < points.tile_count(); ++t) {
        const bench::Points tile = points.tile(t);
        values.resize(tile.size() * workload.lights.size());
        rays.find(tile, values);
    }
}

/// Mesh and rays take turns, so that a busy machine is slow for both.
Sample measure(const bench::Workload& workload, const bench::ShadingPoints& points, ShortTest short_test) {
    const Mesh mesh = bench::make_mesh(workload, short_test);
    bench::ask(mesh, points);
    const auto rays = bench::make_hard_shadows(workload, "single");
    Sample sample{.in_reach = lights_in_reach(workload, points)};
    const double ns = 1e9 / static_cast<double>(points.size());
    std::vector<double> gains;
    std::vector<double> mesh_ns;
    std::vector<double> rays_ns;
    for (int i = 0; i < repetitions; ++i) {
        mesh_ns.push_back(ns * bench::processor_seconds([&] { bench::ask(mesh, points); }));
        rays_ns.push_back(ns * bench::processor_seconds([&] { trace(*rays, workload, points); }));
        gains.push_back(rays_ns.back() / mesh_ns.back());
    }
    sample.gain = median(gains);
    sample.mesh_ns = median(mesh_ns);
    sample.rays_ns = median(rays_ns);
    return sample;
}

/// The number of lights in reach from which on, as far as was measured, all gains are above 1: between the
/// samples on both sides.
std::optional<double> break_even(const std::vector<Sample>& samples) {
    std::size_t first = samples.size();
    while (first > 0 && samples[first - 1].gain >= 1.0)
        --first;
    if (first == samples.size())
        return std::nullopt;
    const Sample& after = samples[first];
    if (first == 0)
        return after.in_reach;
    const Sample& before = samples[first - 1];
    return before.in_reach +
           (after.in_reach - before.in_reach) * (1.0 - before.gain) / (after.gain - before.gain);
}

}  // namespace

int main(int argc, char** argv) {
    std::printf(
        "Lights in reach from which on a filled mesh takes less time than a hard shadow ray to each; "
        "kernels: %s\n\n"
        "| scene, short test | lights in reach | ns a point with 64 lights, mesh / rays | beside it |\n"
        "|---|--:|--:|---|\n",
        lightmesh::kernel_name());
    std::vector<std::string> scenes(argv + 1, argv + argc);
    if (scenes.empty())
        scenes = {"spheres", "street", "rooms", "park"};
    for (const std::string& scene : scenes)
        for (const auto& [short_test, name] :
             {std::pair(ShortTest::linked, "Linked"), std::pair(ShortTest::none, "Express")}) {
            std::vector<Sample> samples;
            std::string beside;
            for (const std::size_t lights : std::array<std::size_t, 9>{1, 2, 4, 6, 8, 12, 16, 32, 64}) {
                const bench::Workload& workload = bench::workload(scene, lights);
                samples.push_back(measure(workload, workload.points.part(most_points), short_test));
                beside += demo::fixed(samples.back().in_reach, 1) +
                          " in reach: " + demo::fixed(samples.back().gain, 2) + ", ";
            }
            const bench::Workload& workload = bench::workload(scene, 64);
            beside += bench::error_text(bench::difference(bench::make_mesh(workload, short_test),
                                                          bench::make_mesh(workload, ShortTest::exact),
                                                          workload, workload.points, 10));
            const std::optional<double> lights = break_even(samples);
            std::printf("| %s, %s | %s | %.0f / %.0f | times faster than rays by lights in %s |\n",
                        scene.c_str(), name, lights ? demo::fixed(*lights, 1).c_str() : "never",
                        samples.back().mesh_ns, samples.back().rays_ns, beside.c_str());
            std::fflush(stdout);
        }
}
