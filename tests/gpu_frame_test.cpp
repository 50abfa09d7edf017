// SPDX-License-Identifier: MIT
#include "each_traversal.hpp"
#include "gpu/cache_fill.hpp"
#include "gpu/compute.hpp"
#include "gpu/gpu_rays.hpp"
#include "gpu/gpu_renderer.hpp"
#include "gpu/gpu_scene.hpp"
#include "gpu/lamp_shares.hpp"
#include "gpu/listed_words.hpp"
#include "gpu/segment_rays.hpp"
#include "gpu/uploaded.hpp"
#include "gpu/wide_bvh.hpp"
#include "image/image.hpp"
#include "random_scene.hpp"
#include "render/embree_scene.hpp"
#include "render/renderer.hpp"
#include "render/scene_cache.hpp"
#include "render/visibility.hpp"
#include "run_command.hpp"
#include "scene/animation.hpp"
#include "scene/boxes.hpp"
#include "scene/film.hpp"
#include "scene/scene.hpp"
#include "seen_points.hpp"
#include "temporary_folder.hpp"
#include "watched_device.hpp"

#include <lightmesh/cache/lamp_ray_list.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace gpu_frame_test {

/// These tests need a Vulkan driver: Mesa's lavapipe will do.

namespace {

using lightmesh::Segment;

demo::RenderOptions small_picture() {
    demo::RenderOptions options;
    options.width = 160;
    options.height = 120;
    return options;
}

/// Whether shaders' and the CPU's picture of a scene are one to the eye, and not black.
void check_same_picture(const demo::ComputeDevice& device, const demo::Scene& scene,
                        const std::string& algorithm, const demo::RenderOptions& options,
                        const demo::VisibilityOptions& visibility) {
    CAPTURE(scene.name);
    CAPTURE(algorithm);
    const demo::EmbreeScene embree(scene);
    const auto shadows = demo::make_visibility(algorithm, embree, visibility);
    demo::RenderStatistics of_cpu;
    const demo::Image expected = demo::render(embree, *shadows, options, of_cpu);
    demo::GpuRenderer renderer(device, algorithm, embree, visibility, options);
    demo::RenderStatistics of_gpu;
    const demo::GpuPicture found = renderer.render(of_gpu);
    REQUIRE(expected.pixels.size() == found.linear.pixels.size());
    const double others = demo::share_beyond_one_step(expected, found.linear);
    MESSAGE(scene.name << ", " << algorithm << ": " << 100.0 * others << " % other pixels");
    CHECK(others <= 0.001);
    CHECK(demo::share_beyond_one_step(demo::toned(expected, options.tone), found.toned) <= 0.001);
    CHECK(demo::share_beyond_one_step(demo::Image(options.width, options.height), found.linear) > 0.1);
    CHECK(of_gpu.primary_rays == of_cpu.primary_rays);
    const auto close = [](std::uint64_t a, std::uint64_t b) {
        return std::abs(static_cast<double>(a) - static_cast<double>(b)) <= 1e-3 * static_cast<double>(a);
    };
    CHECK(close(of_cpu.shading_points, of_gpu.shading_points));
    CHECK(close(of_cpu.secondary_rays, of_gpu.secondary_rays));
    const auto mesh = renderer.mesh();
    const auto cache = renderer.cache();
    CHECK(renderer.filled().rays == (mesh    ? mesh->listed_rays + mesh->listed_link_rays
                                     : cache ? cache->listed_rays
                                             : 0));
    // Shaders trace what is found by rays of these; what a mesh tells a cache, maps and volumes are the
    // host's.
    CHECK((renderer.filled().rays > 0) == demo::keeps_snapshot(algorithm));
    CHECK((renderer.bytes() > 0) == (algorithm != "whitted" && algorithm != "area"));
    if (mesh)
        CHECK(mesh->long_rays == 0);
    if (mesh && demo::keeps_snapshot(algorithm))
        CHECK(5 * mesh->link_rays <= mesh->listed_link_rays);
}

void check_same_picture(const demo::ComputeDevice& device, const demo::Scene& scene,
                        const std::string& algorithm, const demo::RenderOptions& options,
                        bool shaft_rows = false) {
    demo::VisibilityOptions visibility = demo::options_of(scene);
    visibility.cache.shaft_rows = shaft_rows;
    visibility.area_samples = 4;
    check_same_picture(device, scene, algorithm, options, visibility);
}

/// Half of them across the whole scene, half of them short ones.
std::vector<Segment> random_segments(const demo::Scene& scene, std::size_t count) {
    const demo::Bounds box = demo::bounds_of(scene);
    test::Random random(7);
    std::vector<Segment> segments;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 origin(random.in_box(test::Vec(box.low), test::Vec(box.high)));
        const glm::vec3 target(random.in_box(test::Vec(box.low), test::Vec(box.high)));
        segments.push_back({origin, i % 2 == 0 ? target : origin + 0.05f * (target - origin)});
    }
    return segments;
}

/// Shares of random rays of which shaders and Embree say another thing.
struct OtherRays {
    double closest = 0.0;
    double shares = 0.0;
    double hits = 0.0;  ///< of all, for comparison
};

OtherRays other_rays(const demo::ComputeDevice& device, const demo::Scene& scene, std::size_t count) {
    const demo::EmbreeScene embree(scene);
    const demo::GpuScene copy(device, embree);
    demo::GpuRays rays(device, copy);
    const std::vector<Segment> segments = random_segments(scene, count);
    const auto closest = rays.closest(segments);
    const auto shares = rays.let_through(segments);
    std::vector<std::uint8_t> is_hit(count);
    std::vector<float> expected(count);
    embree.intersector().let_through(segments, is_hit, expected);
    OtherRays other;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 way = segments[i].target - segments[i].origin;
        const auto hit = embree.trace(segments[i].origin, way, 1.0f);
        other.hits += hit ? 1.0 : 0.0;
        const float rounding = 1e-4f * glm::length(way) + embree.offset();
        if (hit.has_value() != (closest[i].triangle != ~0u))
            other.closest += 1.0;
        else if (hit && glm::distance(hit->position, segments[i].origin + closest[i].t * way) > rounding)
            other.closest += 1.0;
        if (std::abs(shares[i] - expected[i]) > 1e-3f)
            other.shares += 1.0;
    }
    const auto all = static_cast<double>(count);
    return {other.closest / all, other.shares / all, other.hits / all};
}

