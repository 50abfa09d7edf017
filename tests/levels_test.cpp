// SPDX-License-Identifier: MIT
#include "analytic.hpp"
#include "plain.hpp"
#include "random_scene.hpp"
#include "snapshot_bytes.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

// Levels of a light mesh by footprints: each equals a mesh of its radius, and between two they are blended.

namespace levels_test {

namespace {

using lightmesh::ShortTest;
using lightmesh::SurfacePoint;
using Mesh = lightmesh::LightMesh<test::PlainTracer>;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

struct Work {
    std::vector<test::Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<SurfacePoint> points;
    lightmesh::Settings settings;

    Work(ShortTest short_test, int light_count, int point_count = 30) {
        test::Random random(57);
        scene = test::thin_walls(random);
        lights = test::random_lights(random, light_count);
        for (const test::SurfacePoint& p : test::surface_points(random, scene, point_count))
            points.push_back({.position = p.position, .normal = p.normal});
        settings.radius = 0.3f;
        settings.quality = 2.0f;
        settings.short_test = short_test;
        settings.footprint_scale = 2.0f;
    }

    Mesh mesh() const { return Mesh{test::PlainTracer{&scene}, lights, settings}; }

    /// A mesh without levels, of the radius of a level.
    Mesh plain_mesh(int level) const {
        lightmesh::Settings plain = settings;
        plain.radius = std::ldexp(settings.radius, level);
        plain.footprint_scale = 0.0f;
        return Mesh{test::PlainTracer{&scene}, lights, plain};
    }

    /// A footprint so many octaves wider than what level 0 ends at: the whole part is the level.
    float footprint(double octaves) const {
        return static_cast<float>(0.5 * static_cast<double>(settings.radius / settings.quality) /
                                  static_cast<double>(settings.footprint_scale) * std::exp2(octaves));
    }

    SurfacePoint with(std::size_t point, float footprint) const {
        SurfacePoint at = points[point];
        at.footprint = footprint;
        return at;
    }
};

template <class AnyMesh>
std::vector<float> ask(const AnyMesh& mesh, const SurfacePoint& point) {
    std::vector<float> all(mesh.light_count());
    mesh.visibility(point, all);
    return all;
}

template <class AnyMesh>
std::vector<float> ask_plainly(const AnyMesh& mesh, const SurfacePoint& point) {
    std::vector<float> all(mesh.light_count());
    mesh.visibility(point.position, point.normal, all);
    return all;
}

/// Each point's row from a mesh of its own query.
std::vector<float> ask_one_by_one(const Mesh& mesh, std::span<const SurfacePoint> points) {
    std::vector<float> all;
    for (const SurfacePoint& point : points) {
        const std::vector<float> row = ask(mesh, point);
        all.insert(all.end(), row.begin(), row.end());
    }
    return all;
}

/// The points of `work`, with footprints of all sizes in no order.
std::vector<SurfacePoint> mixed_points(const Work& work) {
    test::Random random(3);
    std::vector<SurfacePoint> points;
    for (std::size_t i = 0; i < work.points.size(); ++i)
        points.push_back(work.with(i, work.footprint(random.uniform(-1.0, 4.0))));
    points[1].footprint = 0.0f;
    points[2].footprint = not_a_number;
    points[3].footprint = -1.0f;
    return points;
}

bool equal(std::span<const float> a, std::span<const float> b) {
    return std::ranges::equal(a, b, [](float x, float y) { return x == y || (x != x && y != y); });
}

using lightmesh::detail::SnapshotHeader;
using lightmesh::detail::SnapshotLevelRecord;

SnapshotHeader header_of(const test::Bytes& bytes) {
    SnapshotHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    return header;
}

std::vector<std::uint64_t> levels_of(const test::Bytes& bytes) {
    const SnapshotHeader header = header_of(bytes);
    const lightmesh::detail::SnapshotSection& section = header.sections[lightmesh::detail::levels_section];
    std::vector<std::uint64_t> levels;
    for (std::size_t i = 0; i < section.count; ++i) {
        SnapshotLevelRecord record;
        std::memcpy(&record, bytes.data() + section.offset + i * sizeof record, sizeof record);
        levels.push_back(record.level);
    }
    return levels;
}

/// A tracer that fails every so often, until it has been asked often.
struct UnreliableTracer {
    const std::vector<test::Triangle>* triangles;
    unsigned* calls;

