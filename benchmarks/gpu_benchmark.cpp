// SPDX-License-Identifier: MIT
#include "gpu_benchmark.hpp"

#include "gpu/gpu_rays.hpp"
#include "gpu/gpu_scene.hpp"
#include "render/illumination.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bench {

int run_on_device(const char* name, int argc, char** argv,
                  const std::function<bool(const demo::ComputeDevice&)>& run) {
    demo::ComputeOptions options;
    if (argc == 3 && std::string_view(argv[1]) == "--device") {
        options.device = argv[2];
    } else if (argc != 1) {
        std::fprintf(stderr, "usage: %s [--device NAME]\n", name);
        return 2;
    }
    try {
        const demo::ComputeDevice device(options);
        std::printf("%s, %s\n\n", device.name().c_str(), device.driver().c_str());
        return run(device) ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", name, error.what());
        return 1;
    }
}

HardShadows hard_shadows(const demo::ComputeDevice& device, const demo::EmbreeScene& scene,
                         const ShadingPoints& points) {
    const std::size_t most = device.is_cpu() ? 100'000 : std::size_t{1} << 24;
    HardShadows result;
    std::vector<lightmesh::Segment> rays;
    for (std::size_t t = 0; t < points.tile_count(); ++t) {
        const Points tile = points.tile(t);
        for (const demo::SceneLight& light : scene.scene().lights)
            for (std::size_t i = 0; i < tile.size(); ++i) {
                const lightmesh::Segment ray = demo::shadow_segment(light, tile.positions[i], tile.normals[i],
                                                                    scene.offset(), scene.far_away());
                if (glm::dot(ray.target - ray.origin, tile.normals[i]) <= 0.0f)
                    continue;
                ++result.pairs;
                if (rays.size() < most)
                    rays.push_back(ray);
            }
    }
    const demo::GpuScene copy(device, scene);
    demo::GpuRays tracer(device, copy);
    tracer.begin_timing();
    const std::vector<float> found = tracer.let_through(rays);
    result.seconds = tracer.seconds();
    result.traced = rays.size();
    std::vector<float> expected(rays.size());
    const demo::EmbreeIntersector embree = scene.intersector();
    constexpr std::size_t block = 4096;
    tbb::parallel_for(std::size_t{0}, (rays.size() + block - 1) / block, [&](std::size_t b) {
        std::vector<std::uint8_t> hit(block);
        const std::size_t begin = b * block;
        const std::size_t size = (std::min)(block, rays.size() - begin);
        embree.let_through(std::span(std::as_const(rays)).subspan(begin, size), std::span(hit).first(size),
                           std::span(expected).subspan(begin, size));
    });
    for (std::size_t i = 0; i < rays.size(); ++i)
        result.differing += std::abs(found[i] - expected[i]) > 1e-3f ? 1u : 0u;
    return result;
}

namespace {

/// Whether times mean something.
bool is_timed = true;

void print_row(const std::string& what, const char* relation, double reach, double got, int digits,
               bool is_reached) {
    if (reach > 0.0)
        std::printf("| %s | %s %.*f | %.*f | %s |\n", what.c_str(), relation, digits, reach, digits, got,
                    !is_timed    ? "not timed"
                    : is_reached ? "reached"
                                 : "missed");
    else
        std::printf("| %s | - | %.*f | |\n", what.c_str(), digits, got);
    std::fflush(stdout);
}

}  // namespace

namespace targets {

void begin(const demo::ComputeDevice& device) {
    is_timed = !device.is_cpu();
    if (!is_timed)
        std::printf("\nA CPU plays the GPU: times mean nothing.\n");
    std::printf("\n| what | to reach | measured | |\n|---|--:|--:|---|\n");
}

void at_most(const std::string& what, double reach, double got, int digits) {
    print_row(what, "at most", reach, got, digits, got <= reach);
}

void at_least(const std::string& what, double reach, double got, int digits) {
    print_row(what, "at least", reach, got, digits, got >= reach);
}

void times_faster_than_hard(const std::string& what, double reach, const HardShadows& hard, double seconds) {
    const auto pairs = static_cast<double>(hard.pairs);
    at_least("times faster than hard shadow rays on the same card: " + what + ", BVH2 at 3.4 G rays/s", reach,
             pairs / rays_a_second_of_bvh2 / seconds, 2);
    at_least("times faster than hard shadow rays on the same card: " + what +
                 ", the best traversal of the examples",
             0.0, pairs / hard.rays_a_second() / seconds, 2);
}

void traversal(const std::string& scene, const HardShadows& hard) {
    const std::string what = "the best traversal of the examples, checked against Embree, " + scene + ": ";
    at_least(what + "G rays/s, where a BVH2 has 3.4", 0.0, 1e-9 * hard.rays_a_second(), 2);
    at_most(what + "of " + std::to_string(hard.traced) + " rays those that are not Embree's", 0.0,
            static_cast<double>(hard.differing), 0);
}

std::string of_points(const std::string& scene, std::size_t lights, std::size_t points) {
    std::array<char, 16> millions;
    std::snprintf(millions.data(), millions.size(), "%.2g", 1e-6 * static_cast<double>(points));
    return scene + ", " + std::to_string(lights) + " lights, " + millions.data() + " M points: ";
}

}  // namespace targets

std::vector<lightmesh::SurfacePoint> surface_points(const ShadingPoints& points) {
    std::vector<lightmesh::SurfacePoint> all;
    all.reserve(points.size());
    for (std::size_t t = 0; t < points.tile_count(); ++t) {
        const Points tile = points.tile(t);
        for (std::size_t i = 0; i < tile.size(); ++i)
            all.push_back({.position = tile.positions[i], .normal = tile.normals[i]});
    }
    return all;
}

}  // namespace bench