// ---- what fills

using Mesh = lightmesh::LightMesh<demo::EmbreeIntersector>;

/// Rays to fill of which shaders and Embree say another thing, and all of them.
struct ListedRays {
    std::uint64_t differing = 0;
    std::uint64_t all = 0;
    std::uint64_t seen = 0;
};

ListedRays other_link_rays(const demo::ComputeDevice& device, const demo::Scene& scene) {
    const demo::EmbreeScene embree(scene);
    const Mesh mesh{embree.intersector(), demo::shapes_of_lights(scene), demo::options_of(scene).settings};
    const demo::GpuScene copy(device, embree);
    demo::LinkTests shaders(device, copy);
    const demo::UploadedMesh uploaded(device, mesh.snapshot());
    shaders.bind(uploaded.bindings(demo::LinkTests::set));
    lightmesh::LinkList list;
    mesh.list_links(test::seen_points(embree, 8), list);
    ListedRays rays;
    mesh.fill_links(
        list, [&](std::span<const lightmesh::LinkWord> words, std::span<lightmesh::OpenLinks> open) {
            shaders(words, open, nullptr);
            for (std::size_t w = 0; w < words.size(); ++w)
                for (int p = 0; p < 64; ++p)
                    for (int axis = 0; axis < 3 && (words[w].cells >> p / 8 & 1) != 0; ++axis) {
                        const bool is_open = !mesh.tracer().occluded(mesh.link_segment(words[w], p, axis));
                        const std::uint64_t found = open[w][static_cast<std::size_t>(axis)] >> p & 1;
                        rays.differing += is_open == (found != 0) ? 0u : 1u;
                        rays.seen += is_open ? 1u : 0u;
                        ++rays.all;
                    }
        });
    CHECK(shaders.spent().rays == rays.all);
    CHECK(mesh.statistics().listed_link_rays == rays.all);
    return rays;
}

ListedRays other_long_rays(const demo::ComputeDevice& device, const demo::Scene& scene) {
    const demo::EmbreeScene embree(scene);
    const Mesh mesh{embree.intersector(), demo::shapes_of_lights(scene), demo::options_of(scene).settings};
    const demo::GpuScene copy(device, embree);
    demo::LongTests shaders(device, copy);
    const demo::UploadedMesh uploaded(device, mesh.snapshot());
    shaders.bind(uploaded.bindings(demo::LongTests::set));
    lightmesh::LongTestList list;
    // Of many lights a few points take hundreds of thousands of rays.
    mesh.list_long_tests(test::seen_points(embree, scene.lights.size() > 8 ? 4 : 8), list);
    ListedRays rays;
    mesh.fill(list, [&](std::span<const lightmesh::LongTestWord> words, std::span<std::uint64_t> seen) {
        shaders(words, seen, nullptr);
        for (std::size_t w = 0; w < words.size(); ++w) {
            for (std::uint64_t rest = words[w].points; rest != 0; rest &= rest - 1) {
                const int p = std::countr_zero(rest);
                const bool is_seen = !mesh.tracer().occluded(mesh.long_segment(words[w], p));
                rays.differing += is_seen == (seen[w] >> p & 1) ? 0u : 1u;
                rays.seen += is_seen ? 1u : 0u;
                ++rays.all;
            }
        }
    });
    CHECK(shaders.spent().rays == rays.all);
    CHECK(mesh.statistics().listed_rays == rays.all);
    return rays;
}

/// The same of a cache's rays to lamps.
ListedRays other_lamp_rays(const demo::ComputeDevice& device, const demo::Scene& scene,
                           const demo::VisibilityOptions& options) {
    const demo::EmbreeScene embree(scene);
    const demo::SceneCache cache = demo::cache_of(embree, options);
    const demo::GpuScene copy(device, embree);
    demo::SegmentRays shaders(device, copy);
    const auto points = test::seen_points(embree, scene.lights.size() > 8 ? 3 : 6);
    ListedRays rays;
    // So few points are filled by one thread.
    demo::fill_by_lists(cache, points, [&](const lightmesh::LampRayList& list) {
        cache.fill(list, [&](std::span<const Segment> segments, std::span<std::uint8_t> hit) {
            shaders(segments, hit, nullptr);
            std::vector<std::uint8_t> expected(segments.size());
            cache.tracer().occluded(segments, expected);
            for (std::size_t i = 0; i < segments.size(); ++i) {
                rays.differing += hit[i] != expected[i] ? 1u : 0u;
                rays.seen += hit[i] == 0 ? 1u : 0u;
            }
            rays.all += segments.size();
        });
    });
    CHECK(shaders.spent().rays == rays.all);
    CHECK(cache.statistics().listed_rays == rays.all);
    CHECK(cache.statistics().lamp_rays == 0);

    // The same rays, made by shaders.
    const demo::SceneCache other = demo::cache_of(embree, options);
    demo::LampShares shares(device, copy);
    demo::fill_by_lists(other, points, [&](const lightmesh::LampRayList& list) {
        other.fill_shares(list, [&](auto work, auto found) { shares(work, found, nullptr); });
    });
    CHECK(other.snapshot() == cache.snapshot());
    CHECK(shares.spent().rays == rays.all);
    CHECK(other.statistics().listed_rays == rays.all);
    return rays;
}

// ---- the tree, read as wide_bvh.hpp says

