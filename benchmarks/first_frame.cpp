// SPDX-License-Identifier: MIT

// The rows of "A first frame that pays", each with what it is to reach: one thread, 1920 x 1440 pixels, each
// frame by a new mesh.

#include "mesh_frame.hpp"
#include "render/text_table.hpp"
#include "render/view.hpp"
#include "workloads.hpp"

#include <lightmesh/lightmesh.hpp>

#include <glm/geometric.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
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

/// A picture's points with the footprints of its pixels.
std::vector<lightmesh::SurfacePoint> with_footprints(const bench::Workload& workload,
                                                     const bench::Points& points) {
    const demo::Camera& camera = workload.scene.scene().camera;
    const float pixel_angle = demo::View(camera, bench::picture_width, bench::picture_height).pixel_angle();
    std::vector<lightmesh::SurfacePoint> all(points.size());
    for (std::size_t i = 0; i < all.size(); ++i)
        all[i] = {.position = points.positions[i],
                  .normal = points.normals[i],
                  .footprint = pixel_angle * glm::distance(points.positions[i], camera.eye)};
    return all;
}

/// A mesh's values of a tile, by levels or without.
template <class AnyMesh>
void ask_tile(const AnyMesh& mesh, const bench::Workload& workload, const bench::Points& tile,
              std::vector<float>& values) {
    values.resize(tile.size() * mesh.light_count());
    mesh.visibility(with_footprints(workload, tile), values);
}

/// Mean absolute difference of S between two meshes with the same lights, at points and lights that face each
/// other, with footprints.
double difference_of_levels(const Mesh& mesh, const Mesh& other, const bench::Workload& workload) {
    const bench::ShadingPoints sample = workload.points.sample(100);
    std::vector<float> values;
    std::vector<float> expected;
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t t = 0; t < sample.tile_count(); ++t) {
        const bench::Points tile = sample.tile(t);
        ask_tile(mesh, workload, tile, values);
        ask_tile(other, workload, tile, expected);
        for (std::size_t i = 0; i < values.size(); ++i) {
            const std::size_t point = i / mesh.light_count();
            if (!workload.faces(i % mesh.light_count(), tile.positions[point], tile.normals[point]))
                continue;
            sum += std::abs(static_cast<double>(values[i]) - static_cast<double>(expected[i]));
            count += 1.0;
        }
    }
    return sum / count;
}

Mesh make_mesh_with(const bench::Workload& workload, ShortTest short_test, float footprint_scale) {
    lightmesh::Settings settings = bench::settings_of(workload, short_test);
    settings.footprint_scale = footprint_scale;
    return Mesh{workload.scene.intersector(), bench::lights_of(workload), settings};
}

/// The light points that a whole picture needs without levels: those of a scene without surfaces.
double light_points_without_levels(const bench::Workload& workload) {
    struct Nothing {
        bool occluded(const lightmesh::Segment&) const { return false; }
    };
    lightmesh::Settings settings = bench::settings_of(workload, ShortTest::none);
    settings.footprint_scale = 0.0f;
    const lightmesh::LightMesh mesh{Nothing{}, bench::lights_of(workload), settings};
    std::vector<float> values;
    for (std::size_t t = 0; t < workload.points.tile_count(); ++t)
        ask_tile(mesh, workload, workload.points.tile(t), values);
    return static_cast<double>(mesh.statistics().light_points) / static_cast<double>(workload.points.size());
}

/// A street at true scale under its own 64 lamps, with so small a radius that without levels there are 14
/// light points a pixel, and with the scene's own.
void time_street() {
    bench::Workload street = bench::workload("street", 64);
    street.lights.clear();
    for (const demo::SceneLight& lamp : street.scene.scene().lights)
        street.lights.push_back(std::get<lightmesh::PointLight>(lamp.shape).position);
    const double hard = bench::hard_ns(street, street.points.part(100000));
    const auto pixels = static_cast<double>(street.points.size());
    constexpr float usual_scale = lightmesh::Settings{}.footprint_scale;
    const std::pair<float, std::vector<float>> cases[] = {{0.12f, {usual_scale, 2.0f * usual_scale}},
                                                          {street.radius, {usual_scale}}};
    for (const auto& [radius, scales] : cases) {
        street.radius = radius;
        const Mesh exact = make_mesh_with(street, ShortTest::exact, 0.0f);
        const Mesh without = make_mesh_with(street, ShortTest::linked, 0.0f);
        const double error_without = difference_of_levels(without, exact, street);
        const double light_points_without = light_points_without_levels(street);
        for (const float scale : scales) {
            const Mesh mesh = make_mesh_with(street, ShortTest::linked, scale);
            std::vector<float> values;
            const double frame = bench::seconds([&] {
                for (std::size_t t = 0; t < street.points.tile_count(); ++t)
                    ask_tile(mesh, street, street.points.tile(t), values);
            });
            const lightmesh::MeshStatistics held = mesh.statistics();
            std::vector<char> text(400);
            std::snprintf(text.data(), text.size(),
                          "%.3g s a frame, %.3g light points and %.3g long rays a pixel, %.3g light points "
                          "without levels, %s, without levels %s",
                          frame, static_cast<double>(held.light_points) / pixels,
                          static_cast<double>(held.long_rays) / pixels, light_points_without,
                          bench::error_text(difference_of_levels(mesh, exact, street)).c_str(),
                          bench::error_text(error_without).c_str());
            bench::print_row("a street, r = " + demo::fixed(static_cast<double>(radius), 2) +
                                 " m, with footprint, scale " + demo::fixed(static_cast<double>(scale), 1) +
                                 ", Linked cold, times faster than hard single rays",
                             hard * pixels / (1e9 * frame), 1.0, true, text.data());
        }
    }
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
        const Mesh levels =
            make_mesh_with(workload, ShortTest::linked, lightmesh::Settings{}.footprint_scale);
        const Mesh one_level = make_mesh_with(workload, ShortTest::linked, 0.0f);
        const double of_levels = difference_of_levels(levels, one_level, workload);
        bench::print_row(std::string("mean absolute S that levels add, Linked, ") + scene, of_levels,
                         to_reach, false,
                         std::to_string(levels.statistics().light_points) + " light points of " +
                             std::to_string(one_level.statistics().light_points));
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
    time_street();
    time_few_lights();
    weigh_errors();
}
