// SPDX-License-Identifier: MIT

// The rows of "Scenes that move": what a frame costs after something has moved, over a frame in which nothing
// has. One thread, the park under 64 lights; of the caches' frame a part, since its first fill takes minutes.

#include "lamp_share.hpp"
#include "mesh_frame.hpp"
#include "workloads.hpp"

#include <lightmesh/lightmesh.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace {

using bench::seconds;

using Cache = lightmesh::VisibilityCache<demo::EmbreeIntersector>;

/// Asks for all lights at all points, tile by tile.
template <class Subject>
void ask_all(const Subject& subject, const bench::ShadingPoints& points) {
    std::vector<float> values;
    for (std::size_t t = 0; t < points.tile_count(); ++t) {
        const bench::Points tile = points.tile(t);
        values.resize(tile.size() * subject.light_count());
        subject.visibility(tile.positions, tile.normals, values);
    }
}

/// What was found for the points, as one number: of the same values the same.
template <class Subject>
double sum_of(const Subject& subject, const bench::ShadingPoints& points) {
    const bench::ShadingPoints sample = points.sample(20);
    std::vector<float> values;
    double sum = 0.0;
    for (std::size_t t = 0; t < sample.tile_count(); ++t) {
        const bench::Points tile = sample.tile(t);
        values.resize(tile.size() * subject.light_count());
        subject.visibility(tile.positions, tile.normals, values);
        for (std::size_t i = 0; i < values.size(); ++i)
            sum += static_cast<double>(values[i]) * static_cast<double>(1 + i % 97);
    }
    return sum;
}

/// The least times of some frames: after a change, of it what the change itself took, and of the frames after
/// those, in which nothing changes.
constexpr int frames = 6;
struct MovingTime {
    double frame = 1e9;
    double update = 0.0;
    double warm = 1e9;
};
template <class Subject, class Change>
MovingTime time_frames(Subject& subject, const bench::ShadingPoints& points, const Change& change) {
    MovingTime least;
    for (int frame = 0; frame < frames; ++frame) {
        const double update = seconds([&] { change(frame); });
        const double all = update + seconds([&] { ask_all(subject, points); });
        if (all < least.frame) {
            least.frame = all;
            least.update = update;
        }
        least.warm = (std::min)(least.warm, seconds([&] { ask_all(subject, points); }));
    }
    return least;
}

void print(const std::string& what, const MovingTime& time, double to_reach) {
    std::vector<char> text(120);
    std::snprintf(text.data(), text.size(), "%.3g s a warm frame; the update itself %.2g of it", time.warm,
                  time.update / time.warm);
    bench::print_row(what + ", over the warm frame", time.frame / time.warm, to_reach, false, text.data());
}

template <class Subject, class Make>
void time_moves(const std::string& name, const Make& make, const bench::ShadingPoints& points,
                double light_to_reach) {
    Subject subject = make();
    ask_all(subject, points);
    const std::vector<lightmesh::Light> lights(subject.lights().begin(), subject.lights().end());
    constexpr std::size_t mover = 17;
    const auto moved = [&](int frame) {
        auto light = std::get<lightmesh::PointLight>(lights[mover]);
        light.position.x += 0.1f * static_cast<float>(frame + 1);
        return light;
    };
    print(name + ": one of 64 lights moves a little each frame",
          time_frames(subject, points, [&](int frame) { subject.set_light(mover, moved(frame)); }),
          light_to_reach);
    print(name + ": all 64 lights' strengths change",
          time_frames(subject, points,
                      [&](int) {
                          for (std::size_t i = 0; i < lights.size(); ++i)
                              subject.set_light(i, subject.lights()[i]);
                      }),
          1.05);
    // A box of the size of a swing, which stands for what moves in it.
    const lightmesh::Bounds swing{{-3.0f, -2.0f, 0.5f}, {-2.0f, -0.5f, 2.0f}};
    print(name + ": a swing moves", time_frames(subject, points, [&](int) { subject.scene_changed(swing); }),
          1.5);
    const double sum = sum_of(subject, points);
    Subject fresh = make();
    fresh.set_light(mover, moved(frames - 1));
    std::printf("| %s: what a new one finds for the last frame | %s | | | |\n", name.c_str(),
                sum_of(fresh, points) == sum ? "the same" : "NOT THE SAME");
}

}  // namespace

int main() {
    bench::print_head();
    const bench::Workload& park = bench::workload("park", 64);
    time_moves<bench::Mesh>(
        "Linked", [&] { return bench::make_mesh(park, lightmesh::ShortTest::linked); }, park.points, 1.15);
    std::vector<lightmesh::Light> lamps = bench::lights_of(park);
    for (lightmesh::Light& lamp : lamps)
        std::get<lightmesh::PointLight>(lamp).radius = 1.0f;
    time_moves<Cache>(
        "cache",
        [&] {
            return Cache{park.scene.intersector(), lamps,
                         lightmesh::CacheSettings{.spacing = 0.25f * park.radius}};
        },
        park.points.part(40000), 2.0);
}