struct Read {
    const demo::WideBvh& bvh;
    std::vector<int> seen;
    int outside = 0;

    void triangle(std::size_t number, const glm::vec3& low, const glm::vec3& high) {
        const std::uint32_t* words = &bvh.triangles[number * demo::WideBvh::words_of_triangle];
        ++seen[words[3]];
        for (int corner = 0; corner < 3; ++corner)
            for (int axis = 0; axis < 3; ++axis) {
                const auto place = std::bit_cast<float>(words[4 * corner + axis]);
                if (!(place >= low[axis] && place <= high[axis]))
                    ++outside;
            }
    }

    void node(std::size_t number, const glm::vec3& above_low, const glm::vec3& above_high) {
        const std::uint32_t* words = &bvh.nodes[number * demo::WideBvh::words_of_node];
        for (std::size_t slot = 0; slot < demo::WideBvh::children_of_node; ++slot) {
            glm::vec3 low;
            glm::vec3 high;
            for (int axis = 0; axis < 3; ++axis) {
                low[axis] = std::bit_cast<float>(words[8 * axis + slot]);
                high[axis] = std::bit_cast<float>(words[8 * axis + 4 + slot]);
            }
            const std::uint32_t child = words[24 + slot];
            if (child == demo::WideBvh::leaf) {
                CHECK(low.x > high.x);
                continue;
            }
            low = glm::max(low, above_low);
            high = glm::min(high, above_high);
            if ((child & demo::WideBvh::leaf) == 0) {
                node(child / (demo::WideBvh::words_of_node / 4), low, high);
                continue;
            }
            for (std::uint32_t i = 0; i < (child & 3u); ++i)
                triangle(((child & ~demo::WideBvh::leaf) >> 2) + i, low, high);
        }
    }
};

}  // namespace

TEST_CASE("gpu frame: each triangle lies once in the wide BVH, and within all boxes above it") {
    for (const demo::Scene& scene : {demo::make_spheres(), demo::make_rooms()}) {
        const demo::WideBvh bvh = demo::build_wide_bvh(scene);
        Read read{bvh, std::vector<int>(scene.triangles.size()), 0};
        read.node(0, glm::vec3(-INFINITY), glm::vec3(INFINITY));
        CHECK(read.outside == 0);
        CHECK(std::ranges::all_of(read.seen, [](int times) { return times == 1; }));
        CHECK(bvh.depth <= 24);
    }
}

TEST_CASE("gpu frame: a BVH that is fitted to triangles that have moved holds them as well") {
    demo::Scene scene = demo::make_spheres();
    demo::WideBvh bvh = demo::build_wide_bvh(scene);
    const std::vector<std::uint32_t> nodes = bvh.nodes;
    demo::fit(bvh, scene);
    CHECK(bvh.nodes == nodes);
    for (std::size_t i = 0; i < scene.positions.size(); i += 3)
        scene.positions[i] += glm::vec3(-3.0f, 0.5f, static_cast<float>(i % 7));
    demo::fit(bvh, scene);
    Read read{bvh, std::vector<int>(scene.triangles.size()), 0};
    read.node(0, glm::vec3(-INFINITY), glm::vec3(INFINITY));
    CHECK(read.outside == 0);
    CHECK(std::ranges::all_of(read.seen, [](int times) { return times == 1; }));
}

TEST_CASE("gpu frame: random rays meet what they meet in Embree") {
    const demo::ComputeDevice device(test::each_traversal());
    std::vector<demo::Scene> scenes{demo::make_spheres(), demo::make_rooms(), demo::make_park()};
    scenes.push_back(demo::import_scene(LIGHTMESH_FIELD "/bulb-pane-mask/pane.gltf"));
    scenes.push_back(demo::make_spheres());
    for (glm::vec3& position : scenes.back().positions)
        position += glm::vec3(10000.0f, -7000.0f, 3000.0f);
    for (const demo::Scene& scene : scenes) {
        const OtherRays other = other_rays(device, scene, 20000);
        MESSAGE(scene.name << ": " << 100.0 * other.closest << " % other surfaces, " << 100.0 * other.shares
                           << " % other shares of light, of " << 100.0 * other.hits << " % that hit");
        CHECK(other.closest <= 2e-4);
        CHECK(other.shares <= 2e-4);
        CHECK(other.hits > 0.004);
    }
}

TEST_CASE("gpu frame: links and long tests and rays to lamps that shaders trace say what Embree says") {
    const demo::ComputeDevice device(test::each_traversal());
    std::vector<demo::Scene> scenes{demo::make_spheres(), demo::make_rooms(), demo::make_park()};
    // Surfaces that let light through by a hash of a segment's ends: these must be the same to the bit.
    scenes.push_back(demo::import_scene(LIGHTMESH_FIELD "/bulb-pane-mask/pane.gltf"));
    scenes.push_back(demo::make_spheres());
    scenes.back().name = "spheres far away, lights of all kinds";
    const glm::vec3 moved(10000.0f, -7000.0f, 3000.0f);
    for (glm::vec3& position : scenes.back().positions)
        position += moved;
    scenes.back().camera.eye += moved;
    scenes.back().camera.target += moved;
    scenes.back().lights.clear();
    for (const lightmesh::Light& shape :
         {lightmesh::Light(
              lightmesh::PointLight{.position = moved + glm::vec3(1.0f, -2.0f, 5.0f), .range = 9.0f}),
          lightmesh::Light(lightmesh::PointLight{.position = 1e6f * glm::vec3(1.0f, 2.0f, 3.0f)}),
          lightmesh::Light(lightmesh::DirectionalLight{{0.3f, 0.4f, -1.0f}}),
          lightmesh::Light(lightmesh::SpotLight{
              .position = moved + glm::vec3(0.0f, 0.0f, 6.0f), .axis = {0.1f, 0.2f, -1.0f}, .cone = 0.7f})})
        scenes.back().lights.push_back({.shape = shape, .intensity = glm::vec3(1.0f)});
    const auto check = [](const ListedRays& rays) {
        MESSAGE(rays.differing << " of " << rays.all << " differ, " << rays.seen << " are open");
        CHECK(static_cast<double>(rays.differing) <= 2e-5 * static_cast<double>(rays.all));
        CHECK(rays.all > 1000);
        CHECK(rays.seen > 100);
        CHECK(rays.seen < rays.all);
    };
    for (const demo::Scene& scene : scenes) {
        CAPTURE(scene.name);
        check(other_link_rays(device, scene));
        check(other_long_rays(device, scene));
        demo::VisibilityOptions options = demo::options_of(scene);
        for (const bool shaft_rows : {false, true}) {
            options.cache.shaft_rows = shaft_rows;
            check(other_lamp_rays(device, scene, options));
        }
    }
}

