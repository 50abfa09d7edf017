// SPDX-License-Identifier: MIT

// Light meshes asked by shaders, held against the CPU bit by bit and timed: lightmesh-gpu-benchmark
// [--device NAME]. On a CPU that plays a GPU the picture is small: there it is about the bits.

#include "gpu/mesh_queries.hpp"
#include "shading_points.hpp"

#include <lightmesh/lightmesh.hpp>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace {

using lightmesh::ShortTest;
using lightmesh::SurfacePoint;

/// Ray by ray: packets may see the edges of triangles otherwise, and then seeds are not the same.
struct SingleRays {
    demo::EmbreeIntersector embree;

    bool occluded(const lightmesh::Segment& segment) const { return embree.occluded(segment); }
};
using Mesh = lightmesh::LightMesh<SingleRays>;

/// A built-in scene and what is seen of it.
struct Stage {
    Stage(demo::Scene made, int width, int height)
        : scene(std::move(made)), bvh(scene), points(bvh, width, height) {}
    Stage(const Stage&) = delete;

    std::vector<lightmesh::Light> lights(std::size_t count) const {
        demo::Scene lit = scene;
        demo::spread_lights(lit, count);
        std::vector<lightmesh::Light> lights;
        for (const demo::SceneLight& light : lit.lights)
            lights.push_back(light.shape);
        return lights;
    }

    demo::Scene scene;
    demo::EmbreeScene bvh;
    bench::ShadingPoints points;
};

std::vector<SurfacePoint> all_of(const bench::ShadingPoints& points) {
    std::vector<SurfacePoint> all;
    for (std::size_t t = 0; t < points.tile_count(); ++t)
        for (std::size_t i = 0; i < points.tile(t).size(); ++i)
            all.push_back({.position = points.tile(t).positions[i], .normal = points.tile(t).normals[i]});
    return all;
}

struct Result {
    std::size_t points = 0;
    std::size_t lights = 0;
    std::size_t differing = 0;  ///< values that are not the CPU's, bit by bit
    std::size_t missing = 0;
    std::size_t bytes = 0;  ///< that were uploaded
    double seconds = 0.0;   ///< of the device, for all points
};

/// Fills a mesh on the CPU, and asks it there and on the device.
Result compare(const demo::ComputeDevice& device, const Stage& stage, std::size_t light_count,
               ShortTest short_test, const bench::ShadingPoints& at) {
    const std::vector<SurfacePoint> points = all_of(at);
    const SingleRays tracer{stage.bvh.intersector()};
    const Mesh mesh(tracer, stage.lights(light_count),
                    {.radius = stage.scene.radius, .quality = 4.0f, .short_test = short_test});
    Result result;
    result.points = points.size();
    result.lights = light_count;
    constexpr std::size_t block = 4096;
    const std::size_t blocks = (points.size() + block - 1) / block;
    std::vector<float> expected(points.size() * light_count);
    tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
        const std::size_t first = b * block;
        const std::size_t size = (std::min)(block, points.size() - first);
        mesh.visibility(std::span(points).subspan(first, size),
                        std::span(expected).subspan(first * light_count, size * light_count));
    });

    // Seeds take up to 20 rays, and a point without neighbours one for each light.
    demo::MeshQueries queries(device, 65536, 24 + static_cast<std::uint32_t>(light_count));
    result.bytes = queries.upload(mesh.snapshot());
    const auto trace = [&](std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) {
        tbb::parallel_for(std::size_t{0}, segments.size(),
                          [&](std::size_t i) { hit[i] = tracer.occluded(segments[i]) ? 1 : 0; });
    };
    const auto answer = queries.ask(points, trace, device.is_cpu() ? 1 : 5);
    result.seconds = answer.seconds;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        result.differing +=
            std::bit_cast<std::uint32_t>(expected[i]) != std::bit_cast<std::uint32_t>(answer.values[i]) ? 1u
                                                                                                        : 0u;
        result.missing += std::isnan(answer.values[i]) ? 1u : 0u;
    }
    return result;
}

const char* name_of(ShortTest short_test) {
    return short_test == ShortTest::none ? "Express" : "Linked";
}

void run(const demo::ComputeOptions& options) {
    const demo::ComputeDevice device(options);
    const int width = device.is_cpu() ? 160 : 1920;
    const int height = device.is_cpu() ? 112 : 1440;
    std::printf("%s, %s; pictures of %d x %d\n\n", device.name().c_str(), device.driver().c_str(), width,
                height);
    std::printf("| scene | lights | short test | points | values that differ from the CPU's | missing | MB "
                "uploaded | "
                "ms | ns a point and light |\n|---|--:|---|--:|--:|--:|--:|--:|--:|\n");
    std::size_t differing = 0;
    const auto row = [&](const Stage& stage, std::size_t lights, ShortTest short_test,
                         const bench::ShadingPoints& at) {
        const Result r = compare(device, stage, lights, short_test, at);
        const double pairs = static_cast<double>(r.points) * static_cast<double>(r.lights);
        std::printf("| %s | %zu | %s | %zu | %zu | %zu | %.1f | %.3f | %.4f |\n", stage.scene.name.c_str(),
                    lights, name_of(short_test), r.points, r.differing, r.missing,
                    static_cast<double>(r.bytes) / 1e6, 1e3 * r.seconds, 1e9 * r.seconds / pairs);
        std::fflush(stdout);
        differing += r.differing;
    };
    const Stage park(demo::make_park(), width, height);
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked})
        row(park, 64, short_test, park.points);
    const Stage rooms(demo::make_rooms(), width, height);
    const Stage spheres(demo::make_spheres(), width, height);
    for (const Stage* stage : {&rooms, &spheres})
        for (const ShortTest short_test : {ShortTest::none, ShortTest::linked})
            row(*stage, 64, short_test, stage->points);
    std::printf("\n| GLSL against the CPU, %s, all points of park, rooms, spheres: counts and bytes | %zu "
                "differ |\n\n",
                device.name().c_str(), differing);
    for (const auto& [lights, share] : {std::pair<std::size_t, std::size_t>{256, 8}, {1024, 32}})
        for (const ShortTest short_test : {ShortTest::none, ShortTest::linked})
            row(park, lights, short_test, park.points.part(park.points.size() / share));
}

}  // namespace

int main(int argc, char** argv) {
    demo::ComputeOptions options;
    if (argc == 3 && std::string_view(argv[1]) == "--device") {
        options.device = argv[2];
    } else if (argc != 1) {
        std::fprintf(stderr, "usage: lightmesh-gpu-benchmark [--device NAME]\n");
        return 2;
    }
    try {
        run(options);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "lightmesh-gpu-benchmark: %s\n", error.what());
        return 1;
    }
    return 0;
}
