// SPDX-License-Identifier: MIT

// The rows of "The mesh as flat data", each with what it is to reach: one thread, 1920 x 1440 pixels.

#include "contestant.hpp"
#include "workloads.hpp"

#include <lightmesh/lightmesh.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace {

using lightmesh::LightMesh;
using lightmesh::ShortTest;
using Mesh = LightMesh<demo::EmbreeIntersector>;

template <class Work>
double seconds(Work&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

template <class Work>
double least_seconds(int passes, Work&& work) {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < passes; ++i)
        least = (std::min)(least, seconds(work));
    return least;
}

std::vector<lightmesh::Light> lights_of(const bench::Workload& workload) {
    std::vector<lightmesh::Light> lights;
    for (const glm::vec3& position : workload.lights)
        lights.emplace_back(lightmesh::PointLight{.position = position});
    return lights;
}

Mesh make_mesh(const bench::Workload& workload, ShortTest short_test) {
    return Mesh{workload.scene.intersector(), lights_of(workload),
                lightmesh::Settings{.radius = workload.radius, .quality = 4.0f, .short_test = short_test}};
}

/// Asks for all lights at all points, tile by tile.
void ask(const Mesh& mesh, const bench::ShadingPoints& points, std::vector<float>& values) {
    for (std::size_t t = 0; t < points.tile_count(); ++t) {
        const bench::Points tile = points.tile(t);
        values.resize(tile.size() * mesh.light_count());
        mesh.visibility(tile.positions, tile.normals, values);
    }
}

/// Mean absolute difference of S to exact short tests, at some points.
double error_of(const Mesh& mesh, const bench::Workload& workload) {
    const Mesh exact = make_mesh(workload, ShortTest::exact);
    const bench::ShadingPoints sample = workload.points.sample(40);
    std::vector<float> values;
    std::vector<float> expected;
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t t = 0; t < sample.tile_count(); ++t) {
        const bench::Points tile = sample.tile(t);
        values.resize(tile.size() * mesh.light_count());
        expected.resize(values.size());
        mesh.visibility(tile.positions, tile.normals, values);
        exact.visibility(tile.positions, tile.normals, expected);
        for (std::size_t i = 0; i < tile.size(); ++i) {
            for (std::size_t l = 0; l < mesh.light_count(); ++l) {
                if (!workload.faces(l, tile.positions[i], tile.normals[i]))
                    continue;
                const std::size_t at = i * mesh.light_count() + l;
                sum += std::abs(static_cast<double>(values[at]) - static_cast<double>(expected[at]));
                count += 1.0;
            }
        }
    }
    return sum / count;
}

double hard_ns(const bench::Workload& workload, const bench::ShadingPoints& points) {
    const auto hard = bench::make_hard_shadows(workload, "single");
    std::vector<float> values;
    const double time = least_seconds(3, [&] {
        for (std::size_t t = 0; t < points.tile_count(); ++t) {
            const bench::Points tile = points.tile(t);
            values.resize(tile.size() * workload.lights.size());
            hard->find(tile, values);
        }
    });
    return 1e9 * time / static_cast<double>(points.size());
}

void row(const std::string& what, double measured, double to_reach, bool at_least, const std::string& note) {
    const bool reached = at_least ? measured >= to_reach : measured <= to_reach;
    std::printf("| %s | %.3g | %s %.3g | %s | %s |\n", what.c_str(), measured,
                at_least ? ">=" : "<=", to_reach, reached ? "yes" : "no", note.c_str());
    std::fflush(stdout);
}

std::string error_text(double error) {
    std::array<char, 64> text;
    std::snprintf(text.data(), text.size(), "error %.3g %%", 100.0 * error);
    return text.data();
}