TEST_CASE("gpu frame: what is cancelled stores nothing") {
    const demo::ComputeDevice device;
    const demo::Scene scene = demo::make_spheres();
    const demo::EmbreeScene embree(scene);
    const Mesh mesh{embree.intersector(), demo::shapes_of_lights(scene), demo::options_of(scene).settings};
    const demo::GpuScene copy(device, embree);
    demo::LongTests shaders(device, copy);
    lightmesh::LongTestList list;
    mesh.list_long_tests(test::seen_points(embree, 4), list);
    const std::atomic<bool> cancel = true;
    CHECK_THROWS_AS(mesh.fill(list, [&](auto words, auto seen) { shaders(words, seen, &cancel); }),
                    demo::Cancelled);
    CHECK(mesh.statistics().light_points == 0);
    CHECK(shaders.spent().rays == 0);

    demo::SegmentRays segments(device, copy);
    std::vector<std::uint8_t> hit(1);
    CHECK_THROWS_AS(segments(random_segments(scene, 1), hit, &cancel), demo::Cancelled);
    CHECK(segments.spent().rays == 0);

    const demo::SceneCache cache = demo::cache_of(embree, demo::options_of(scene));
    lightmesh::LampRayList missing;
    cache.list_lamp_rays(test::seen_points(embree, 4), missing);
    demo::LampShares shares(device, copy);
    CHECK_THROWS_AS(cache.fill_shares(missing, [&](auto work, auto found) { shares(work, found, &cancel); }),
                    demo::Cancelled);
    CHECK(cache.statistics().rows == 0);
    CHECK(shares.spent().rays == 0);
}

TEST_CASE("gpu frame: one triangle, and rays along the axes") {
    demo::Scene scene = demo::make_spheres();
    scene.positions = {{0.0f, 0.0f, 1.0f}, {4.0f, 0.0f, 1.0f}, {0.0f, 4.0f, 1.0f}};
    scene.normals.clear();
    scene.triangles = {{{0, 1, 2}, 0}};
    const demo::ComputeDevice device(test::each_traversal());
    const demo::EmbreeScene embree(scene);
    const demo::GpuScene copy(device, embree);
    demo::GpuRays rays(device, copy);
    const std::vector<Segment> segments{{{1.0f, 1.0f, 0.0f}, {1.0f, 1.0f, 2.0f}},
                                        {{1.0f, 1.0f, 2.0f}, {1.0f, 1.0f, 0.0f}},
                                        {{3.0f, 3.0f, 0.0f}, {3.0f, 3.0f, 2.0f}},
                                        {{1.0f, 1.0f, 0.0f}, {1.0f, 1.0f, 0.9f}},
                                        {{-1.0f, 1.0f, 0.5f}, {5.0f, 1.0f, 0.5f}}};
    const auto closest = rays.closest(segments);
    const std::vector<float> shares = rays.let_through(segments);
    for (std::size_t i = 0; i < segments.size(); ++i) {
        CHECK(closest[i].triangle == (i < 2 ? 0u : ~0u));
        CHECK(shares[i] == (i < 2 ? 0.0f : 1.0f));
    }
    CHECK(closest[0].t == doctest::Approx(0.5));
    CHECK(closest[0].u == doctest::Approx(0.25));
    CHECK(closest[0].v == doctest::Approx(0.25));
}

TEST_CASE("gpu frame: pictures of the built-in scenes are those of the CPU") {
    const demo::ComputeDevice device(test::each_traversal());
    for (const demo::Scene& scene : {demo::make_park(), demo::make_rooms(), demo::make_spheres()})
        check_same_picture(device, scene, "whitted", small_picture());
}

TEST_CASE("gpu frame: pictures far from the origin are those of the CPU") {
    const demo::ComputeDevice device(test::each_traversal());
    demo::Scene scene = demo::make_spheres();
    const glm::vec3 away(300.0f, -200.0f, 100.0f);
    for (glm::vec3& position : scene.positions)
        position += away;
    for (demo::SceneLight& light : scene.lights)
        std::get<lightmesh::PointLight>(light.shape).position += away;
    scene.camera.eye += away;
    scene.camera.target += away;
    demo::RenderOptions options;
    options.width = 48;
    options.height = 36;
    for (const char* algorithm : {"whitted", "express", "linked", "cache"})
        check_same_picture(device, scene, algorithm, options);
}

TEST_CASE("gpu frame: textures, masks, glass, mirrors, colours of vertices and lights of all kinds") {
    const demo::ComputeDevice device(test::each_traversal());
    for (const char* file : {"bulb-pane-mask/pane.gltf", "bulb-pane-mask/bulb-glass.gltf",
                             "emissive-texture/emissive-texture.gltf", "vertex-colours/vertex-colours.gltf",
                             "exposure/spot.gltf", "range-and-cone/L-cone0.gltf"}) {
        demo::Scene scene = demo::import_scene(std::string(LIGHTMESH_FIELD "/") + file);
        scene.name = file;
        check_same_picture(device, scene, "whitted", small_picture());
    }
}

