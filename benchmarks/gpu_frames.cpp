// SPDX-License-Identifier: MIT

// Rays and whole pictures by shaders, held against Embree and the CPU's renderer and timed:
// lightmesh-gpu-frame-benchmark [--frames [SCENE]] [--device NAME] [--gpu-rays queries|bvh]. On a CPU that
// plays a GPU all is small: there it is about what comes out, not about times; with --frames pictures have
// 160 x 120 pixels there, and nothing else is run.

#include "gpu/cache_fill.hpp"
#include "gpu/gpu_rays.hpp"
#include "gpu/gpu_renderer.hpp"
#include "gpu/gpu_scene.hpp"
#include "gpu/lamp_shares.hpp"
#include "gpu/listed_words.hpp"
#include "gpu/listing.hpp"
#include "gpu/uploaded.hpp"
#include "gpu_benchmark.hpp"
#include "image/image.hpp"
#include "render/renderer.hpp"
#include "render/scene_cache.hpp"
#include "render/stopwatch.hpp"
#include "render/visibility.hpp"
#include "shading_points.hpp"

#include <lightmesh/cache/lamp_ray_list.hpp>
#include <lightmesh/light_mesh.hpp>

#include <glm/vec3.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace {

using lightmesh::Segment;

constexpr std::size_t rays_at_once = std::size_t{1} << 24;

/// From the eye through surface points.
std::vector<Segment> eye_rays(const demo::EmbreeScene& scene, const bench::ShadingPoints& points) {
    const glm::vec3& eye = scene.scene().camera.eye;
    std::vector<Segment> rays;
    for (std::size_t t = 0; t < points.tile_count(); ++t)
        for (const glm::vec3& position : points.tile(t).positions)
            rays.push_back({eye, position + 0.1f * (position - eye)});
    return rays;
}

struct Rays {
    std::size_t count = 0;
    std::size_t differing = 0;  ///< from Embree's
    double seconds = 0.0;       ///< of the device
};

Rays closest(demo::GpuRays& rays, const demo::EmbreeScene& scene, std::span<const Segment> segments) {
    Rays result;
    for (std::size_t first = 0; first < segments.size(); first += rays_at_once) {
        const auto some = segments.subspan(first, (std::min)(rays_at_once, segments.size() - first));
        const std::vector<demo::GpuRays::Closest> found = rays.closest(some);
        result.seconds += rays.seconds();
        std::vector<std::uint8_t> differs(some.size());
        tbb::parallel_for(std::size_t{0}, some.size(), [&](std::size_t i) {
            const auto hit = scene.trace(some[i].origin, some[i].target - some[i].origin, 1.0f);
            differs[i] = (hit ? hit->triangle : ~0u) != found[i].triangle;
        });
        result.differing += static_cast<std::size_t>(std::ranges::count(differs, 1));
        result.count += some.size();
    }
    return result;
}

/// Returns whether the rays are Embree's.
bool time_rays(const demo::ComputeDevice& device, const demo::EmbreeScene& embree,
               const bench::ShadingPoints& points) {
    const demo::GpuScene copy(device, embree);
    demo::GpuRays rays(device, copy);
    rays.begin_timing();
    const auto row = [&](const char* kind, const Rays& r) {
        std::printf("| %s | %s | %s | %zu | %.3f | %.6f | %zu |\n", embree.scene().name.c_str(), kind,
                    bench::traversal_of(device).c_str(), r.count, 1e3 * r.seconds,
                    1e-9 * static_cast<double>(r.count) / r.seconds, r.differing);
        std::fflush(stdout);
    };
    const Rays first = closest(rays, embree, eye_rays(embree, points));
    row("eye to surface, the first hit", first);
    const bench::HardShadows hard = bench::hard_shadows(device, embree, points);
    const Rays any{hard.traced, hard.differing, hard.seconds};
    row("surface to lights, any hit", any);
    return bench::are_nearly_all_same({first.differing, first.count}) &&
           bench::are_nearly_all_same(hard.error());
}