void time_queries() {
    const bench::Workload& park = bench::workload("park", 64);
    const bench::ShadingPoints part = park.points.part(100000);
    std::vector<float> values;
    const double hard = hard_ns(park, part);
    for (const auto& [short_test, name, to_reach] :
         {std::tuple(ShortTest::none, "Express", 35.0), std::tuple(ShortTest::linked, "Linked", 18.0)}) {
        const Mesh mesh = make_mesh(park, short_test);
        ask(mesh, part, values);
        const double warm =
            1e9 * least_seconds(5, [&] { ask(mesh, part, values); }) / static_cast<double>(part.size());
        row(std::string(name) + " warm, 64 lights, park, times faster than hard single rays", hard / warm,
            to_reach, true,
            std::to_string(static_cast<int>(warm)) + " ns a point, " + error_text(error_of(mesh, park)));
    }
    const bench::Workload& many = bench::workload("park", 256);
    const bench::ShadingPoints fewer = many.points.part(40000);
    const Mesh mesh = make_mesh(many, ShortTest::none);
    ask(mesh, fewer, values);
    const double warm =
        1e9 * least_seconds(5, [&] { ask(mesh, fewer, values); }) / static_cast<double>(fewer.size());
    row("Express warm at 256 lights, park, ns a point and light", warm / 256.0, 1.5, false, "");
}

void weigh_frames() {
    for (const auto& [scene, to_reach] : {std::pair("park", 6.0), std::pair("rooms", 1.0)}) {
        const bench::Workload& workload = bench::workload(scene, 64);
        const Mesh mesh = make_mesh(workload, ShortTest::linked);
        std::vector<float> values;
        const double filling = seconds([&] { ask(mesh, workload.points, values); });
        const lightmesh::MeshStatistics held = mesh.statistics();
        row(std::string("MB of the frame's mesh at 64 lights, Linked, ") + scene,
            static_cast<double>(held.bytes) / 1e6, to_reach, false,
            std::to_string(held.long_rays) + " long rays, " + error_text(error_of(mesh, workload)));
        if (std::string(scene) != "park")
            continue;
        const bench::Points one = workload.points.tile(0);
        std::vector<float> first(64);
        const double loading = seconds([&] {
            const std::vector<std::byte> bytes = mesh.snapshot();
            const std::vector<std::byte> file(bytes);
            Mesh loaded = make_mesh(workload, ShortTest::linked);
            loaded.merge(file);
            loaded.visibility(one.positions[0], one.normals[0], std::span<float>(first));
        });
        row("save, load, first query of a mesh of the park, times faster than filling it", filling / loading,
            50.0, true, "");
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
    for (int y = 0; y < 1250; ++y)
        for (int x = 0; x < 1250; ++x)
            points.push_back({.position = {0.8f * static_cast<float>(x), 0.8f * static_cast<float>(y), 0.0f},
                              .normal = {0, 0, 1}});
    mesh.fill(std::span<const lightmesh::SurfacePoint>(points));
    std::vector<std::byte> bytes = mesh.snapshot();
    const double taking = least_seconds(2, [&] { bytes = mesh.snapshot(); });
    const double checking =
        least_seconds(2, [&] { const lightmesh::SnapshotView view{std::span<const std::byte>(bytes)}; });
    LightMesh other{Checkers{}, lights, settings};
    const double merging = seconds([&] { other.merge(bytes); });
    std::vector<std::byte> copy(bytes.size());
    const double copying = least_seconds(5, [&] { std::memcpy(copy.data(), bytes.data(), bytes.size()); });
    const std::string note = std::to_string(mesh.statistics().light_points) + " light points, " +
                             std::to_string(bytes.size() / 1000000) + " MB";
    row("snapshot taken, over the speed of memory copies", copying / taking, 0.25, true, note);
    row("snapshot validated, over the speed of memory copies", copying / checking, 0.25, true, note);
    row("snapshot merged, over the speed of memory copies", copying / merging, 0.25, true, note);
}

}  // namespace

int main() {
    std::printf("The mesh as flat data; kernels: %s; built with %s\n\n", lightmesh::kernel_name(),
                LIGHTMESH_FLAGS);
    std::printf("| what | measured | to reach | reached | beside it |\n|---|--:|--:|---|---|\n");
    time_queries();
    weigh_frames();
    time_snapshots();
}