TEST_CASE("gpu frame: lamps with sizes, several rays a pixel, the filmic curve, an orthographic view") {
    const demo::ComputeDevice device(test::each_traversal());
    demo::RenderOptions options;
    options.width = 80;
    options.height = 60;
    options.samples = 3;
    options.tone = demo::Tone::filmic;
    demo::Scene scene = demo::make_spheres();
    scene.lights.resize(2);
    scene.lights.push_back({.shape = lightmesh::RectLight{.position = {1.0f, -1.0f, 6.0f},
                                                          .half_u = {0.0f, 0.7f, 0.0f},
                                                          .half_v = {0.9f, 0.0f, 0.1f}},
                            .intensity = glm::vec3(20.0f),
                            .fall_off = demo::FallOff::lamps});
    scene.lights.push_back(
        {.shape = lightmesh::DirectionalLight{{0.3f, 0.4f, -1.0f}}, .intensity = glm::vec3(0.5f)});
    check_same_picture(device, scene, "area", options);
    scene.camera.orthographic_height = 6.0f;
    scene.camera.z_near = 0.5f;
    check_same_picture(device, scene, "whitted", options);
}

TEST_CASE("gpu frame: light meshes on all levels, and caches, filled as shaders ask") {
    const demo::ComputeDevice device(test::each_traversal());
    demo::RenderOptions options;
    options.width = 40;
    options.height = 30;
    for (const bool shaft_rows : {false, true})
        check_same_picture(device, demo::make_spheres(), "cache", options, shaft_rows);
    options.width = 24;
    options.height = 18;
    check_same_picture(device, demo::make_rooms(), "cache", options, true);
    check_same_picture(device, demo::import_scene(LIGHTMESH_FIELD "/bulb-pane-mask/pane.gltf"), "linked",
                       options);
    check_same_picture(device, demo::make_rooms(), "linked", options);
    check_same_picture(device, demo::make_rooms(), "express", options);
    options.width = 12;
    options.height = 9;
    check_same_picture(device, demo::make_park(), "linked", options);
}

TEST_CASE("gpu frame: light meshes by maps and volumes, and seen through a cache, filled by the host") {
    const demo::ComputeDevice device;
    demo::RenderOptions options;
    options.width = 24;
    options.height = 18;
    for (const char* algorithm :
         {"blur-cache", "express+map", "linked+map", "express+volume", "linked+volume"})
        check_same_picture(device, demo::make_spheres(), algorithm, options);
    check_same_picture(device, demo::make_rooms(), "blur-cache", options);
    check_same_picture(device, demo::make_rooms(), "express+volume", options);
}

TEST_CASE("gpu frame: the exact short test by rays of shaders, long tests by these and by the host") {
    const demo::ComputeDevice device(test::each_traversal());
    demo::RenderOptions options;
    options.width = 24;
    options.height = 18;
    demo::VisibilityOptions visibility = demo::options_of(demo::make_spheres());
    visibility.settings.short_test = lightmesh::ShortTest::exact;
    for (const char* algorithm : {"lmm", "lmm+map", "lmm+volume"})
        check_same_picture(device, demo::make_spheres(), algorithm, options, visibility);
    visibility.settings.quality = 5.0f;
    check_same_picture(device, demo::make_spheres(), "lmm", options, visibility);
}

TEST_CASE("gpu frame: shadow maps that shaders look up, and volumes that the host does") {
    const demo::ComputeDevice device;
    for (const char* algorithm : {"shadow-map", "shadow-volume"})
        check_same_picture(device, demo::make_spheres(), algorithm, small_picture());
    // Maps of all shapes: faces of cubes, what a narrow cone and the sun see, texels beyond their edges.
    demo::Scene scene = demo::make_rooms();
    scene.lights.resize(3);
    scene.lights.push_back({.shape = lightmesh::SpotLight{.position = scene.camera.eye,
                                                          .axis = scene.camera.target - scene.camera.eye,
                                                          .cone = 0.3f},
                            .intensity = glm::vec3(20.0f)});
    scene.lights.push_back(
        {.shape = lightmesh::DirectionalLight{{0.3f, 0.4f, -1.0f}}, .intensity = glm::vec3(0.5f)});
    demo::VisibilityOptions visibility = demo::options_of(scene);
    visibility.settings.shadow_map_size = 96;
    demo::RenderOptions options = small_picture();
    options.samples = 2;
    check_same_picture(device, scene, "shadow-map", options, visibility);
    visibility.depth = demo::DepthSource::embree;
    check_same_picture(device, scene, "shadow-map", options, visibility);
    check_same_picture(device, scene, "shadow-volume", options, visibility);
}

TEST_CASE("gpu frame: parts of a picture are those of all of it") {
    const demo::ComputeDevice device;
    const demo::Scene scene = demo::make_spheres();
    const demo::EmbreeScene embree(scene);
    demo::RenderOptions options;
    options.width = 24;
    options.height = 18;
    for (const char* algorithm : {"whitted", "shadow-volume", "express"}) {
        CAPTURE(algorithm);
        demo::GpuRenderer renderer(device, algorithm, embree, demo::options_of(scene), options);
        demo::RenderStatistics statistics;
        const demo::GpuPicture whole = renderer.render(statistics);
        demo::Image joined(options.width, options.height);
        for (const demo::PixelRange part : {demo::PixelRange{0, 100}, {100, 100}, {100, 432}}) {
            const demo::GpuPicture found = renderer.render(part, statistics);
            CHECK(statistics.finished);
            CHECK(statistics.primary_rays == part.end - part.first);
            for (std::size_t i = 0; i < joined.pixels.size(); ++i) {
                if (i >= part.first && i < part.end)
                    joined.pixels[i] = found.linear.pixels[i];
                else
                    REQUIRE(found.linear.pixels[i] == glm::vec3(0.0f));
            }
        }
        CHECK(joined.pixels == whole.linear.pixels);
    }
}

