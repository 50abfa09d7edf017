// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

// Long tests and links that are listed, and traced by the caller.

namespace long_test_list_test {

namespace {

using lightmesh::LightMesh;
using lightmesh::LongTestList;
using lightmesh::LongTestWord;
using lightmesh::ShortTest;
using Mesh = LightMesh<test::PlainTracer>;

struct Work {
    std::vector<test::Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<lightmesh::SurfacePoint> points;
    lightmesh::Settings settings{.radius = 0.8f, .quality = 3.0f};

    explicit Work(std::uint64_t seed, int light_count = 11) {
        test::Random random(seed);
        scene = seed % 2 == 0 ? test::thin_walls(random) : test::boxes_on_floor(random, 12);
        lights = test::random_lights(random, light_count);
        for (const test::SurfacePoint& p : test::surface_points(random, scene, 80))
            points.push_back({.position = p.position, .normal = p.normal});
    }

    Mesh mesh(ShortTest short_test, bool adaptive = true) const {
        lightmesh::Settings chosen = settings;
        chosen.short_test = short_test;
        chosen.adaptive_long_tests = adaptive;
        return Mesh{test::PlainTracer{&scene}, lights, chosen};
    }
};

/// The caller's tracer: plain rays along the segments that the mesh names.
struct PlainWords {
    const Mesh& mesh;
    std::size_t calls = 0;
    std::uint64_t rays = 0;
    std::size_t most_words = 0;
    std::size_t throws_in_call = (std::numeric_limits<std::size_t>::max)();