/// What a picture of `width` x 3/4 `width` sees; a small one on a CPU that plays a GPU.
std::vector<lightmesh::SurfacePoint> points_to_fill(const demo::ComputeDevice& device,
                                                    const demo::EmbreeScene& scene, int width) {
    const bench::ShadingPoints points(scene, device.is_cpu() ? 16 : width,
                                      device.is_cpu() ? 16 : width * 3 / 4);
    std::vector<lightmesh::SurfacePoint> asked;
    for (std::size_t t = 0; t < points.tile_count(); ++t)
        for (std::size_t i = 0; i < points.tile(t).size(); ++i)
            asked.push_back({.position = points.tile(t).positions[i], .normal = points.tile(t).normals[i]});
    return asked;
}

/// A light mesh that knows nothing yet, on host and device.
struct MeshToFill {
    MeshToFill(const demo::ComputeDevice& device, const demo::Scene& of_scene)
        : scene(of_scene), embree(scene), asked(points_to_fill(device, embree, 960)),
          mesh(embree.intersector(), demo::shapes_of_lights(scene), demo::options_of(scene).settings),
          copy(device, embree), uploaded(device, mesh.snapshot()) {}

    demo::Scene scene;
    demo::EmbreeScene embree;
    std::vector<lightmesh::SurfacePoint> asked;
    lightmesh::LightMesh<demo::EmbreeIntersector> mesh;
    demo::GpuScene copy;
    demo::UploadedMesh uploaded;
};

/// By shaders as the mesh lists them, and by Embree.
struct Listed {
    double seconds_listing = 0.0;
    double seconds_filling = 0.0;  ///< with Embree's
    double seconds_by_device = 0.0;
    double seconds_by_embree = 0.0;  ///< on all threads
    std::size_t words = 0;
    std::size_t differing = 0;  ///< words that are not Embree's

    /// A row of the table. Returns whether the words are Embree's.
    bool print(const MeshToFill& of, const char* what, const demo::DeviceFill& spent) const {
        std::printf("| %s | %s | %zu | %llu | %llu | %zu | %.1f | %.1f | %.1f | %.1f | %.1f | %zu |\n",
                    of.scene.name.c_str(), what, words, static_cast<unsigned long long>(spent.rays),
                    static_cast<unsigned long long>(of.mesh.statistics().link_rays), spent.dispatches,
                    1e3 * seconds_listing, 1e3 * seconds_by_device, 1e3 * spent.seconds_device,
                    1e3 * (seconds_filling - seconds_by_device - seconds_by_embree), 1e3 * seconds_by_embree,
                    differing);
        std::fflush(stdout);
        return bench::are_nearly_all_same({differing, words});
    }
};

/// Which of segments Embree has something on.
std::vector<std::uint8_t> hits(const MeshToFill& of, std::span<const Segment> segments) {
    std::vector<std::uint8_t> hit(segments.size());
    of.mesh.tracer().occluded(segments, hit);
    return hit;
}

lightmesh::OpenLinks links_by_embree(const MeshToFill& of, const lightmesh::LinkWord& word) {
    std::vector<Segment> segments;
    for (int axis = 0; axis < 3; ++axis)
        for (int p = 0; p < 64; ++p)
            if ((word.cells >> p / 8 & 1) != 0)
                segments.push_back(of.mesh.link_segment(word, p, axis));
    const std::vector<std::uint8_t> hit = hits(of, segments);
    lightmesh::OpenLinks open{};
    std::size_t next = 0;
    for (std::uint64_t& of_axis : open)
        for (int p = 0; p < 64; ++p)
            if ((word.cells >> p / 8 & 1) != 0 && hit[next++] == 0)
                of_axis |= std::uint64_t{1} << p;
    return open;
}