TEST_CASE("gpu frame: what one renderer has found another one takes over") {
    const demo::ComputeDevice device;
    const demo::Scene scene = demo::make_spheres();
    const demo::EmbreeScene embree(scene);
    demo::RenderOptions options;
    options.width = 20;
    options.height = 15;
    for (const char* algorithm : {"cache", "express", "express+volume"}) {
        CAPTURE(algorithm);
        const demo::VisibilityOptions visibility = demo::options_of(scene);
        demo::GpuRenderer first(device, algorithm, embree, visibility, options);
        demo::GpuRenderer second(device, algorithm, embree, visibility, options);
        demo::RenderStatistics statistics;
        const demo::GpuPicture picture = first.render(statistics);
        second.merge(first.snapshot());
        CHECK(second.render(statistics).linear.pixels == picture.linear.pixels);
        CHECK(10 * demo::kept_rays(second) <= demo::kept_rays(first));
    }
}

TEST_CASE("gpu frame: over its budget of memory a renderer forgets between frames, and renders the same") {
    const demo::ComputeDevice device;
    const demo::Scene scene = demo::make_spheres();
    const demo::EmbreeScene embree(scene);
    demo::RenderOptions options;
    options.width = 16;
    options.height = 12;
    for (const std::string algorithm : {"cache", "express", "express+volume"}) {
        CAPTURE(algorithm);
        const bool is_cache = algorithm == "cache";
        demo::VisibilityOptions visibility = demo::options_of(scene);
        demo::RenderStatistics statistics;
        demo::GpuRenderer other(device, algorithm, embree, visibility, options);
        const demo::GpuPicture expected = other.render(statistics);
        visibility.settings.memory_budget = visibility.cache.memory_budget = other.bytes() / 8;
        demo::GpuRenderer renderer(device, algorithm, embree, visibility, options);
        for (int frame = 0; frame < 4; ++frame) {
            renderer.begin_frame();
            const demo::GpuPicture found = renderer.render(statistics);
            CHECK(statistics.finished);
            // The host answers where a full cache keeps nothing: by other roundings than the device.
            if (is_cache)
                CHECK(demo::share_beyond_one_step(found.linear, expected.linear) <= 0.001);
            else
                CHECK(found.linear.pixels == expected.linear.pixels);
        }
        if (is_cache) {
            CHECK(renderer.bytes() < other.bytes());
        } else {
            CHECK(renderer.mesh()->evicted_bricks > 0);
            // What is in use stays.
            CHECK(renderer.mesh()->long_tests < 2 * other.mesh()->long_tests);
        }
    }
}

TEST_CASE("gpu frame: the host is not told of use where nothing is to be forgotten soon") {
    const demo::ComputeDevice device;
    const demo::Scene scene = demo::make_rooms();
    const demo::EmbreeScene embree(scene);
    demo::RenderOptions options;
    options.width = 16;
    options.height = 12;
    // Rays from points, by which the host sees what they use, of a second frame of the same.
    const auto rays = [&](std::size_t budget) {
        demo::VisibilityOptions visibility = demo::options_of(scene);
        visibility.cache.shaft_rows = false;
        visibility.cache.memory_budget = budget;
        demo::GpuRenderer renderer(device, "cache", embree, visibility, options);
        demo::RenderStatistics statistics;
        renderer.begin_frame();
        renderer.render(statistics);
        renderer.begin_frame();
        const std::uint64_t before = renderer.cache()->point_rays;
        renderer.render(statistics);
        return std::pair(renderer.cache()->point_rays - before, renderer.bytes());
    };
    const auto [of_all, bytes] = rays(lightmesh::CacheSettings{}.memory_budget);
    CHECK(rays(4 * bytes).first == of_all);
    CHECK(rays(bytes + bytes / 2).first > of_all);
}

TEST_CASE("gpu frame: what one picture has found another one begins with, on host and device") {
    const demo::ComputeDevice device;
    demo::RenderOptions options;
    options.width = 20;
    options.height = 15;
    const demo::Scene scene = demo::make_spheres();
    const demo::EmbreeScene embree(scene);
    for (const char* algorithm : {"cache", "linked", "express"}) {
        CAPTURE(algorithm);
        demo::VisibilityOptions visibility = demo::options_of(scene);
        demo::GpuRenderer first(device, algorithm, embree, visibility, options);
        demo::RenderStatistics statistics;
        const demo::Image picture = first.render(statistics).linear;
        CHECK(first.filled().rays > 0);
        visibility.known = first.snapshot();
        demo::GpuRenderer second(device, algorithm, embree, visibility, options);
        CHECK(second.render(statistics).linear.pixels == picture.pixels);
        CHECK(second.filled().rays == 0);
        const auto on_host = demo::make_visibility(algorithm, embree, visibility);
        CHECK(demo::share_beyond_one_step(demo::render(embree, *on_host, options, statistics), picture) <=
              0.001);
        const std::uint64_t rays = demo::kept_rays(*on_host);
        const auto fresh = demo::make_visibility(algorithm, embree, demo::options_of(scene));
        demo::render(embree, *fresh, options, statistics);
        CHECK(10 * rays < demo::kept_rays(*fresh));
    }
}