    bool occluded(const lightmesh::Segment& segment) const {
        if (++*calls % 97 == 0 && *calls < 5000)
            throw std::runtime_error("the tracer failed");
        return test::PlainTracer{triangles}.occluded(segment);
    }
};

/// Counts the pictures that are asked of it.
struct CountingRenderer {
    test::BoxRenderer renderer;
    int* pictures;

    void render_depth(const lightmesh::DepthView& view, std::span<float> distances) {
        ++*pictures;
        renderer.render_depth(view, distances);
    }
};

}  // namespace

TEST_CASE("levels: the least one whose step is wider than the footprint, blended in the last fifth") {
    lightmesh::Settings settings;
    settings.radius = 1.0f;
    settings.quality = 4.0f;
    settings.footprint_scale = 0.5f;
    const lightmesh::detail::LevelRule rule(settings);
    const auto level_at = [&](double octaves) {
        return rule(static_cast<float>(0.5 * std::exp2(octaves)));
    };
    for (int k = 0; k < 20; ++k) {
        for (const double within : {0.01, 0.4, 0.79}) {
            CHECK(level_at(k + within).level == k + 1);
            CHECK_FALSE(level_at(k + within).is_between());
        }
        const lightmesh::detail::LevelChoice between = level_at(k + 0.9);
        CHECK(between.level == k + 1);
        CHECK(between.coarser_share ==
              doctest::Approx((std::exp2(-0.1) - std::exp2(-0.2)) / (1.0 - std::exp2(-0.2))));
    }
    CHECK(level_at(-0.21).level == 0);
    CHECK_FALSE(level_at(-0.21).is_between());
    CHECK(level_at(-0.1).level == 0);
    CHECK(level_at(-0.1).is_between());
    for (const float none : {0.0f, -0.0f, -1.0f, -infinity, not_a_number, 1e-40f}) {
        CHECK(rule(none).level == 0);
        CHECK_FALSE(rule(none).is_between());
    }
    for (const float wide : {infinity, 1e38f, 1e9f}) {
        CHECK(rule(wide).level == 24);
        CHECK_FALSE(rule(wide).is_between());
    }
}

TEST_CASE("levels: as many as have a radius up to 1e18, and none with a scale of 0") {
    lightmesh::Settings settings;
    for (const auto& [radius, coarsest] : {std::pair(1e18f, 0), std::pair(4e17f, 1), std::pair(1e17f, 3),
                                           std::pair(1.0f, 24), std::pair(1e-44f, 24)}) {
        settings.radius = radius;
        const lightmesh::detail::LevelRule rule(settings);
        CHECK(rule.coarsest() == coarsest);
        CHECK(rule(infinity).level == coarsest);
        for (float footprint = 1e-45f; footprint < 1e38f; footprint *= 1.9f) {
            const auto choice = rule(footprint);
            CHECK(choice.level >= 0);
            CHECK(choice.level + (choice.is_between() ? 1 : 0) <= coarsest);
        }
    }
    settings.radius = 1.0f;
    settings.footprint_scale = 0.0f;
    const lightmesh::detail::LevelRule none(settings);
    for (const float footprint : {1.0f, 1e38f, infinity, not_a_number})
        CHECK(none(footprint).level == 0);
}

TEST_CASE("levels: a scale that is negative or not finite is named") {
    Work work(ShortTest::none, 1);
    for (const float wrong : {-1.0f, infinity, not_a_number}) {
        work.settings.footprint_scale = wrong;
        std::string said;
        try {
            work.mesh();
        } catch (const std::invalid_argument& error) {
            said = error.what();
        }
        CHECK(said.find("Settings::footprint_scale is ") != std::string::npos);
    }
}

TEST_CASE("levels: a footprint that is small, unknown or turned off changes nothing") {
    for (const ShortTest short_test : test::all_short_tests) {
        Work work(short_test, 12);
        const Mesh with_levels = work.mesh();
        const Mesh plain = work.plain_mesh(0);
        for (std::size_t i = 0; i < work.points.size(); ++i) {
            const std::vector<float> expected = ask_plainly(plain, work.points[i]);
            CHECK(ask_plainly(with_levels, work.points[i]) == expected);
            for (const float footprint : {0.0f, -3.0f, not_a_number, 1e-30f, work.footprint(0.79)})
                CHECK(ask(with_levels, work.with(i, footprint)) == expected);
            for (const float footprint : {1.0f, 1e30f, infinity})
                CHECK(ask(plain, work.with(i, footprint)) == expected);
        }
        const lightmesh::MeshStatistics held = with_levels.statistics();
        CHECK(held.light_points_of_level[0] == held.light_points);
        CHECK(held.bytes_of_level[1] == 0);
    }
}

TEST_CASE("levels: each equals a mesh of its radius to the bit") {
    for (const ShortTest short_test : test::all_short_tests) {
        for (const glm::vec3& origin : {lightmesh::Settings{}.origin, glm::vec3(0.1f, 0.2f, 0.3f)}) {
            Work work(short_test, 9, 20);
            work.settings.origin = origin;
            const Mesh mesh = work.mesh();
            for (const int level : {1, 2, 4}) {
                const Mesh plain = work.plain_mesh(level);
                for (std::size_t i = 0; i < work.points.size(); ++i) {
                    const SurfacePoint point = work.with(i, work.footprint(level + 0.5));
                    const std::vector<float> expected = ask_plainly(plain, work.points[i]);
                    CHECK(ask(mesh, point) == expected);
                    for (std::size_t l = 0; l < expected.size(); ++l)
                        CHECK(mesh.visibility(point, l) == expected[l]);
                }
            }
        }
    }
}

TEST_CASE("levels: between two of them their values are blended") {
    for (const ShortTest short_test : test::all_short_tests) {
        const Work work(short_test, 9);
        const Mesh mesh = work.mesh();
        double differing = 0.0;
        for (const int level : {0, 1}) {
            const Mesh fine = work.plain_mesh(level);
            const Mesh coarse = work.plain_mesh(level + 1);
            for (std::size_t i = 0; i < work.points.size(); ++i) {
                const std::vector<float> from = ask_plainly(fine, work.points[i]);
                const std::vector<float> to = ask_plainly(coarse, work.points[i]);
                for (const double octave : {0.85, 0.97}) {
                    const double share = (std::exp2(octave) - std::exp2(0.8)) / (2.0 - std::exp2(0.8));
                    const SurfacePoint point = work.with(i, work.footprint(level + octave));
                    const std::vector<float> found = ask(mesh, point);
                    for (std::size_t l = 0; l < found.size(); ++l) {
                        const double expected =
                            (1.0 - share) * static_cast<double>(from[l]) + share * static_cast<double>(to[l]);
                        CHECK(static_cast<double>(found[l]) == doctest::Approx(expected).epsilon(1e-5));
                        CHECK(mesh.visibility(point, l) == found[l]);
                        differing += std::abs(static_cast<double>(from[l]) - static_cast<double>(to[l]));
                    }
                }
            }
        }
        CHECK(differing > 10.0);
    }
}

TEST_CASE("levels: nothing jumps while a footprint grows") {
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked}) {
        const Work work(short_test, 9, 12);
        const Mesh mesh = work.mesh();
        for (std::size_t i = 0; i < work.points.size(); ++i) {
            std::vector<float> before = ask(mesh, work.points[i]);
            for (double octaves = 0.5; octaves < 4.0; octaves += 0.005) {
                const std::vector<float> now = ask(mesh, work.with(i, work.footprint(octaves)));
                for (std::size_t l = 0; l < now.size(); ++l)
                    // A fifth of an octave has 40 steps.
                    CHECK(std::abs(now[l] - before[l]) < 1.2f / 40.0f);
                before = now;
            }
        }
    }
}