std::uint64_t long_tests_by_embree(const MeshToFill& of, const lightmesh::LongTestWord& word) {
    std::vector<Segment> segments;
    for (std::uint64_t rest = word.points; rest != 0; rest &= rest - 1)
        segments.push_back(of.mesh.long_segment(word, std::countr_zero(rest)));
    const std::vector<std::uint8_t> hit = hits(of, segments);
    std::uint64_t seen = 0;
    std::size_t next = 0;
    for (std::uint64_t rest = word.points; rest != 0; rest &= rest - 1, ++next)
        seen |= hit[next] == 0 ? rest & (~rest + 1) : 0;
    return seen;
}

/// Has a list filled: fill(list, trace of words). Embree's words are what the mesh keeps.
template <class Word, class Answer, class List, class ListPart, class Fill, class Shaders, class ByEmbree>
Listed time_list(const MeshToFill& of, ListPart&& list_part, Fill&& fill, Shaders&& shaders,
                 ByEmbree&& by_embree) {
    Listed result;
    const demo::Stopwatch listing;
    const auto list = demo::list_on_all_threads<List>(of.asked, list_part);
    result.seconds_listing = listing.seconds();
    const demo::Stopwatch filling;
    fill(list, [&](std::span<const Word> words, std::span<Answer> answers) {
        const demo::Stopwatch watch;
        shaders(words, answers, nullptr);
        result.seconds_by_device += watch.seconds();
        const demo::Stopwatch watch_of_embree;
        std::vector<Answer> expected(words.size());
        tbb::parallel_for(std::size_t{0}, words.size(),
                          [&](std::size_t w) { expected[w] = by_embree(of, words[w]); });
        result.seconds_by_embree += watch_of_embree.seconds();
        result.words += words.size();
        for (std::size_t w = 0; w < words.size(); ++w) {
            result.differing += answers[w] != expected[w] ? 1u : 0u;
            answers[w] = expected[w];
        }
    });
    result.seconds_filling = filling.seconds();
    return result;
}

/// The links of a cold frame. Returns whether the words are Embree's.
bool time_links(const demo::ComputeDevice& device, const MeshToFill& of) {
    demo::LinkTests shaders(device, of.copy);
    shaders.bind(of.uploaded.bindings(demo::LinkTests::set));
    const Listed listed = time_list<lightmesh::LinkWord, lightmesh::OpenLinks, lightmesh::LinkList>(
        of, [&](auto some, auto& list) { of.mesh.list_links(some, list); },
        [&](const auto& list, auto&& trace) { of.mesh.fill_links(list, trace); }, shaders, links_by_embree);
    return listed.print(of, "links", shaders.spent());
}

/// The long tests of a cold frame. Returns whether the words are Embree's.
bool time_long_tests(const demo::ComputeDevice& device, const MeshToFill& of) {
    demo::LongTests shaders(device, of.copy);
    shaders.bind(of.uploaded.bindings(demo::LongTests::set));
    const Listed listed = time_list<lightmesh::LongTestWord, std::uint64_t, lightmesh::LongTestList>(
        of, [&](auto some, auto& list) { of.mesh.list_long_tests(some, list); },
        [&](const auto& list, auto&& trace) { of.mesh.fill(list, trace); },
        [&](auto words, auto seen, auto cancel) {
            shaders(words, seen, cancel);
            for (std::size_t w = 0; w < words.size(); ++w)
                seen[w] &= words[w].points;
        },
        long_tests_by_embree);
    return listed.print(of, "long tests", shaders.spent());
}