TEST_CASE("gpu frame: in films pictures are those of a new renderer to the bit") {
    const demo::ComputeDevice device(test::each_traversal());
    demo::RenderOptions options;
    options.width = 16;
    options.height = 12;
    const auto follow = [&](demo::AnimatedScene animated, const std::string& algorithm,
                            std::initializer_list<double> times) {
        demo::Film film(std::move(animated));
        CAPTURE(film.scene().name);
        CAPTURE(algorithm);
        demo::EmbreeScene embree(film.scene(), demo::EmbreeScene::For::films);
        const demo::VisibilityOptions visibility = demo::options_of(film.scene());
        demo::GpuRenderer renderer(device, algorithm, embree, visibility, options);
        demo::RenderStatistics statistics;
        demo::GpuPicture last = renderer.render(statistics);
        for (const double time : times) {
            const demo::SceneChange change = film.go_to(time);
            embree.update(change);
            renderer.update(embree, change);
            demo::GpuPicture found = renderer.render(statistics);
            CHECK(found.linear.pixels != last.linear.pixels);
            last = std::move(found);
        }
        const demo::EmbreeScene anew(film.scene());
        demo::GpuRenderer other(device, algorithm, anew, visibility, options);
        const demo::GpuPicture expected = other.render(statistics);
        CHECK(last.linear.pixels == expected.linear.pixels);
        CHECK(last.toned.pixels == expected.toned.pixels);
    };
    follow(demo::animate_spheres(), "area", {1.0, 0.25});
    follow(demo::animate_rooms(), "cache", {0.5, 1.0});
    follow(demo::animate_rooms(), "linked", {0.75});
    follow(demo::animate_rooms(), "blur-cache", {0.5});
    follow(demo::animate_spheres(), "express+map", {1.0});
    follow(demo::animate_spheres(), "linked+volume", {1.0});
    follow(demo::animate_spheres(), "express", {1.5, 3.0});
    follow(demo::animate_spheres(), "shadow-map", {1.0});
    follow(demo::animate_spheres(), "shadow-volume", {1.0});
    follow(demo::animate_park(), "whitted", {1.0, 2.0});
}

TEST_CASE("gpu frame: where an update fails the shadow maps of before are there") {
    const demo::ComputeDevice device;
    demo::Scene scene = demo::make_spheres();
    const demo::EmbreeScene embree(scene);
    demo::RenderOptions options;
    options.width = 40;
    options.height = 30;
    demo::GpuRenderer renderer(device, "shadow-map", embree, demo::options_of(scene), options);
    demo::RenderStatistics statistics;
    const demo::Image before = renderer.render(statistics).linear;
    const std::vector<demo::SceneLight> lights = scene.lights;
    const auto move = [&](std::size_t light, float by) {
        std::get<lightmesh::PointLight>(scene.lights[light].shape).position.x += by;
    };
    demo::SceneChange change;
    change.lights = {0, 1};
    for (const bool has_other_triangles : {false, true}) {
        CAPTURE(has_other_triangles);
        change.has_other_triangles = has_other_triangles;
        move(0, 1.0f);
        move(1, NAN);
        CHECK_THROWS_AS(renderer.update(embree, change), std::invalid_argument);
        scene.lights = lights;
        renderer.update(embree, {});
        CHECK(renderer.render(statistics).linear.pixels == before.pixels);
    }
    move(0, 1.0f);
    renderer.update(embree, change);
    CHECK(renderer.render(statistics).linear.pixels != before.pixels);
}

TEST_CASE("gpu frame: of a film's scene only what has moved is written") {
    const demo::ComputeDevice device({.ray_queries = false});
    demo::Film film(demo::animate_park());
    demo::EmbreeScene embree(film.scene(), demo::EmbreeScene::For::films);
    demo::GpuScene copy(device, embree);
    std::size_t all = 0;
    for (const demo::ComputeBinding& binding : copy.bindings())
        all += binding.buffer().size();
    demo::SceneChange change = film.go_to(1.0);
    REQUIRE(change.changes_triangles());
    embree.update(change);
    const std::size_t written = copy.update(embree, change);
    MESSAGE(written << " of " << all << " bytes");
    CHECK(written < all / 4);
    change = film.go_to(1.0);
    CHECK(copy.update(embree, change) < 256);

    const demo::GpuScene anew(device, embree);
    for (const std::size_t i : {0u, 3u, 4u, 5u, 6u})  // all but the tree, which has another shape
        CHECK(copy.bindings()[i].buffer().read_all<std::uint32_t>() ==
              anew.bindings()[i].buffer().read_all<std::uint32_t>());
}

TEST_CASE("gpu frame: normals that turn where no corner moves are written") {
    const demo::ComputeDevice device;
    demo::Scene scene = demo::make_spheres();
    const demo::EmbreeScene embree(scene);
    demo::GpuScene copy(device, embree);
    REQUIRE(!scene.normals.empty());
    scene.normals.back() = -scene.normals.back();
    copy.update(embree, {});
    const demo::GpuScene anew(device, embree);
    CHECK(copy.bindings()[4].buffer().read_all<std::uint32_t>() ==
          anew.bindings()[4].buffer().read_all<std::uint32_t>());
}

TEST_CASE("gpu frame: clean under the validation layers, by each shader and after an update") {
    test::WatchedDevice watched(test::each_traversal());
    demo::Film film(demo::animate_spheres());
    demo::EmbreeScene embree(film.scene(), demo::EmbreeScene::For::films);
    demo::RenderOptions options;
    options.width = 16;
    options.height = 12;
    struct Case {
        std::string algorithm;
        float quality = 4.0f;
    };
    double time = 0.0;
    for (const Case& c : {Case{"whitted"}, Case{"area"}, Case{"express", 5.0f}, Case{"linked"}, Case{"lmm"},
                          Case{"cache"}, Case{"shadow-map"}, Case{"shadow-volume"}}) {
        CAPTURE(c.algorithm);
        demo::VisibilityOptions visibility = demo::options_of(film.scene());
        visibility.area_samples = 2;
        visibility.settings.quality = c.quality;
        demo::GpuRenderer renderer(watched.device, c.algorithm, embree, visibility, options);
        demo::RenderStatistics statistics;
        renderer.render(statistics);
        CHECK(statistics.finished);
        const bool has_mesh = c.algorithm == "express" || c.algorithm == "linked" || c.algorithm == "lmm";
        CHECK(renderer.mesh().has_value() == has_mesh);
        CHECK(renderer.cache().has_value() == (c.algorithm == "cache"));
        const demo::SceneChange change = film.go_to(time += 0.25);
        embree.update(change);
        renderer.update(embree, change);
        renderer.render(statistics);
        CHECK(statistics.finished);
    }
    const demo::GpuScene copy(watched.device, embree);
    const std::vector<Segment> segments = random_segments(film.scene(), 64);
    demo::GpuRays rays(watched.device, copy);
    CHECK(rays.closest(segments).size() == segments.size());
    CHECK(rays.let_through(segments).size() == segments.size());
    std::vector<std::uint8_t> hit(segments.size());
    demo::SegmentRays(watched.device, copy)(segments, hit, nullptr);
    for (const std::string& message : watched.messages)
        FAIL_CHECK(message);
}