TEST_CASE("levels: many points with mixed footprints have the values of one at a time") {
    for (const ShortTest short_test : test::all_short_tests) {
        for (const int light_count : {5, 70}) {
            Work work(short_test, light_count, short_test == ShortTest::exact ? 40 : 150);
            work.points[5].position.x = not_a_number;
            work.points[6].normal = glm::vec3(0.0f);
            work.points[7].normal.y = infinity;
            const std::vector<SurfacePoint> points = mixed_points(work);
            const Mesh alone = work.mesh();
            const std::vector<float> expected = ask_one_by_one(alone, points);
            const Mesh together = work.mesh();
            std::vector<float> found(expected.size());
            lightmesh::QueryStatistics statistics;
            together.visibility(points, found, &statistics);
            CHECK(equal(found, expected));
            CHECK(statistics.points == points.size());
            const Mesh filled = work.mesh();
            filled.fill(points);
            const lightmesh::MeshStatistics held = filled.statistics();
            filled.visibility(points, found);
            CHECK(equal(found, expected));
            CHECK(filled.statistics().long_rays == held.long_rays);
            CHECK(filled.statistics().bytes == held.bytes);
        }
    }
}

TEST_CASE("levels: the order of queries and the number of threads do not change a bit") {
    for (const ShortTest short_test : test::all_short_tests) {
        const Work work(short_test, 10, 60);
        const std::vector<SurfacePoint> points = mixed_points(work);
        const std::vector<float> expected = ask_one_by_one(work.mesh(), points);
        const Mesh shared = work.mesh();
        std::vector<std::vector<float>> found(4, std::vector<float>(expected.size()));
        std::vector<std::thread> threads;
        for (std::size_t t = 0; t < found.size(); ++t)
            threads.emplace_back([&, t] {
                std::vector<std::size_t> order(points.size());
                std::iota(order.begin(), order.end(), std::size_t{0});
                test::Random(t).shuffle(order);
                for (const std::size_t i : order)
                    shared.visibility(points[i], std::span(found[t]).subspan(10 * i, 10));
            });
        for (std::thread& thread : threads)
            thread.join();
        for (const std::vector<float>& values : found)
            CHECK(equal(values, expected));
    }
}

