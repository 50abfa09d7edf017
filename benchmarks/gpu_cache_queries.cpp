// SPDX-License-Identifier: MIT

// Lamp rows of visibility caches asked by shaders, held against the CPU bit by bit and timed:
// lightmesh-gpu-cache-benchmark [--device NAME]. On a CPU that plays a GPU the picture is small: there it is
// about the bits.

#include "gpu/cache_queries.hpp"
#include "gpu_benchmark.hpp"
#include "lamp_share.hpp"
#include "shading_points.hpp"

#include <lightmesh/lightmesh.hpp>

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace {

using lightmesh::SurfacePoint;
using Cache = lightmesh::VisibilityCache<demo::EmbreeIntersector>;

struct Result {
    bench::Differing wrong;  ///< of the values that take no rays from the point; with points that lack values
    double seconds = 0.0;    ///< of the device
    double ns = 0.0;         ///< a point and light
};

/// Fills a cache on the CPU, asks it there and on the device, and prints a row of the table.
Result row(const demo::ComputeDevice& device, const demo::Scene& scene, float lamp_radius, bool shaft_rows,
           std::size_t share = 1) {
    const demo::EmbreeScene bvh(scene);
    const bench::ShadingPoints seen =
        device.is_cpu() ? bench::ShadingPoints(bvh, 64, 48) : bench::ShadingPoints(bvh, 1920, 1440);
    const std::vector<SurfacePoint> points = bench::surface_points(seen.part(seen.size() / share));
    const demo::EmbreeIntersector tracer = bvh.intersector();
    const Cache cache(tracer, bench::sphere_lamps(scene, lamp_radius),
                      lightmesh::CacheSettings{.spacing = 0.25f * scene.radius, .shaft_rows = shaft_rows});
    const std::vector<float> expected = bench::ask_on_cpu(cache, points);

    demo::CacheQueries queries(device);
    const auto snapshot = cache.snapshot();
    const std::size_t bytes = queries.upload(snapshot);
    const auto answer = queries.ask(points, demo::trace_by(tracer), true, points.size());
    std::size_t differing = answer.points_without_rays;
    std::size_t lacking = 0;
    for (const lightmesh::CacheRequest& request : answer.requests)
        lacking += request.lacks_values ? 1u : 0u;
    std::size_t by_rays = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if (std::isnan(answer.values[i]))
            ++by_rays;
        else if (!bench::same_bits(expected[i], answer.values[i]))
            ++differing;
    }
    const auto values = static_cast<double>(expected.size());
    std::printf("| %s | %zu | %s | %zu | %zu | %zu | %.3f | %.2f | %.1f | %.2f | %.3f |\n",
                scene.name.c_str(), cache.light_count(), shaft_rows ? "yes" : "no", points.size(), differing,
                lacking, 100.0 * static_cast<double>(by_rays) / values,
                static_cast<double>(answer.rays) / static_cast<double>(points.size()),
                1e-6 * static_cast<double>(bytes), 1e3 * answer.seconds, 1e9 * answer.seconds / values);
    std::fflush(stdout);
    return {{differing + lacking, expected.size() - by_rays}, answer.seconds, 1e9 * answer.seconds / values};
}

bool run(const demo::ComputeDevice& device) {
    std::printf(
        "| scene | lights | shaft rows | points | values that differ from the CPU's | points that lack "
        "values | %% of "
        "values that take rays from the point | guard rays a point | MB uploaded | ms | ns a point and light "
        "|\n|---|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    bench::Differing wrong;
    const auto take = [&](const Result& result) {
        wrong.count += result.wrong.count;
        wrong.all += result.wrong.all;
        return result;
    };
    demo::Scene park = demo::make_park();
    Result of_park;
    for (const bool shaft_rows : {true, false}) {
        take(row(device, demo::make_spheres(), 6.0f, shaft_rows));
        take(row(device, demo::make_rooms(), 0.3f, shaft_rows));
        // It takes the CPU longest to fill.
        const Result found = take(row(device, park, 1.0f, shaft_rows, shaft_rows ? 1 : 4));
        if (shaft_rows)
            of_park = found;
    }
    const bench::Differing of_scenes = wrong;
    const demo::EmbreeScene bvh(park);
    const bench::ShadingPoints points =
        device.is_cpu() ? bench::ShadingPoints(bvh, 64, 48) : bench::ShadingPoints(bvh, 1920, 1440);
    const auto hard = bench::hard_shadows_by_each_traversal(device, bvh, points);
    struct Pair {
        std::size_t lights;
        Result found, of_64;  ///< at the same points
    };
    std::vector<Pair> of_many;
    const std::size_t small_share = device.is_cpu() ? 8 : 64;
    for (const auto& [lights, share] : {std::pair(std::size_t{256}, std::size_t{8}), {1024, small_share}}) {
        const auto with = [&, part = share](std::size_t count) {
            demo::spread_lights(park, count);
            return take(row(device, park, 1.0f, false, part));
        };
        of_many.push_back({lights, with(lights), with(64)});
    }
    bench::targets::begin(device);
    bench::targets::none_differ("GLSL against the CPU, " + device.name() +
                                    ", all points of park, rooms, spheres: bytes of caches",
                                of_scenes);
    bench::targets::at_most(bench::targets::of_points("park", 64, points.size()) +
                                "cache lamp rows (adaptive), ms",
                            of_park.wrong, 0.8, 1e3 * of_park.seconds, 2);
    bench::targets::times_faster_than_hard("cache lamp rows (adaptive)", of_park.wrong, 30.0, hard.front(),
                                           of_park.seconds);
    for (const Pair& pair : of_many)
        bench::targets::at_most("park, " + std::to_string(pair.lights) +
                                    " lights, ns a point and light, no more than at 64: cache lamp rows "
                                    "(adaptive), without shaft rows",
                                pair.found.wrong, pair.of_64.ns, pair.found.ns, 4);
    return wrong.count == 0 && bench::are_embrees(hard);
}

}  // namespace

int main(int argc, char** argv) {
    return bench::run_on_device("lightmesh-gpu-cache-benchmark", argc, argv, run);
}