/// The rays to lamps of a cold frame by a visibility cache, made, traced and counted by shaders as the cache
/// lists what it lacks, and the same by the CPU. Returns whether the values are the same.
bool time_lamp_rays(const demo::ComputeDevice& device, const demo::Scene& scene, bool shaft_rows) {
    const demo::EmbreeScene embree(scene);
    demo::VisibilityOptions options = demo::options_of(scene);
    options.cache.shaft_rows = shaft_rows;
    const std::vector<lightmesh::SurfacePoint> points = points_to_fill(device, embree, 480);
    const demo::GpuScene copy(device, embree);
    demo::LampShares shaders(device, copy);
    const demo::SceneCache cache = demo::cache_of(embree, options);
    const demo::Stopwatch filling;
    demo::fill_by_lists(cache, points, [&](const lightmesh::LampRayList& list) {
        cache.fill_shares(list, [&](auto work, auto found) { shaders(work, found, nullptr); });
    });
    const double seconds = filling.seconds();
    const demo::SceneCache expected = demo::cache_of(embree, options);
    const demo::Stopwatch filling_on_cpu;
    demo::fill_by_lists(expected, points, [&](const lightmesh::LampRayList& list) {
        expected.fill(list, [&](auto segments, auto hit) { expected.tracer().occluded(segments, hit); });
    });
    const double seconds_on_cpu = filling_on_cpu.seconds();
    std::atomic<std::size_t> differing = 0;
    tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
        std::vector<float> found(cache.light_count());
        std::vector<float> of_cpu(cache.light_count());
        cache.visibility(points[i], found);
        expected.visibility(points[i], of_cpu);
        for (std::size_t l = 0; l < found.size(); ++l)
            differing += found[l] != of_cpu[l] ? 1u : 0u;
    });
    const demo::DeviceFill spent = shaders.spent();
    std::printf("| %s | %s | %llu | %zu | %.1f | %.1f | %.1f | %.6f |\n", scene.name.c_str(),
                shaft_rows ? "yes" : "no", static_cast<unsigned long long>(spent.rays), spent.dispatches,
                1e3 * seconds, 1e3 * spent.seconds_device, 1e3 * seconds_on_cpu,
                static_cast<double>(differing.load()) /
                    static_cast<double>((std::max)(points.size() * cache.light_count(), std::size_t{1})));
    std::fflush(stdout);
    return bench::are_nearly_all_same({differing.load(), points.size() * cache.light_count()});
}

struct Frame {
    bench::Differing pixels;  ///< from the CPU's, by more than a step
    double cold = 0.0;        ///< seconds
};
Frame time_frames(const demo::ComputeDevice& device, const demo::Scene& scene, const std::string& algorithm,
                  bool only_frames) {
    const demo::EmbreeScene embree(scene);
    const demo::VisibilityOptions visibility = demo::options_of(scene);
    demo::RenderOptions options;
    const bool is_filled = algorithm != "whitted";
    options.width = !device.is_cpu() ? 1920 : is_filled && !only_frames ? 24 : 160;
    options.height = options.width * 3 / 4;
    demo::RenderStatistics statistics;
    const auto shadows = demo::make_visibility(algorithm, embree, visibility);
    const demo::Image expected = demo::render(embree, *shadows, options, statistics);
    const double cold_on_cpu = statistics.seconds;
    demo::GpuRenderer renderer(device, algorithm, embree, visibility, options);
    const demo::GpuPicture first = renderer.render(statistics);
    const double cold = statistics.seconds;
    // Of times, which mean nothing on a CPU that plays a GPU.
    const demo::GpuPicture second = device.is_cpu() ? first : renderer.render(statistics);
    const double others = demo::share_beyond_one_step(expected, first.linear);
    std::printf("| %s | %s | %d x %d | %.1f | %.1f | %.1f | %.1f | %llu | %zu | %.4f |\n", scene.name.c_str(),
                algorithm.c_str(), options.width, options.height, 1e3 * cold_on_cpu, 1e3 * cold,
                1e3 * statistics.seconds, 1e3 * second.seconds_device,
                static_cast<unsigned long long>(renderer.filled().rays), renderer.filled().dispatches,
                100.0 * others);
    std::fflush(stdout);
    const std::size_t pixels = expected.pixels.size();
    return {{static_cast<std::size_t>(std::lround(others * static_cast<double>(pixels))), pixels}, cold};
}

