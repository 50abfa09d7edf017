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
    const std::span arguments(argv + 1, static_cast<std::size_t>(argc) - 1);
    for (std::size_t i = 0; i < arguments.size(); i += 2) {
        const std::string_view option = arguments[i];
        const std::string_view value = i + 1 < arguments.size() ? arguments[i + 1] : "";
        if (option == "--device" && !value.empty()) {
            options.device = value;
        } else if (option == "--gpu-rays" && (value == "queries" || value == "bvh")) {
            options.ray_queries = value == "queries";
        } else {
            std::fprintf(stderr, "usage: %s [--device NAME] [--gpu-rays queries|bvh]\n", name);
            return 2;
        }
    }
    try {
        const demo::ComputeDevice device(options);
        std::printf("%s, %s, rays %s\n\n", device.name().c_str(), device.driver().c_str(),
                    traversal_of(device).c_str());
        return run(device) ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", name, error.what());
        return 1;
    }
}

std::vector<demo::ComputeDevice> by_each_traversal(const demo::ComputeDevice& device) {
    std::vector<demo::ComputeDevice> devices{device};
    if (device.has_ray_queries())
        devices.push_back(device.opened_anew(false));
    return devices;
}

std::string traversal_of(const demo::ComputeDevice& device) {
    return device.has_ray_queries() ? "by ray queries" : "through a BVH";
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
    result.traversal = traversal_of(device);
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

std::vector<HardShadows> hard_shadows_by_each_traversal(const demo::ComputeDevice& device,
                                                        const demo::EmbreeScene& scene,
                                                        const ShadingPoints& points) {
    std::vector<HardShadows> found;
    for (const demo::ComputeDevice& one : by_each_traversal(device))
        found.push_back(hard_shadows(one, scene, points));
    std::ranges::sort(found, {}, &HardShadows::seconds);
    return found;
}

bool are_nearly_all_same(const Differing& differing) {
    return static_cast<double>(differing.count) <= most_differing * static_cast<double>(differing.all);
}

bool are_embrees(std::span<const HardShadows> shadows) {
    return std::ranges::all_of(shadows,
                               [](const HardShadows& one) { return are_nearly_all_same(one.error()); });
}

namespace {

/// Whether times mean something.
bool is_timed = true;

void print_row(const std::string& what, const Differing& differing, const std::string& reach,
               const std::string& got, const char* verdict) {
    std::printf("| %s | %zu of %zu | %s | %s | %s |\n", what.c_str(), differing.count, differing.all,
                reach.c_str(), got.c_str(), verdict);
    std::fflush(stdout);
}

/// With so many digits after the point, or two that are not 0.
std::string number(double value, int digits) {
    std::array<char, 64> text;
    const bool is_small = value > 0.0 && value < 10.0 * std::pow(10.0, -digits);
    std::snprintf(text.data(), text.size(), is_small ? "%.*g" : "%.*f", is_small ? 2 : digits, value);
    return text.data();
}

void print_figure(const std::string& what, const Differing& differing, const char* relation, double reach,
                  double got, int digits, bool is_reached) {
    if (reach > 0.0)
        print_row(what, differing, relation + number(reach, digits), number(got, digits),
                  !is_timed    ? "not timed"
                  : is_reached ? "reached"
                               : "missed");
    else
        print_row(what, differing, "-", number(got, digits), "");
}

}  // namespace

namespace targets {

void begin(const demo::ComputeDevice& device) {
    is_timed = !device.is_cpu();
    if (!is_timed)
        std::printf("\nA CPU plays the GPU: times mean nothing.\n");
    std::printf("\n| what | not the CPU's | to reach | measured | |\n|---|--:|--:|--:|---|\n");
}

void none_differ(const std::string& what, const Differing& differing) {
    print_row(what, differing, "0 differ", std::to_string(differing.count) + " differ",
              differing.count == 0 ? "reached" : "missed");
}

void few_differ(const std::string& what, const Differing& differing, double most) {
    const double share = static_cast<double>(differing.count) / static_cast<double>(differing.all);
    print_row(what, differing, "at most " + number(100.0 * most, 1) + " %", number(100.0 * share, 4) + " %",
              share <= most ? "reached" : "missed");
}

void at_most(const std::string& what, const Differing& differing, double reach, double got, int digits) {
    print_figure(what, differing, "at most ", reach, got, digits, got <= reach);
}

void at_least(const std::string& what, const Differing& differing, double reach, double got, int digits) {
    print_figure(what, differing, "at least ", reach, got, digits, got >= reach);
}

void times_faster_than_hard(const std::string& what, const Differing& differing, double reach,
                            const HardShadows& hard, double seconds) {
    const auto pairs = static_cast<double>(hard.pairs);
    const std::string row = "times faster than hard shadow rays on the same card: park, " + what;
    at_least(row + ", BVH2 at 3.4 G rays/s", differing, reach, pairs / rays_a_second_of_bvh2 / seconds, 2);
    at_least(row + ", the best traversal of the examples, " + hard.traversal, differing, 0.0,
             pairs / hard.rays_a_second() / seconds, 2);
}

void traversal(const std::string& scene, const HardShadows& hard) {
    at_least("shadow rays " + hard.traversal + ", checked against Embree, " + scene +
                 ": G rays/s, where a BVH2 has 3.4",
             hard.error(), 0.0, 1e-9 * hard.rays_a_second(), 2);
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