TEST_CASE("levels: statistics are sums over levels, and say what each holds") {
    const Work work(ShortTest::linked, 9, 20);
    const Mesh mesh = work.mesh();
    const Mesh coarse = work.plain_mesh(2);
    for (std::size_t i = 0; i < work.points.size(); ++i) {
        ask(mesh, work.with(i, work.footprint(2.5)));
        ask_plainly(coarse, work.points[i]);
    }
    const lightmesh::MeshStatistics held = mesh.statistics();
    const lightmesh::MeshStatistics expected = coarse.statistics();
    CHECK(held.light_points == expected.light_points);
    CHECK(held.light_points_of_level[2] == expected.light_points);
    CHECK(held.light_points_of_level[0] == 0);
    CHECK(held.bytes_of_level[1] == 0);
    CHECK(held.bricks == expected.bricks);
    CHECK(held.long_tests == expected.long_tests);
    CHECK(held.long_rays == expected.long_rays);
    CHECK(held.link_rays == expected.link_rays);
    CHECK(held.bytes > held.bytes_of_level[0] + held.bytes_of_level[2]);
}

TEST_CASE("levels: a wide footprint needs fewer light points") {
    const Work work(ShortTest::none, 9, 30);
    std::size_t before = std::numeric_limits<std::size_t>::max();
    for (const double octaves : {0.5, 1.5, 2.5}) {
        const Mesh mesh = work.mesh();
        test::Random random(8);
        for (const test::SurfacePoint& p : test::surface_points(random, work.scene, 2000))
            ask(mesh, {.position = p.position, .normal = p.normal, .footprint = work.footprint(octaves)});
        CHECK(2 * mesh.statistics().light_points < before);
        before = mesh.statistics().light_points;
    }
}

TEST_CASE("levels: an infinite footprint is served by the coarsest level") {
    Work work(ShortTest::none, 5);
    work.settings.radius = 3e17f;
    const Mesh mesh = work.mesh();
    const Mesh coarsest = work.plain_mesh(1);
    for (std::size_t i = 0; i < work.points.size(); ++i)
        CHECK(ask(mesh, work.with(i, infinity)) == ask_plainly(coarsest, work.points[i]));
}

