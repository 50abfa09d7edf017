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
    std::size_t differing = 0;
    double seconds_of_park[2] = {};  // Express, Linked
    double ns_of_park[2] = {};
    const auto row = [&](const Stage& stage, std::size_t lights, const Asked& asked,
                         const bench::ShadingPoints& at) {
        const Result r = compare(device, stage, lights, asked, at);
        const double pairs = static_cast<double>(r.points) * static_cast<double>(r.lights);
        std::printf("| %s | %zu | %s | %zu | %zu | %zu | %.1f | %.3f | %.4f |\n", stage.scene.name.c_str(),
                    lights, name_of(asked).c_str(), r.points, r.differing, r.missing,
                    static_cast<double>(r.bytes) / 1e6, 1e3 * r.seconds, 1e9 * r.seconds / pairs);
        std::fflush(stdout);
        differing += r.differing;
        return r;
    };
    const Stage park(demo::make_park(), width, height);
    const std::array both{express, linked};
    for (std::size_t i = 0; i < both.size(); ++i) {
        const Result r = row(park, 64, both[i], park.points);
        seconds_of_park[i] = r.seconds;
        ns_of_park[i] = 1e9 * r.seconds / static_cast<double>(r.points * r.lights);
    }
    for (const Asked& asked : {express_by_footprints, linked_by_footprints})
        row(park, 64, asked, park.points);
    const Stage rooms(demo::make_rooms(), width, height);
    const Stage spheres(demo::make_spheres(), width, height);
    for (const Stage* stage : {&rooms, &spheres})
        for (const Asked& asked : {express, linked, linked_by_footprints})
            row(*stage, 64, asked, stage->points);
    const std::size_t differing_of_scenes = differing;
    struct Many {
        std::size_t lights;
        double ns[2];  // a point and light
    };
    std::array many{Many{256, {}}, Many{1024, {}}};
    for (Many& m : many)
        for (std::size_t i = 0; i < both.size(); ++i) {
            const Result r =
                row(park, m.lights, both[i], park.points.part(park.points.size() / (m.lights / 32)));
            m.ns[i] = 1e9 * r.seconds / static_cast<double>(r.points * r.lights);
        }
    const bench::HardShadows hard = bench::hard_shadows(device, park.bvh, park.points);
    bench::targets::begin(device);
    std::printf(
        "| GLSL against the CPU, %s, all points of park, rooms, spheres: counts and bytes | 0 differ | "
        "%zu differ | %s |\n",
        device.name().c_str(), differing_of_scenes, differing_of_scenes == 0 ? "reached" : "missed");
    const std::string points = bench::targets::of_points("park", 64, park.points.size());
    bench::targets::at_most(points + "Express, ms", 1.0, 1e3 * seconds_of_park[0], 2);
    bench::targets::at_most(points + "Linked, ms", 1.4, 1e3 * seconds_of_park[1], 2);
    bench::targets::times_faster_than_hard("Express", 30.0, hard, seconds_of_park[0]);
    bench::targets::times_faster_than_hard("Linked", 30.0, hard, seconds_of_park[1]);
    bench::targets::traversal("park", hard);
    for (const Many& m : many)
        for (std::size_t i = 0; i < both.size(); ++i)
            bench::targets::at_most(
                std::to_string(m.lights) +
                    " lights, ns a point and light, no more than at 64: " + name_of(both[i]),
                ns_of_park[i], m.ns[i], 4);
    return differing == 0 && 1000 * hard.differing <= hard.traced;
}

}  // namespace

int main(int argc, char** argv) {
    return bench::run_on_device("lightmesh-gpu-benchmark", argc, argv, run);
}
