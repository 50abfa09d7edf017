// SPDX-License-Identifier: MIT

// Light meshes asked by shaders, held against the CPU bit by bit and timed: lightmesh-gpu-benchmark
// [--device NAME]. On a CPU that plays a GPU the picture is small: there it is about the bits.

#include "gpu/mesh_queries.hpp"
#include "gpu_benchmark.hpp"
#include "render/view.hpp"
#include "shading_points.hpp"

#include <lightmesh/lightmesh.hpp>

#include <glm/geometric.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <utility>
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
        : scene(std::move(made)), bvh(scene), points(bvh, width, height),
          pixel_angle(demo::View(scene.camera, width, height).pixel_angle()) {}
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
    float pixel_angle;
};

/// Short tests, and whether points have the footprints of their pixels.
struct Asked {
    ShortTest short_test;
    bool has_footprints;
};
constexpr Asked express{ShortTest::none, false};
constexpr Asked linked{ShortTest::linked, false};
constexpr Asked express_by_footprints{ShortTest::none, true};
constexpr Asked linked_by_footprints{ShortTest::linked, true};

std::string name_of(const Asked& asked) {
    return std::string(asked.short_test == ShortTest::none ? "Express" : "Linked") +
           (asked.has_footprints ? ", footprints" : "");
}

struct Result {
    std::size_t points = 0;
    std::size_t lights = 0;
    std::size_t differing = 0;  ///< values that are not the CPU's, bit by bit
    std::size_t missing = 0;
    std::size_t bytes = 0;  ///< that were uploaded
    double seconds = 0.0;   ///< of the device, for all points

    bench::Differing error() const { return {differing, points * lights}; }
    /// A point and light.
    double ns() const { return 1e9 * seconds / static_cast<double>(points * lights); }
};

/// Fills a mesh on the CPU, and asks it there and on the device.
Result compare(const demo::ComputeDevice& device, const Stage& stage, std::size_t light_count,
               const Asked& asked, const bench::ShadingPoints& at) {
    std::vector<SurfacePoint> points = bench::surface_points(at);
    if (asked.has_footprints)
        for (SurfacePoint& point : points)
            point.footprint = stage.pixel_angle * glm::distance(point.position, stage.scene.camera.eye);
    const SingleRays tracer{stage.bvh.intersector()};
    const Mesh mesh(tracer, stage.lights(light_count),
                    {.radius = stage.scene.radius, .quality = 4.0f, .short_test = asked.short_test});
    Result result;
    result.points = points.size();
    result.lights = light_count;
    const std::vector<float> expected = bench::ask_on_cpu(mesh, points);

    // Seeds take up to 20 rays and one for each of up to 180 neighbours, and a point without neighbours one
    // for each light; on each of two levels.
    const std::uint32_t rays_of_level = 200 + static_cast<std::uint32_t>(light_count);
    demo::MeshQueries queries(device, 65536, asked.has_footprints ? 2 * rays_of_level : rays_of_level);
    result.bytes = queries.upload(mesh.snapshot());
    const auto answer = queries.ask(points, demo::trace_by(tracer), true);
    result.seconds = answer.seconds;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        result.differing += bench::same_bits(expected[i], answer.values[i]) ? 0u : 1u;
        result.missing += std::isnan(answer.values[i]) ? 1u : 0u;
    }
    return result;
}

bool run(const demo::ComputeDevice& device) {
    const int width = device.is_cpu() ? 160 : 1920;
    const int height = device.is_cpu() ? 112 : 1440;
    std::printf("pictures of %d x %d\n\n", width, height);
    std::printf("| scene | lights | short test | points | values that differ from the CPU's | missing | MB "
                "uploaded | "
                "ms | ns a point and light |\n|---|--:|---|--:|--:|--:|--:|--:|--:|\n");
    bench::Differing differing;
    const auto row = [&](const Stage& stage, std::size_t lights, const Asked& asked,
                         const bench::ShadingPoints& at) {
        const Result r = compare(device, stage, lights, asked, at);
        std::printf("| %s | %zu | %s | %zu | %zu | %zu | %.1f | %.3f | %.4f |\n", stage.scene.name.c_str(),
                    lights, name_of(asked).c_str(), r.points, r.differing, r.missing,
                    static_cast<double>(r.bytes) / 1e6, 1e3 * r.seconds, r.ns());
        std::fflush(stdout);
        differing.count += r.differing;
        differing.all += r.points * r.lights;
        return r;
    };
    const Stage park(demo::make_park(), width, height);
    const std::array both{express, linked};
    std::array<Result, both.size()> of_park;
    for (std::size_t i = 0; i < both.size(); ++i)
        of_park[i] = row(park, 64, both[i], park.points);
    for (const Asked& asked : {express_by_footprints, linked_by_footprints})
        row(park, 64, asked, park.points);
    const Stage rooms(demo::make_rooms(), width, height);
    const Stage spheres(demo::make_spheres(), width, height);
    for (const Stage* stage : {&rooms, &spheres})
        for (const Asked& asked : {express, linked, linked_by_footprints})
            row(*stage, 64, asked, stage->points);
    const bench::Differing of_scenes = differing;
    struct Pair {
        std::string asked;
        Result found, of_64;  ///< at the same points
    };
    std::vector<Pair> of_many;
    for (const std::size_t lights : {256, 1024}) {
        const auto part = park.points.part(park.points.size() / (lights / 32));
        for (const Asked& asked : both)
            of_many.push_back({name_of(asked), row(park, lights, asked, part), row(park, 64, asked, part)});
    }
    const auto hard = bench::hard_shadows_by_each_traversal(device, park.bvh, park.points);
    bench::targets::begin(device);
    bench::targets::none_differ("GLSL against the CPU, " + device.name() +
                                    ", all points of park, rooms, spheres: counts of light meshes",
                                of_scenes);
    const std::string points = bench::targets::of_points("park", 64, park.points.size());
    const std::array reach{1.0, 1.4};
    for (std::size_t i = 0; i < both.size(); ++i)
        bench::targets::at_most(points + name_of(both[i]) + ", ms", of_park[i].error(), reach[i],
                                1e3 * of_park[i].seconds, 2);
    for (std::size_t i = 0; i < both.size(); ++i)
        bench::targets::times_faster_than_hard(name_of(both[i]), of_park[i].error(), 30.0, hard.front(),
                                               of_park[i].seconds);
    for (const bench::HardShadows& rays : hard)
        bench::targets::traversal("park", rays);
    for (const Pair& pair : of_many)
        bench::targets::at_most("park, " + std::to_string(pair.found.lights) +
                                    " lights, ns a point and light, no more than at 64: " + pair.asked,
                                pair.found.error(), pair.of_64.ns(), pair.found.ns(), 4);
    return differing.count == 0 && bench::are_embrees(hard);
}

}  // namespace

int main(int argc, char** argv) {
    return bench::run_on_device("lightmesh-gpu-benchmark", argc, argv, run);
}