TEST_CASE("levels: a tracer that fails loses and changes nothing") {
    for (const ShortTest short_test : test::all_short_tests) {
        const Work work(short_test, 9, 20);
        const std::vector<SurfacePoint> points = mixed_points(work);
        const std::vector<float> expected = ask_one_by_one(work.mesh(), points);
        unsigned calls = 0;
        const lightmesh::LightMesh mesh{UnreliableTracer{&work.scene, &calls}, work.lights, work.settings};
        std::vector<float> found(expected.size());
        int failures = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (bool done = false; !done;) {
                try {
                    mesh.visibility(points[i], std::span(found).subspan(9 * i, 9));
                    done = true;
                } catch (const std::runtime_error&) {
                    ++failures;
                }
            }
        }
        CHECK(failures > 10);
        CHECK(equal(found, expected));
    }
}

TEST_CASE("levels: shadow maps are rendered once for all of them") {
    test::BoxScene scene;
    scene.boxes.push_back({{-12.0f, -12.0f, -9.0f}, {12.0f, 12.0f, -8.0f}});
    scene.boxes.push_back({{-1.0f, -2.0f, -8.0f}, {2.0f, 1.0f, -4.0f}});
    const std::vector<lightmesh::Light> lights{lightmesh::PointLight{{0.3f, -5.0f, 2.7f}},
                                               lightmesh::DirectionalLight{{0.5f, 0.25f, -1.0f}}};
    for (const ShortTest short_test : test::all_short_tests) {
        lightmesh::Settings settings;
        settings.radius = 0.5f;
        settings.quality = 2.0f;
        settings.short_test = short_test;
        settings.shadow_map_size = 128;
        settings.scene_bounds = lightmesh::Bounds{{-12.0f, -12.0f, -9.0f}, {12.0f, 12.0f, 2.0f}};
        int pictures = 0;
        const lightmesh::LightMesh mesh{test::BoxTracer{&scene},
                                        CountingRenderer{test::BoxRenderer{&scene}, &pictures}, lights,
                                        settings};
        lightmesh::Settings coarse = settings;
        coarse.radius = 2.0f;
        const lightmesh::LightMesh plain{test::BoxTracer{&scene}, test::BoxRenderer{&scene}, lights, coarse};
        int of_one_level = 0;
        int differing = 0;
        for (const float footprint : {0.0f, 0.75f}) {
            for (float x = -6.0f; x < 6.0f; x += 0.37f) {
                const SurfacePoint point{
                    .position = {x, 0.6f * x, -8.0f}, .normal = {0, 0, 1}, .footprint = footprint};
                const std::vector<float> found = ask(mesh, point);
                if (footprint > 0.0f)
                    CHECK(found == ask_plainly(plain, point));
                differing += found == ask_plainly(mesh, point) ? 0 : 1;
            }
            if (footprint == 0.0f)
                of_one_level = pictures;
        }
        CHECK(of_one_level > 0);
        CHECK(pictures <= 7);
        CHECK(differing > 5);
    }
}

TEST_CASE("levels: shadow volumes are shared by all of them") {
    struct Triangles {
        std::vector<std::array<glm::vec3, 3>> corners;
        std::size_t triangle_count() const { return corners.size(); }
        std::array<glm::vec3, 3> triangle(std::size_t i) const { return corners[i]; }
    };
    for (const ShortTest short_test : test::all_short_tests) {
        const Work work(short_test, 6, 20);
        Triangles triangles;
        for (const test::Triangle& t : work.scene)
            triangles.corners.push_back({glm::vec3(t.a), glm::vec3(t.b), glm::vec3(t.c)});
        const lightmesh::LightMesh mesh{test::PlainTracer{&work.scene}, triangles, work.lights,
                                        work.settings};
        lightmesh::Settings coarse = work.settings;
        coarse.radius *= 4.0f;
        const lightmesh::LightMesh plain{test::PlainTracer{&work.scene}, triangles, work.lights, coarse};
        for (std::size_t i = 0; i < work.points.size(); ++i)
            CHECK(ask(mesh, work.with(i, work.footprint(2.5))) == ask_plainly(plain, work.points[i]));
        CHECK(mesh.statistics().long_rays == 0);
    }
}