TEST_CASE("gpu frame: what shaders do not know is refused by its name, and a cancelled picture ends") {
    const demo::ComputeDevice device;
    const demo::Scene scene = demo::make_spheres();
    const demo::EmbreeScene embree(scene);
    const auto message_of = [&](const std::string& algorithm, const demo::VisibilityOptions& visibility,
                                const demo::RenderOptions& options) -> std::string {
        try {
            demo::GpuRenderer renderer(device, algorithm, embree, visibility, options);
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "nothing was thrown";
    };
    for (const demo::Algorithm& algorithm : demo::algorithms())
        CHECK(std::ranges::count(demo::GpuRenderer::algorithms(), algorithm.name) == 1);
    CHECK(message_of("by-guess", {}, small_picture()) ==
          "--on gpu does not know --algorithm by-guess; it knows cache, blur-cache, whitted, area, "
          "shadow-map, shadow-volume, lmm, linked, express, lmm+map, linked+map, express+map, lmm+volume, "
          "linked+volume, express+volume");
    demo::RenderOptions options = small_picture();
    options.ambient_rays = 4;
    CHECK(message_of("whitted", {}, options) == "--on gpu does not know ambient rays");
    options = small_picture();
    options.width = 0;
    CHECK(message_of("whitted", {}, options).find("0 x 120") != std::string::npos);

    demo::GpuRenderer renderer(device, "whitted", embree, {}, small_picture());
    demo::RenderStatistics statistics;
    const std::atomic<bool> cancel = true;
    renderer.render(statistics, {}, &cancel);
    CHECK_FALSE(statistics.finished);
}

TEST_CASE("lightmesh-render picture --on gpu: a picture and its table, the CPU's picture, errors") {
    const test::TemporaryFolder folder;
    const auto render = [&](const std::string& arguments) {
        return test::run(folder, LIGHTMESH_RENDER " picture spheres --width 64 --height 48 " + arguments);
    };
    const auto file = [&](const char* name) {
        return (folder / name).string();
    };
    const test::Finished on_gpu = render("-a whitted --on gpu --tone filmic -o " + file("gpu.png"));
    REQUIRE_MESSAGE(on_gpu.status == 0, on_gpu.errors);
    for (const char* row : {"device", "in shaders", "shadow rays", "surface points"})
        CHECK_MESSAGE(on_gpu.output.find(row) != std::string::npos, row);
    REQUIRE(render("-a whitted --on cpu --tone filmic -o " + file("cpu.png")).status == 0);
    CHECK(demo::share_beyond_one_step(demo::read_png(folder / "gpu.png"),
                                      demo::read_png(folder / "cpu.png")) <= 0.001);

    const test::Finished by_maps = render("-a shadow-map --on gpu -o " + file("map.png"));
    REQUIRE_MESSAGE(by_maps.status == 0, by_maps.errors);
    CHECK(by_maps.output.find("memory of maps and volumes") != std::string::npos);

    for (const std::string how : {"--no-shaft-rows", "--exact-edges"}) {
        CAPTURE(how);
        for (const std::string on : {"cpu", "gpu"}) {
            const test::Finished made =
                test::run(folder, LIGHTMESH_RENDER " picture rooms --width 24 --height 18 -a cache " + how +
                                      " --on " + on + " -o " + file((on + ".png").c_str()));
            REQUIRE_MESSAGE(made.status == 0, made.errors);
            CHECK((made.output.find("edges") != std::string::npos) == (how == "--exact-edges"));
        }
        CHECK(demo::share_beyond_one_step(demo::read_png(folder / "gpu.png"),
                                          demo::read_png(folder / "cpu.png")) <= 0.001);
    }

    const auto check_refused = [&](const std::string& arguments, const std::string& part) {
        const test::Finished ran = render("-o " + file("none.png") + " " + arguments);
        CHECK(ran.status != 0);
        CHECK_MESSAGE(ran.errors.find(part) != std::string::npos, ran.errors);
        CHECK(ran.errors.starts_with("lightmesh-render: "));
    };
    check_refused("--on gpu -a whitted --device none-such", "no device \"none-such\"");
    check_refused("--on gpu -a whitted --gpu-rays guess", "--gpu-rays");
    check_refused("--on cpu -a whitted --gpu-rays bvh", "--gpu-rays is for --on gpu, not for --on cpu");
    REQUIRE(render("-a whitted -o " + file("cpu.png")).status == 0);
    for (const std::string how : {"bvh", "queries"}) {
        CAPTURE(how);
        if (how == "queries" && !test::there_are_ray_queries()) {
            check_refused("--on gpu -a whitted --gpu-rays queries", "has no ray queries");
            continue;
        }
        const test::Finished made =
            render("-a whitted --on gpu --gpu-rays " + how + " -o " + file("gpu.png"));
        REQUIRE_MESSAGE(made.status == 0, made.errors);
        CHECK((made.output.find(", ray queries") != std::string::npos) == (how == "queries"));
        CHECK(demo::share_beyond_one_step(demo::read_png(folder / "gpu.png"),
                                          demo::read_png(folder / "cpu.png")) <= 0.001);
    }
    CHECK_FALSE(std::filesystem::exists(folder / "none.png"));
}

}  // namespace gpu_frame_test
