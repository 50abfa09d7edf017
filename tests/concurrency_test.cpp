// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <latch>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

// Many threads on a cold mesh, each in an order of its own: the same bits as one thread. Meant for
// ThreadSanitizer.

namespace concurrency_test {

namespace {

using lightmesh::ShortTest;

constexpr int thread_count = 8;

struct Work {
    std::vector<test::Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<test::SurfacePoint> points;
    lightmesh::Settings settings;
};

Work work_of(ShortTest short_test, int lights, std::uint64_t seed) {
    test::Random random(seed);
    Work work;
    work.scene = test::thin_walls(random);
    work.lights = test::random_lights(random, lights);
    work.points = test::surface_points(random, work.scene, 40);
    work.settings.radius = 0.8f;
    work.settings.quality = 2.0f;
    work.settings.short_test = short_test;
    return work;
}

struct BatchTracer {
    const std::vector<test::Triangle>* triangles;

    bool occluded(const lightmesh::Segment& segment) const {
        return test::PlainTracer{triangles}.occluded(segment);
    }
    void occluded(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) const {
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = occluded(segments[i]) ? 1 : 0;
    }
};

/// Fails now and then, on any thread.
struct UnreliableTracer {
    const std::vector<test::Triangle>* triangles;
    std::atomic<unsigned>* calls;

    bool occluded(const lightmesh::Segment& segment) const {
        if (calls->fetch_add(1, std::memory_order_relaxed) % 512 == 511)
            throw std::runtime_error("the tracer failed");
        return test::PlainTracer{triangles}.occluded(segment);
    }
};

/// The values of all points, asked for in the given order; `mixed` asks for some of them light by light.
template <class Mesh>
std::vector<float> values_in_order(const Mesh& mesh, const Work& work, const std::vector<std::size_t>& order,
                                   bool mixed) {
    const std::size_t lights = work.lights.size();
    std::vector<float> values(work.points.size() * lights, -1.0f);
    for (const std::size_t i : order) {
        const test::SurfacePoint& p = work.points[i];
        const std::span<float> all = std::span(values).subspan(i * lights, lights);
        if (mixed && i % 2 == 0) {
            for (std::size_t light = lights; light-- > 0;)
                all[light] = mesh.visibility(p.position, p.normal, light);
        } else {
            mesh.visibility(p.position, p.normal, all);
        }
    }
    return values;
}

/// Retries each query until the tracer lets it through.
template <class Mesh>
std::vector<float> values_with_retries(const Mesh& mesh, const Work& work,
                                       const std::vector<std::size_t>& order) {
    const std::size_t lights = work.lights.size();
    std::vector<float> values(work.points.size() * lights, -1.0f);
    for (const std::size_t i : order) {
        for (bool done = false; !done;) {
            try {
                mesh.visibility(work.points[i].position, work.points[i].normal,
                                std::span(values).subspan(i * lights, lights));
                done = true;
            } catch (const std::runtime_error&) {
            }
        }
    }
    return values;
}

std::vector<std::size_t> order_of(const Work& work, int thread) {
    std::vector<std::size_t> order(work.points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    if (thread == 1)
        std::reverse(order.begin(), order.end());
    if (thread > 1)
        test::Random(static_cast<std::uint64_t>(thread)).shuffle(order);
    return order;
}

/// Runs query(thread) on all threads, which start together.
template <class Query>
std::vector<std::vector<float>> on_many_threads(Query&& query) {
    std::vector<std::vector<float>> values(thread_count);
    std::latch start(thread_count);
    {
        std::vector<std::jthread> threads;
        for (int t = 0; t < thread_count; ++t) {
            threads.emplace_back([&, t] {
                start.arrive_and_wait();
                values[static_cast<std::size_t>(t)] = query(t);
            });
        }
    }
    return values;
}

template <class Tracer>
void check_against_one_thread(const Tracer& tracer, const Work& work) {
    const lightmesh::LightMesh alone{tracer, work.lights, work.settings};
    const std::vector<float> expected = values_in_order(alone, work, order_of(work, 0), false);
    for (int round = 0; round < 4; ++round) {
        const lightmesh::LightMesh shared{tracer, work.lights, work.settings};
        const auto found = on_many_threads([&](int thread) {
            return values_in_order(shared, work, order_of(work, thread), round % 2 == 1);
        });
        for (const std::vector<float>& values : found)
            CHECK(values == expected);
        // With links it depends on what was known to be uniform whether a point needed them.
        if (work.settings.short_test != ShortTest::linked) {
            CHECK(shared.statistics().light_points == alone.statistics().light_points);
            CHECK(shared.statistics().bricks == alone.statistics().bricks);
        }
    }
}

}  // namespace

TEST_CASE("the order of queries does not change a bit") {
    for (const ShortTest short_test : test::all_short_tests) {
        const Work work = work_of(short_test, 20, 21);
        const test::PlainTracer tracer{&work.scene};
        const lightmesh::LightMesh forwards{tracer, work.lights, work.settings};
        const std::vector<float> expected = values_in_order(forwards, work, order_of(work, 0), false);
        const auto between = [](float s) {
            return s > 0.0f && s < 1.0f;
        };
        CHECK(std::count_if(expected.begin(), expected.end(), between) > 10);
        for (int order = 0; order < 6; ++order) {
            const lightmesh::LightMesh mesh{tracer, work.lights, work.settings};
            CHECK(values_in_order(mesh, work, order_of(work, order), order % 2 == 0) == expected);
            CHECK(values_in_order(mesh, work, order_of(work, order + 1), order % 2 == 1) == expected);
        }
    }
}

TEST_CASE("many threads on a cold mesh give the same bits as one") {
    for (const ShortTest short_test : test::all_short_tests) {
        const Work few = work_of(short_test, 5, 22);
        check_against_one_thread(test::PlainTracer{&few.scene}, few);
        const Work many = work_of(short_test, 70, 23);
        check_against_one_thread(test::PlainTracer{&many.scene}, many);
        check_against_one_thread(BatchTracer{&many.scene}, many);
    }
}

TEST_CASE("a tracer that fails on some threads loses and changes nothing") {
    for (const ShortTest short_test : test::all_short_tests) {
        const Work work = work_of(short_test, 10, 24);
        const lightmesh::LightMesh alone{test::PlainTracer{&work.scene}, work.lights, work.settings};
        const std::vector<float> expected = values_in_order(alone, work, order_of(work, 0), false);
        std::atomic<unsigned> calls{0};
        const lightmesh::LightMesh shared{UnreliableTracer{&work.scene, &calls}, work.lights, work.settings};
        const auto found = on_many_threads(
            [&](int thread) { return values_with_retries(shared, work, order_of(work, thread)); });
        for (const std::vector<float>& values : found)
            CHECK(values == expected);
        CHECK(calls.load() > 512);
    }
}

TEST_CASE("statistics may be read while other threads query") {
    const Work work = work_of(ShortTest::none, 20, 25);
    const lightmesh::LightMesh mesh{test::PlainTracer{&work.scene}, work.lights, work.settings};
    std::atomic<bool> done{false};
    std::jthread reader([&] {
        std::size_t before = 0;
        while (!done.load()) {
            const std::size_t now = mesh.statistics().light_points;
            CHECK(now >= before);
            before = now;
        }
    });
    on_many_threads([&](int thread) { return values_in_order(mesh, work, order_of(work, thread), false); });
    done = true;
}

}  // namespace concurrency_test