TEST_CASE("levels: a snapshot with a tracer equals the live mesh, also where nobody asked before") {
    for (const ShortTest short_test : test::all_short_tests) {
        for (const glm::vec3& origin : {lightmesh::Settings{}.origin, glm::vec3(0.1f, 0.2f, 0.3f)}) {
            Work work(short_test, 9);
            work.settings.origin = origin;
            const std::vector<SurfacePoint> points = mixed_points(work);
            const Mesh mesh = work.mesh();
            for (std::size_t i = 0; i < 10; ++i)
                ask(mesh, points[i]);
            const test::Bytes bytes = mesh.snapshot();
            CHECK(levels_of(bytes).size() >= 2);
            const lightmesh::SnapshotView view{std::span<const std::byte>(bytes)};
            std::vector<float> all(9);
            for (const SurfacePoint& point : points) {
                view.visibility(test::PlainTracer{&work.scene}, point, all);
                CHECK(all == ask(mesh, point));
            }
            SurfacePoint beyond = points.front();
            beyond.footprint = work.footprint(8.9);
            view.visibility(test::PlainTracer{&work.scene}, beyond, all);
            CHECK(all == ask(mesh, beyond));
        }
    }
}

TEST_CASE("levels: a snapshot without a tracer answers for the levels that were asked") {
    const Work work(ShortTest::none, 70);
    const std::vector<SurfacePoint> points = mixed_points(work);
    const Mesh mesh = work.mesh();
    for (std::size_t i = 0; i < 15; ++i)
        ask(mesh, points[i]);
    const test::Bytes bytes = mesh.snapshot();
    const lightmesh::SnapshotView view{std::span<const std::byte>(bytes)};
    std::vector<float> all(70);
    std::size_t missing = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const std::size_t counted = view.visibility(points[i], all);
        const std::vector<float> expected = ask(mesh, points[i]);
        std::size_t unknown = 0;
        for (std::size_t l = 0; l < all.size(); ++l) {
            unknown += std::isnan(all[l]) ? 1u : 0u;
            CHECK((std::isnan(all[l]) || all[l] == expected[l]));
        }
        CHECK(unknown == counted);
        CHECK((i >= 15 || unknown == 0));
        missing += unknown;
    }
    CHECK(missing > 0);
    // Of a level that is not there what no light reaches is known.
    SurfacePoint beyond = points.front();
    beyond.footprint = infinity;
    const std::vector<float> expected = ask(work.mesh(), beyond);
    const std::size_t unknown = view.visibility(beyond, all);
    CHECK(unknown > 0);
    CHECK(unknown < all.size());
    for (std::size_t l = 0; l < all.size(); ++l)
        CHECK((std::isnan(all[l]) || (all[l] == 0.0f && expected[l] == 0.0f)));
}

TEST_CASE("levels: a snapshot merged into an empty mesh restores all of them without a ray") {
    for (const ShortTest short_test : test::all_short_tests) {
        const Work work(short_test, 70);
        const std::vector<SurfacePoint> points = mixed_points(work);
        const Mesh full = work.mesh();
        const std::vector<float> expected = ask_one_by_one(full, points);
        const test::Bytes bytes = full.snapshot();
        CHECK(levels_of(bytes).size() >= 3);
        Mesh restored = work.mesh();
        restored.merge(bytes);
        CHECK(restored.snapshot() == bytes);
        CHECK(equal(ask_one_by_one(restored, points), expected));
        CHECK(restored.statistics().long_rays == 0);
        CHECK(restored.statistics().link_rays == 0);
        CHECK(restored.statistics().light_points_of_level == full.statistics().light_points_of_level);
        // A mesh that chooses levels by another scale has the same ones.
        Work other = work;
        other.settings.footprint_scale = 0.0f;
        Mesh of_other_scale = other.mesh();
        of_other_scale.merge(bytes);
        CHECK(of_other_scale.statistics().light_points == full.statistics().light_points);
    }
}

TEST_CASE("levels: what two meshes know together does not depend on which is merged into which") {
    const Work work(ShortTest::linked, 9);
    const std::vector<SurfacePoint> points = mixed_points(work);
    Mesh first = work.mesh();
    Mesh second = work.mesh();
    for (std::size_t i = 0; i < 20; ++i) {
        ask(first, points[i]);
        ask(second, points[points.size() - 1 - i]);
    }
    const test::Bytes bytes = first.snapshot();
    first.merge(second.snapshot());
    second.merge(bytes);
    CHECK(first.snapshot() == second.snapshot());
}

