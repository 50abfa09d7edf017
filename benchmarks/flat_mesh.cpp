// SPDX-License-Identifier: MIT

// The rows of "The mesh as flat data", each with what it is to reach: one thread, 1920 x 1440 pixels.

#include "mesh_frame.hpp"
#include "workloads.hpp"

#include <lightmesh/lightmesh.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace {

using bench::ask;
using bench::error_of;
using bench::error_text;
using bench::least_seconds;
using bench::Mesh;
using bench::print_row;
using bench::seconds;
using lightmesh::LightMesh;
using lightmesh::ShortTest;

void time_queries() {
    const bench::Workload& park = bench::workload("park", 64);
    const bench::ShadingPoints part = park.points.part(100000);
    const double hard = bench::hard_ns(park, part);
    for (const auto& [short_test, name, to_reach] :
         {std::tuple(ShortTest::none, "Express", 35.0), std::tuple(ShortTest::linked, "Linked", 18.0)}) {
        const Mesh mesh = bench::make_mesh(park, short_test);
        ask(mesh, part);
        const double warm =
            1e9 * least_seconds(5, [&] { ask(mesh, part); }) / static_cast<double>(part.size());
        print_row(std::string(name) + " warm, 64 lights, park, times faster than hard single rays",
                  hard / warm, to_reach, true,
                  std::to_string(static_cast<int>(warm)) + " ns a point, " +
                      error_text(error_of(mesh, park)));
    }
    const bench::Workload& many = bench::workload("park", 256);
    const bench::ShadingPoints fewer = many.points.part(40000);
    const Mesh mesh = bench::make_mesh(many, ShortTest::none);
    ask(mesh, fewer);
    const double warm = 1e9 * least_seconds(5, [&] { ask(mesh, fewer); }) / static_cast<double>(fewer.size());
    print_row("Express warm at 256 lights, park, ns a point and light", warm / 256.0, 1.5, false, "");
}

void weigh_frames() {
    for (const auto& [scene, to_reach] : {std::pair("park", 6.0), std::pair("rooms", 1.0)}) {
        const bench::Workload& workload = bench::workload(scene, 64);
        const Mesh mesh = bench::make_mesh(workload, ShortTest::linked);
        const double filling = seconds([&] { ask(mesh, workload.points); });
        const lightmesh::MeshStatistics held = mesh.statistics();
        print_row(std::string("MB of the frame's mesh at 64 lights, Linked, ") + scene,
                  static_cast<double>(held.bytes) / 1e6, to_reach, false,
                  std::to_string(held.long_rays) + " long rays, " + error_text(error_of(mesh, workload)));
        if (std::string(scene) != "park")
            continue;
        const bench::Points one = workload.points.tile(0);
        std::vector<float> first(64);
        const double loading = seconds([&] {
            const std::vector<std::byte> bytes = mesh.snapshot();
            const std::vector<std::byte> file(bytes);
            Mesh loaded = bench::make_mesh(workload, ShortTest::linked);
            loaded.merge(file);
            loaded.visibility(one.positions[0], one.normals[0], std::span<float>(first));
        });
        print_row("save, load, first query of a mesh of the park, times faster than filling it",
                  filling / loading, 50.0, true, "");
    }
}

struct Checkers {
    bool occluded(const lightmesh::Segment& s) const {
        const auto cell = [](float v) {
            return static_cast<int>(std::floor(v)) & 1;
        };
        return (cell(s.target.x) ^ cell(s.target.y) ^ cell(s.target.z) ^ cell(s.origin.x)) != 0;
    }
};

void time_snapshots() {
    // Some 16 million light points under 64 lights.
    std::vector<lightmesh::Light> lights;
    for (int i = 0; i < 64; ++i)
        lights.emplace_back(lightmesh::PointLight{.position = {0.37f * static_cast<float>(i), 1.0f, 500.0f}});
    const lightmesh::Settings settings{.radius = 1.0f, .quality = 2.0f, .short_test = ShortTest::none};
    const LightMesh mesh{Checkers{}, lights, settings};
    std::vector<lightmesh::SurfacePoint> points;
    for (int y = 0; y < 1770; ++y)
        for (int x = 0; x < 1770; ++x)
            points.push_back({.position = {0.8f * static_cast<float>(x), 0.8f * static_cast<float>(y), 0.0f},
                              .normal = {0, 0, 1}});
    mesh.fill(std::span<const lightmesh::SurfacePoint>(points));
    std::vector<std::byte> bytes = mesh.snapshot();
    constexpr int repetitions = 5;
    const double taking = least_seconds(repetitions, [&] { bytes = mesh.snapshot(); });
    const double checking = least_seconds(
        repetitions, [&] { const lightmesh::SnapshotView view{std::span<const std::byte>(bytes)}; });
    // Each time into a mesh that knows nothing; its end is not timed.
    double merging = std::numeric_limits<double>::infinity();
    for (int i = 0; i < repetitions; ++i) {
        LightMesh other{Checkers{}, lights, settings};
        merging = (std::min)(merging, seconds([&] { other.merge(bytes); }));
    }
    std::vector<std::byte> copy(bytes.size());
    const double copying =
        least_seconds(repetitions, [&] { std::memcpy(copy.data(), bytes.data(), bytes.size()); });
    const std::string note = std::to_string(mesh.statistics().light_points) + " light points, " +
                             std::to_string(bytes.size() / 1000000) + " MB";
    print_row("snapshot taken, over the speed of memory copies", copying / taking, 0.25, true, note);
    print_row("snapshot validated, over the speed of memory copies", copying / checking, 0.25, true, note);
    print_row("snapshot merged, over the speed of memory copies", copying / merging, 0.25, true, note);
}

/// Only times, for `run.sh` to compare programs that were compiled in two ways.
void print_times() {
    double sum = 0.0;
    for (const char* scene : {"park", "rooms"}) {
        const bench::Workload& workload = bench::workload(scene, 64);
        const bench::ShadingPoints part = workload.points.part(40000);
        for (const ShortTest short_test : {ShortTest::none, ShortTest::linked}) {
            const Mesh mesh = bench::make_mesh(workload, short_test);
            ask(mesh, part);
            sum +=
                std::log(1e9 * least_seconds(7, [&] { ask(mesh, part); }) / static_cast<double>(part.size()));
        }
    }
    std::printf("%.1f\n", std::exp(sum / 4.0));
}

}  // namespace

int main(int argument_count, char** arguments) {
    if (argument_count == 2 && std::string_view(arguments[1]) == "--times") {
        print_times();
        return 0;
    }
    std::printf("The mesh as flat data; kernels: %s; built with %s\n\n", lightmesh::kernel_name(),
                LIGHTMESH_FLAGS);
    bench::print_head();
    time_queries();
    weigh_frames();
    time_snapshots();
}
