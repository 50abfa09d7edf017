// SPDX-License-Identifier: MIT

// Lamp rows of visibility caches asked by shaders, held against the CPU bit by bit and timed:
// lightmesh-gpu-cache-benchmark [--device NAME]. On a CPU that plays a GPU the picture is small: there it is
// about the bits.

#include "gpu/cache_queries.hpp"
#include "lamp_share.hpp"
#include "shading_points.hpp"

#include <lightmesh/lightmesh.hpp>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace {

using lightmesh::SurfacePoint;
using Cache = lightmesh::VisibilityCache<demo::EmbreeIntersector>;

std::vector<SurfacePoint> points_of(const demo::EmbreeScene& bvh, int width, int height) {
    const bench::ShadingPoints picture(bvh, width, height);
    std::vector<SurfacePoint> points;
    for (std::size_t t = 0; t < picture.tile_count(); ++t)
        for (std::size_t i = 0; i < picture.tile(t).size(); ++i)
            points.push_back(
                {.position = picture.tile(t).positions[i], .normal = picture.tile(t).normals[i]});
    return points;
}

/// Fills a cache on the CPU, asks it there and on the device, and prints a row of the table. Returns how many
/// values differ.
std::size_t row(const demo::ComputeDevice& device, const demo::Scene& scene, float lamp_radius) {
    const demo::EmbreeScene bvh(scene);
    const std::vector<SurfacePoint> points =
        device.is_cpu() ? points_of(bvh, 64, 48) : points_of(bvh, 1920, 1440);
    const demo::EmbreeIntersector tracer = bvh.intersector();
    const Cache cache(tracer, bench::sphere_lamps(scene, lamp_radius),
                      lightmesh::CacheSettings{.spacing = 0.25f * scene.radius});
    constexpr std::size_t block = 1024;
    std::vector<float> expected(points.size() * cache.light_count());
    tbb::parallel_for(std::size_t{0}, (points.size() + block - 1) / block, [&](std::size_t b) {
        const std::size_t first = b * block;
        const std::size_t size = (std::min)(block, points.size() - first);
        cache.visibility(
            std::span(points).subspan(first, size),
            std::span(expected).subspan(first * cache.light_count(), size * cache.light_count()));
    });

    demo::CacheQueries queries(device);
    const auto snapshot = cache.snapshot();
    const std::size_t bytes = queries.upload(snapshot);
    const auto trace = [&](std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) {
        tbb::parallel_for(std::size_t{0}, segments.size(),
                          [&](std::size_t i) { hit[i] = tracer.occluded(segments[i]) ? 1 : 0; });
    };
    const auto answer = queries.ask(points, trace, device.is_cpu() ? 1 : 5, points.size());
    std::size_t differing = answer.points_without_rays;
    std::size_t lacking = 0;
    for (const lightmesh::CacheRequest& request : answer.requests)
        lacking += request.lacks_values ? 1u : 0u;
    std::size_t by_rays = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        if (std::isnan(answer.values[i]))
            ++by_rays;
        else if (std::bit_cast<std::uint32_t>(expected[i]) != std::bit_cast<std::uint32_t>(answer.values[i]))
            ++differing;
    }
    const auto values = static_cast<double>(expected.size());
    std::printf("| %s | %zu | %zu | %zu | %zu | %.3f | %.2f | %.1f | %.2f | %.3f |\n", scene.name.c_str(),
                cache.light_count(), points.size(), differing, lacking,
                100.0 * static_cast<double>(by_rays) / values,
                static_cast<double>(answer.rays) / static_cast<double>(points.size()),
                1e-6 * static_cast<double>(bytes), 1e3 * answer.seconds, 1e9 * answer.seconds / values);
    std::fflush(stdout);
    return differing + lacking;
}

bool run(const demo::ComputeOptions& options) {
    const demo::ComputeDevice device(options);
    std::printf("%s, %s\n\n", device.name().c_str(), device.driver().c_str());
    std::printf(
        "| scene | lights | points | values that differ from the CPU's | points that lack values | %% of "
        "values that take rays from the point | guard rays a point | MB uploaded | ms | ns a point and light "
        "|\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    std::size_t wrong = 0;
    wrong += row(device, demo::make_spheres(), 6.0f);
    wrong += row(device, demo::make_rooms(), 0.3f);
    demo::Scene park = demo::make_park();
    wrong += row(device, park, 1.0f);
    demo::spread_lights(park, 256);
    wrong += row(device, park, 1.0f);
    return wrong == 0;
}

}  // namespace

int main(int argc, char** argv) {
    demo::ComputeOptions options;
    if (argc == 3 && std::string_view(argv[1]) == "--device") {
        options.device = argv[2];
    } else if (argc != 1) {
        std::fprintf(stderr, "usage: lightmesh-gpu-cache-benchmark [--device NAME]\n");
        return 2;
    }
    try {
        return run(options) ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "lightmesh-gpu-cache-benchmark: %s\n", error.what());
        return 1;
    }
}
