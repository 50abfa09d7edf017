// SPDX-License-Identifier: MIT

// The rows of "A first frame that pays", each with what it is to reach: one thread, 1920 x 1440 pixels, each
// frame by a new mesh.

#include "mesh_frame.hpp"
#include "workloads.hpp"

#include <lightmesh/lightmesh.hpp>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace {

using bench::Mesh;
using lightmesh::ShortTest;

std::string beside(const Mesh& mesh, const bench::Workload& workload, double frame) {
    const auto pixels = static_cast<double>(workload.points.size());
    std::vector<char> text(200);
    std::snprintf(text.data(), text.size(),
                  "%.3g s a frame, %.3g light points and %.3g long rays a pixel, %s", frame,
                  static_cast<double>(mesh.statistics().light_points) / pixels,
                  static_cast<double>(mesh.statistics().long_rays) / pixels,
                  bench::error_text(bench::error_of(mesh, workload)).c_str());
    return text.data();
}

void time_cold(const bench::Workload& workload, double hard, const std::string& name, ShortTest short_test,
               double to_reach) {
    const Mesh mesh = bench::make_mesh(workload, short_test);
    const double frame = bench::seconds([&] { bench::ask(mesh, workload.points); });
    bench::print_row(name + ", times faster than hard single rays",
                     hard * static_cast<double>(workload.points.size()) / (1e9 * frame), to_reach, true,
                     beside(mesh, workload, frame));
}

void time_first_frames() {
    for (const auto& [scene, linked, express] :
         {std::tuple("park", 6.0, 8.0), std::tuple("rooms", 10.0, 12.0)}) {
        const bench::Workload& workload = bench::workload(scene, 64);
        const double hard = bench::hard_ns(workload, workload.points.part(100000));
        time_cold(workload, hard, std::string("Linked cold, ") + scene, ShortTest::linked, linked);
        time_cold(workload, hard, std::string("Express cold, ") + scene, ShortTest::none, express);
    }
    // So small a radius that there are some 0.5 light points a pixel.
    bench::Workload fine = bench::workload("rooms", 64);
    fine.radius *= 0.35f;
    const double hard = bench::hard_ns(fine, fine.points.part(100000));
    time_cold(fine, hard, "Linked cold, rooms at 0.5 light points a pixel", ShortTest::linked, 3.0);
}

/// 64 lights of which, by their ranges, two reach a point.
void time_few_lights() {
    const bench::Workload& workload = bench::workload("rooms", 64);
    const bench::ShadingPoints some = workload.points.part(20000);
    const auto lights_with = [&](float range) {
        std::vector<lightmesh::Light> lights;
        for (const glm::vec3& position : workload.lights)
            lights.emplace_back(lightmesh::PointLight{.position = position, .range = range});
        return lights;
    };
    const float step = workload.radius / 4.0f;
    const auto in_reach = [&](float range) {
        const lightmesh::ShadowRays rays(lights_with(range), step);
        double sum = 0.0;
        for (std::size_t t = 0; t < some.tile_count(); ++t) {
            const bench::Points tile = some.tile(t);
            for (std::size_t i = 0; i < tile.size(); ++i)
                for (std::size_t l = 0; l < rays.size(); ++l)
                    sum += rays.can_light(l, tile.positions[i], tile.normals[i]) ? 1.0 : 0.0;
        }
        return sum / static_cast<double>(some.size());
    };
    float low = 0.0f;
    float high = 1000.0f;
    for (int i = 0; i < 30; ++i)
        (in_reach((low + high) / 2) < 2.0 ? low : high) = (low + high) / 2;
    const std::vector<lightmesh::Light> lights = lights_with(high);

    const lightmesh::ShadowRays rays(lights, step);
    const demo::EmbreeIntersector tracer = workload.scene.intersector();
    std::uint64_t open = 0;
    const auto trace_all = [&] {
        for (std::size_t t = 0; t < workload.points.tile_count(); ++t) {
            const bench::Points tile = workload.points.tile(t);
            for (std::size_t i = 0; i < tile.size(); ++i)
                rays.for_each(tile.positions[i], tile.normals[i],
                              [&](std::size_t, const lightmesh::Segment& segment) {
                                  open += tracer.occluded(segment) ? 0u : 1u;
                              });
        }
    };
    const double plain = bench::least_seconds(2, trace_all);
    const Mesh mesh{workload.scene.intersector(), lights, bench::settings_of(workload, ShortTest::linked)};
    const double cold = bench::seconds([&] { bench::ask(mesh, workload.points); });
    const double warm = bench::least_seconds(2, [&] { bench::ask(mesh, workload.points); });
    const Mesh exact{workload.scene.intersector(), lights, bench::settings_of(workload, ShortTest::exact)};
    const std::string note =
        bench::error_text(bench::difference(mesh, exact, workload, workload.points, 40)) + ", " +
        std::to_string(in_reach(high)) + " lights reach a point, " +
        std::to_string(1e9 * plain / static_cast<double>(workload.points.size())) + " ns a point by rays";
    bench::print_row("64 lights with ranges, 2 reach a point, rooms, Linked cold over plain rays",
                     plain / cold, 0.7, true, note);
    bench::print_row("the same warm", plain / warm, 0.9, true, note);
}

void weigh_errors() {
    for (const auto& [scene, to_reach] : {std::pair("rooms", 0.0005), std::pair("park", 0.005)}) {
        const bench::Workload& workload = bench::workload(scene, 64);
        for (const auto& [short_test, name] :
             {std::pair(ShortTest::none, "Express"), std::pair(ShortTest::linked, "Linked")}) {
            lightmesh::Settings all = bench::settings_of(workload, short_test);
            all.adaptive_long_tests = false;
            const Mesh traced{workload.scene.intersector(), bench::lights_of(workload), all};
            const Mesh adaptive = bench::make_mesh(workload, short_test);
            const double added = bench::difference(adaptive, traced, workload, workload.points, 200);
            bench::print_row(std::string("mean absolute S that adaptive long tests add, ") + name + ", " +
                                 scene,
                             added, to_reach, false,
                             std::to_string(adaptive.statistics().long_rays) + " long rays of " +
                                 std::to_string(traced.statistics().long_rays));
        }
    }
}

}  // namespace

int main() {
    std::printf("A first frame that pays; kernels: %s\n\n", lightmesh::kernel_name());
    bench::print_head();
    time_first_frames();
    time_few_lights();
    weigh_errors();
}