    void operator()(std::span<const LongTestWord> words, std::span<std::uint64_t> seen) {
        REQUIRE(words.size() == seen.size());
        REQUIRE(!words.empty());
        REQUIRE(words.size() <= lightmesh::most_long_test_words);
        if (calls++ == throws_in_call)
            throw std::runtime_error("the device was lost");
        most_words = (std::max)(most_words, words.size());
        for (std::size_t w = 0; w < words.size(); ++w) {
            CHECK(words[w].level == words.front().level);
            CHECK(words[w].points != 0);
            // What was not asked for must not matter.
            seen[w] = ~words[w].points;
            for (std::uint64_t rest = words[w].points; rest != 0; rest &= rest - 1, ++rays) {
                const int p = std::countr_zero(rest);
                if (!mesh.tracer().occluded(mesh.long_segment(words[w], p)))
                    seen[w] |= std::uint64_t{1} << p;
            }
        }
    }
};

std::vector<float> ask(const Mesh& mesh, std::span<const lightmesh::SurfacePoint> points) {
    std::vector<float> all(points.size() * mesh.light_count());
    mesh.visibility(points, all);
    return all;
}

/// As threads would do it: a list for each part, put together.
LongTestList list_in_parts(const Mesh& mesh, std::span<const lightmesh::SurfacePoint> points) {
    LongTestList all;
    for (std::size_t first = 0; first < points.size(); first += 40) {
        LongTestList part;
        mesh.list_long_tests(points.subspan(first, (std::min)(points.size() - first, std::size_t{40})), part);
        all.add(part);
    }
    return all;
}

}  // namespace

TEST_CASE("long test lists: a word's light points are those of its brick, along the mesh's own segments") {
    const Work work(801);
    const Mesh mesh = work.mesh(ShortTest::none);
    const lightmesh::detail::LightTable table(work.lights, mesh.grid());
    const LongTestWord word{{3, -2, 7}, 4, 4, 0, ~std::uint64_t{0}};
    for (int p = 0; p < 64; ++p) {
        const glm::ivec3 index(4 * 3 + (p & 1) + 2 * (p >> 3 & 1), -4 * 2 + (p >> 1 & 1) + 2 * (p >> 4 & 1),
                               4 * 7 + (p >> 2 & 1) + 2 * (p >> 5 & 1));
        const lightmesh::Segment expected = table.long_segment(4, mesh.grid().position(index));
        CHECK(mesh.long_segment(word, p).origin == expected.origin);
        CHECK(mesh.long_segment(word, p).target == expected.target);
    }
}

TEST_CASE("long test lists: what the caller traces is what the mesh would have found, to the bit") {
    for (const bool adaptive : {true, false}) {
        for (const std::uint64_t seed : {802u, 803u}) {
            const Work work(seed, 70);
            const Mesh expected = work.mesh(ShortTest::none, adaptive);
            expected.fill(work.points);
            const Mesh mesh = work.mesh(ShortTest::none, adaptive);
            const LongTestList list = list_in_parts(mesh, work.points);
            CHECK(!list.is_empty());
            PlainWords trace{mesh};
            mesh.fill(list, trace);
            CHECK(mesh.snapshot() == expected.snapshot());
            const lightmesh::MeshStatistics held = mesh.statistics();
            CHECK(held.long_rays == 0);
            CHECK(held.listed_rays == trace.rays);
            CHECK(held.long_tests == trace.rays);
            // Cells that are found later ask for their samples again.
            const std::uint64_t of_fill = expected.statistics().long_rays;
            CHECK(trace.rays <= of_fill);
            CHECK((adaptive ? 10 * trace.rays > 9 * of_fill : trace.rays == of_fill));
            // Of each of two tiles of lights the samples and the others.
            CHECK(trace.calls == (adaptive ? 4 : 2));
            CHECK(trace.most_words > 1000);
            CHECK(list_in_parts(mesh, work.points).is_empty());
        }
    }
}

TEST_CASE("long test lists: linked and exact queries, which trace no long ray then") {
    for (const ShortTest short_test : {ShortTest::linked, ShortTest::exact}) {
        const Work work(804);
        const Mesh expected = work.mesh(short_test);
        const std::vector<float> values = ask(expected, work.points);
        const Mesh mesh = work.mesh(short_test);
        mesh.fill(list_in_parts(mesh, work.points), PlainWords{mesh});
        CHECK(ask(mesh, work.points) == values);
        CHECK(mesh.statistics().long_rays == 0);
        CHECK(mesh.statistics().listed_rays > 10000);
    }
}

TEST_CASE("link lists: queries find nearly all links there, and give the same values") {
    Work work(809);
    for (std::size_t i = 0; i < work.points.size(); i += 3)
        work.points[i].footprint = 0.5f;
    const Mesh expected = work.mesh(ShortTest::linked);
    const std::vector<float> values = ask(expected, work.points);
    const Mesh mesh = work.mesh(ShortTest::linked);
    lightmesh::LinkList links;
    for (std::size_t first = 0; first < work.points.size(); first += 20) {
        lightmesh::LinkList part;
        mesh.list_links(std::span(work.points).subspan(first, 20), part);
        links.add(part);
    }
    CHECK(!links.is_empty());
    std::uint64_t rays = 0;
    const auto trace = [&](std::span<const lightmesh::LinkWord> words, std::span<lightmesh::OpenLinks> open) {
        REQUIRE(words.size() == open.size());
        for (std::size_t i = 0; i < words.size(); ++i)
            for (int p = 0; p < 64; ++p)
                for (int axis = 0; axis < 3; ++axis) {
                    // What was not asked for means nothing.
                    const bool is_asked = (words[i].cells >> p / 8 & 1) != 0;
                    rays += is_asked ? 1u : 0u;
                    if (!is_asked || !mesh.tracer().occluded(mesh.link_segment(words[i], p, axis)))
                        open[i][static_cast<std::size_t>(axis)] |= std::uint64_t{1} << p;
                }
    };
    CHECK_THROWS_AS(
        mesh.fill_links(links, [](auto, auto) { throw std::runtime_error("the device was lost"); }),
        std::runtime_error);
    mesh.fill_links(links, trace);
    CHECK(rays > 1000);
    CHECK(mesh.statistics().listed_link_rays == rays);
    CHECK(mesh.statistics().link_rays == 0);
    mesh.fill_links(links, trace);
    CHECK(mesh.statistics().listed_link_rays == rays);
    mesh.fill(list_in_parts(mesh, work.points), PlainWords{mesh});
    CHECK(ask(mesh, work.points) == values);
    CHECK(mesh.statistics().link_rays < expected.statistics().link_rays / 20);
    MESSAGE(rays << " links by the caller, then " << mesh.statistics().link_rays << " of "
                 << expected.statistics().link_rays);
    lightmesh::LinkList none;
    work.mesh(ShortTest::none).list_links(work.points, none);
    CHECK(none.is_empty());
}

TEST_CASE("long test lists: points of several levels, some between two") {
    Work work(805);
    for (std::size_t i = 0; i < work.points.size(); ++i)
        work.points[i].footprint = 0.02f * static_cast<float>(i);
    const Mesh expected = work.mesh(ShortTest::none);
    expected.fill(work.points);
    const Mesh mesh = work.mesh(ShortTest::none);
    mesh.fill(list_in_parts(mesh, work.points), PlainWords{mesh});
    CHECK(mesh.statistics().light_points_of_level[2] > 0);
    CHECK(mesh.snapshot() == expected.snapshot());
}

TEST_CASE(
    "long test lists: after an update only what was forgotten is listed, and an old list does no harm") {
    const Work work(806);
    Mesh mesh = work.mesh(ShortTest::none);
    const LongTestList old = list_in_parts(mesh, work.points);
    mesh.fill(old, PlainWords{mesh});
    const std::uint64_t before = mesh.statistics().listed_rays;
    const lightmesh::Light moved = lightmesh::PointLight{.position = {0.3f, 0.2f, 2.5f}};
    mesh.set_light(2, moved);
    mesh.fill(list_in_parts(mesh, work.points), PlainWords{mesh});
    mesh.fill(old, PlainWords{mesh});
    const std::uint64_t after = mesh.statistics().listed_rays;
    CHECK(after > before);
    CHECK(after - before < before / 4);
    Work other = work;
    other.lights[2] = moved;
    CHECK(ask(mesh, work.points) == ask(other.mesh(ShortTest::none), work.points));
    CHECK(mesh.statistics().long_rays == 0);
}

TEST_CASE("long test lists: a tracer that throws stores nothing of its call, and may go on") {
    const Work work(807);
    const Mesh expected = work.mesh(ShortTest::none);
    expected.fill(work.points);
    const Mesh mesh = work.mesh(ShortTest::none);
    const LongTestList list = list_in_parts(mesh, work.points);
    for (const std::size_t call : {0u, 1u}) {
        PlainWords trace{mesh};
        trace.throws_in_call = call;
        CHECK_THROWS_AS(mesh.fill(list, trace), std::runtime_error);
        CHECK(mesh.statistics().light_points == 0);
    }
    mesh.fill(list, PlainWords{mesh});
    CHECK(mesh.snapshot() == expected.snapshot());
}

TEST_CASE("long test lists: of no points and of no lights there is nothing to trace") {
    Work work(808);
    const Mesh mesh = work.mesh(ShortTest::linked);
    const LongTestList none = list_in_parts(mesh, {});
    CHECK(none.is_empty());
    work.lights.clear();
    const Mesh dark = work.mesh(ShortTest::linked);
    const LongTestList list = list_in_parts(dark, work.points);
    CHECK(list.is_empty());
    PlainWords trace{dark};
    dark.fill(list, trace);
    CHECK(trace.calls == 0);
}

}  // namespace long_test_list_test