bool run_rays_and_fills(const demo::ComputeDevice& device) {
    std::printf("| scene | rays | how | number | ms | G rays/s | differ from Embree's "
                "|\n|---|---|---|--:|--:|--:|--:|\n");
    bool are_same = true;
    for (const demo::Scene& scene : {demo::make_park(), demo::make_rooms()}) {
        const demo::EmbreeScene embree(scene);
        const bench::ShadingPoints points(embree, device.is_cpu() ? 160 : 1920, device.is_cpu() ? 112 : 1440);
        for (const demo::ComputeDevice& one : bench::by_each_traversal(device))
            are_same &= time_rays(one, embree, points);
    }
    std::printf(
        "\n| scene | to fill | words | rays | links that the host has traced | dispatches | listing: ms "
        "| by the device: ms | of that shaders: ms | storing: ms | by Embree, on all threads: ms | words "
        "that differ from Embree's |\n"
        "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    for (const demo::Scene& scene : {demo::make_park(), demo::make_rooms(), demo::make_spheres()}) {
        const MeshToFill mesh(device, scene);
        are_same &= time_links(device, mesh);
        are_same &= time_long_tests(device, mesh);
    }
    std::printf("\n| scene | shaft rows | rays to lamps | dispatches | filling: ms | of that "
                "shaders: ms | by Embree, on all threads: ms | share of values that differ from Embree's |\n"
                "|---|---|--:|--:|--:|--:|--:|--:|\n");
    for (const demo::Scene& scene : {demo::make_park(), demo::make_rooms(), demo::make_spheres()})
        for (const bool shaft_rows : {false, true})
            are_same &= time_lamp_rays(device, scene, shaft_rows);
    return are_same;
}

/// Whole pictures, and nothing else.
struct OnlyFrames {
    bool is_wanted = false;
    std::string scene{};  ///< of this one; empty: of all
};

bool run(const demo::ComputeDevice& device, const OnlyFrames& only_frames) {
    bool are_same = only_frames.is_wanted || run_rays_and_fills(device);
    std::printf("\n| scene | shadows | picture | CPU, cold: ms | device and host, cold: ms | again: ms | of "
                "that shaders: ms | rays to fill, by shaders | their dispatches | pixels that differ by more "
                "than a step, %% |\n"
                "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    bench::Differing pixels;
    std::vector<std::pair<std::string, Frame>> of_park;
    for (const demo::Scene& scene : {demo::make_park(), demo::make_rooms(), demo::make_spheres()}) {
        if (!only_frames.scene.empty() && scene.name != only_frames.scene)
            continue;
        for (const std::string algorithm : {"whitted", "cache", "linked", "express"}) {
            const Frame frame = time_frames(device, scene, algorithm, only_frames.is_wanted);
            are_same &= bench::are_nearly_all_same(frame.pixels);
            pixels.count += frame.pixels.count;
            pixels.all += frame.pixels.all;
            if (scene.name == "park")
                of_park.emplace_back(algorithm, frame);
        }
    }
    if (pixels.all == 0) {
        std::fprintf(stderr, "there is no scene %s: there are park, rooms and spheres\n",
                     only_frames.scene.c_str());
        return false;
    }
    bench::targets::begin(device);
    bench::targets::few_differ("whole pictures, all of these shadows: pixels beyond one grey step", pixels,
                               bench::most_differing);
    for (const auto& [algorithm, frame] : of_park) {
        if (algorithm == "cache")
            bench::targets::at_most("cold frame on the card: park, cache, ms", frame.pixels, 60.0,
                                    1e3 * frame.cold, 0);
        if (algorithm == "linked")
            bench::targets::at_most("cold frame on the card: park, Linked, ms", frame.pixels, 15.0,
                                    1e3 * frame.cold, 0);
    }
    return are_same;
}

}  // namespace

int main(int argc, char** argv) {
    OnlyFrames only_frames;
    int skipped = 0;
    if (argc > 1 && std::string_view(argv[1]) == "--frames") {
        only_frames.is_wanted = true;
        skipped = 1;
        if (argc > 2 && !std::string_view(argv[2]).starts_with("--"))
            only_frames.scene = argv[++skipped];
    }
    argv[skipped] = argv[0];
    return bench::run_on_device("lightmesh-gpu-frame-benchmark", argc - skipped, argv + skipped,
                                [&](const demo::ComputeDevice& device) { return run(device, only_frames); });
}