TEST_CASE("levels: a mesh that was asked for level 0 only has a snapshot without others") {
    const Work work(ShortTest::linked, 3, 4);
    const Mesh mesh = work.mesh();
    ask(mesh, work.points[0]);
    const test::Bytes bytes = mesh.snapshot();
    CHECK(levels_of(bytes).empty());
    const SnapshotHeader header = header_of(bytes);
    CHECK(header.sections[lightmesh::detail::levels_section].offset ==
          header.sections[lightmesh::detail::region_slots_section].offset);
}

TEST_CASE("levels: a snapshot that differs on one level only is refused, and changes nothing") {
    const Work work(ShortTest::none, 5, 60);
    Work other = work;
    for (test::Triangle& triangle : other.scene)
        for (test::Vec* corner : {&triangle.a, &triangle.b, &triangle.c})
            *corner += test::Vec(0.9, 0.0, 0.0);
    const Mesh theirs = other.mesh();
    Mesh mine = work.mesh();
    for (std::size_t i = 0; i < work.points.size(); ++i) {
        ask(theirs, work.with(i, work.footprint(2.5)));
        ask(mine, work.with(i, work.footprint(2.5)));
        ask(mine, work.points[i]);
    }
    const test::Bytes before = mine.snapshot();
    const std::string said = test::error_of([&] { mine.merge(theirs.snapshot()); });
    CHECK(said.find("not of the same scene") != std::string::npos);
    CHECK(mine.snapshot() == before);
}

TEST_CASE("levels: a snapshot whose levels are not in their places is refused") {
    const Work work(ShortTest::linked, 9, 10);
    const Mesh mesh = work.mesh();
    for (std::size_t i = 0; i < work.points.size(); ++i)
        for (const double octaves : {0.0, 1.5, 2.5})
            ask(mesh, work.with(i, work.footprint(octaves)));
    const test::Bytes good = mesh.snapshot();
    REQUIRE(levels_of(good) == std::vector<std::uint64_t>{1, 2});
    const std::uint64_t at = header_of(good).sections[lightmesh::detail::levels_section].offset;
    const auto error_with = [&](auto&& change) {
        test::Bytes bytes = good;
        std::array<SnapshotLevelRecord, 2> records;
        std::memcpy(records.data(), bytes.data() + at, sizeof records);
        change(records);
        std::memcpy(bytes.data() + at, records.data(), sizeof records);
        test::sign<SnapshotHeader>(bytes);
        return test::error_of([&] { const lightmesh::SnapshotView view{std::span<const std::byte>(bytes)}; });
    };
    CHECK(error_with([](auto&) {}).empty());
    const char* const not_in_place = "a level is not in its place";
    CHECK(error_with([](auto& r) { r[0].level = 0; }).find(not_in_place) != std::string::npos);
    CHECK(error_with([](auto& r) { r[1].level = 1; }).find(not_in_place) != std::string::npos);
    CHECK(error_with([](auto& r) { r[1].level = 25; }).find(not_in_place) != std::string::npos);
    CHECK(error_with([](auto& r) { r[1].level = ~std::uint64_t{0}; }).find(not_in_place) !=
          std::string::npos);
    CHECK(error_with([](auto& r) { std::swap(r[0].level, r[1].level); }).find(not_in_place) !=
          std::string::npos);
    for (std::size_t part = 0; part < lightmesh::detail::level_section_count; ++part) {
        CAPTURE(part);
        CHECK(error_with([&](auto& r) { r[1].first[part] = ~std::uint64_t{0}; }).find("beyond its end") !=
              std::string::npos);
        CHECK_FALSE(error_with([&](auto& r) { r[1].first[part] += 1; }).empty());
        bool changes = false;
        const std::string said = error_with([&](auto& r) {
            changes = r[1].first[part] != 0;
            r[1].first[part] = 0;
        });
        CHECK(said.empty() != changes);
    }
    CHECK_FALSE(error_with([](auto& r) { r[0].first = r[1].first; }).empty());
}

}  // namespace levels_test
