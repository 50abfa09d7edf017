// SPDX-License-Identifier: MIT

#include "mesh_frame.hpp"

#include "render/stopwatch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>
#include <memory>
#include <span>

namespace bench {

using lightmesh::ShortTest;

double seconds(const std::function<void()>& work) {
    const demo::Stopwatch watch;
    work();
    return watch.seconds();
}

double processor_seconds(const std::function<void()>& work) {
    const std::clock_t start = std::clock();
    work();
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

double least_seconds(int passes, const std::function<void()>& work) {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < passes; ++i)
        least = (std::min)(least, seconds(work));
    return least;
}

void print_head() {
#ifndef __OPTIMIZE__
    std::printf("This program was compiled without optimisation: its times mean nothing.\n\n");
#endif
    std::printf("| what | measured | to reach | reached | beside it |\n|---|--:|--:|---|---|\n");
}

void print_row(const std::string& what, double measured, std::optional<double> to_reach, bool at_least,
               const std::string& beside) {
    std::printf(measured < 1000.0 ? "| %s | %.3g | " : "| %s | %.0f | ", what.c_str(), measured);
    if (to_reach) {
        const bool reached = at_least ? measured >= *to_reach : measured <= *to_reach;
        std::printf("%s %.3g | %s", at_least ? ">=" : "<=", *to_reach, reached ? "yes" : "no");
    } else {
        std::printf("- | -");
    }
    std::printf(" | %s |\n", beside.c_str());
    std::fflush(stdout);
}

std::vector<lightmesh::Light> lights_of(const Workload& workload) {
    std::vector<lightmesh::Light> lights;
    for (const glm::vec3& position : workload.lights)
        lights.emplace_back(lightmesh::PointLight{.position = position});
    return lights;
}

lightmesh::Settings settings_of(const Workload& workload, ShortTest short_test) {
    return {.radius = workload.radius, .quality = 4.0f, .short_test = short_test};
}

Mesh make_mesh(const Workload& workload, ShortTest short_test) {
    return Mesh{workload.scene.intersector(), lights_of(workload), settings_of(workload, short_test)};
}

void ask(const Mesh& mesh, const ShadingPoints& points) {
    std::vector<float> values;
    for (std::size_t t = 0; t < points.tile_count(); ++t) {
        const Points tile = points.tile(t);
        values.resize(tile.size() * mesh.light_count());
        mesh.visibility(tile.positions, tile.normals, values);
    }
}

double difference(const Mesh& mesh, const Mesh& other, const Workload& workload, const ShadingPoints& points,
                  std::size_t tiles) {
    const ShadingPoints sample = points.sample(tiles);
    std::vector<float> values;
    std::vector<float> expected;
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t t = 0; t < sample.tile_count(); ++t) {
        const Points tile = sample.tile(t);
        values.resize(tile.size() * mesh.light_count());
        expected.resize(values.size());
        mesh.visibility(tile.positions, tile.normals, values);
        other.visibility(tile.positions, tile.normals, expected);
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

double error_of(const Mesh& mesh, const Workload& workload) {
    return difference(mesh, make_mesh(workload, ShortTest::exact), workload, workload.points, 40);
}

std::string error_text(double error) {
    std::array<char, 64> text;
    std::snprintf(text.data(), text.size(), "error %.3g %%", 100.0 * error);
    return text.data();
}

double hard_ns(const Workload& workload, const ShadingPoints& points) {
    const auto hard = make_hard_shadows(workload, "single");
    std::vector<float> values;
    const double time = least_seconds(3, [&] {
        for (std::size_t t = 0; t < points.tile_count(); ++t) {
            const Points tile = points.tile(t);
            values.resize(tile.size() * workload.lights.size());
            hard->find(tile, values);
        }
    });
    return 1e9 * time / static_cast<double>(points.size());
}

}  // namespace bench
