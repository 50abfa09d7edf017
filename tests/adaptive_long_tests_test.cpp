// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

// Long tests by samples: of each brick 16 light points for each light, and the others where these disagree.

namespace adaptive_long_tests_test {

namespace {

using lightmesh::LightMesh;
using lightmesh::ShortTest;
using lightmesh::detail::brick_samples;
using Mesh = LightMesh<test::PlainTracer>;

struct Work {
    std::vector<test::Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<test::SurfacePoint> points;
    lightmesh::Settings settings{.radius = 0.8f, .quality = 3.0f, .short_test = ShortTest::none};

    explicit Work(std::uint64_t seed, int light_count = 11) {
        test::Random random(seed);
        scene = seed % 2 == 0 ? test::thin_walls(random) : test::boxes_on_floor(random, 12);
        lights = test::random_lights(random, light_count);
        points = test::surface_points(random, scene, 120);
    }

    Mesh mesh(ShortTest short_test = ShortTest::none, bool adaptive = true) const {
        lightmesh::Settings chosen = settings;
        chosen.short_test = short_test;
        chosen.adaptive_long_tests = adaptive;
        return Mesh{test::PlainTracer{&scene}, lights, chosen};
    }
};

std::vector<float> ask(const Mesh& mesh, const test::SurfacePoint& point) {
    std::vector<float> all(mesh.light_count());
    mesh.visibility(point.position, point.normal, all);
    return all;
}

/// Equation (3) without its short test, by the rule of samples: brick by brick, light by light.
class PlainSamples {
public:
    explicit PlainSamples(const Work& work)
        : grid_(work.settings), table_(work.lights, grid_), tracer_{&work.scene} {}

    float visibility(const test::SurfacePoint& p, std::size_t light) {
        const glm::vec3 normal = glm::normalize(p.normal);
        if (!table_.can_light(light, p.position, normal))
            return 0.0f;
        const lightmesh::detail::Hemisphere hemisphere(grid_, grid_.locate(p.position), p.position, normal);
        lightmesh::detail::BrickMask masks[64];
        const std::size_t size = lightmesh::detail::kernels().find_masks(hemisphere, masks);
        int lit = 0;
        int all = 0;
        for (std::size_t i = 0; i < size; ++i) {
            const glm::ivec3 brick = hemisphere.first_brick + glm::ivec3(masks[i].x, masks[i].y, masks[i].z);
            const std::uint64_t points = masks[i].points;
            all += std::popcount(points);
            lit += std::popcount(points & bits(brick, light));
        }
        return all == 0 ? -1.0f : static_cast<float>(lit) / static_cast<float>(all);
    }

    /// Of the bricks that were asked for, those that the samples are wrong about.
    int wrong = 0;
    int mixed = 0;
    int uniform = 0;

private:
    std::uint64_t bits(const glm::ivec3& brick, std::size_t light) {
        const auto [known, is_new] = bits_.emplace(std::tuple(brick.x, brick.y, brick.z, light), 0);
        if (is_new) {
            std::uint64_t seen = 0;
            for (int bit = 0; bit < 64; ++bit) {
                const glm::vec3 x = grid_.position(lightmesh::detail::grid_pos_of(brick, bit));
                if (!tracer_.occluded(table_.long_segment(light, x)))
                    seen |= std::uint64_t{1} << bit;
            }
            const bool all_open = (seen & brick_samples) == brick_samples;
            const bool none_open = (seen & brick_samples) == 0;
            known->second = all_open ? ~std::uint64_t{0} : none_open ? 0 : seen;
            wrong += known->second != seen ? 1 : 0;
            ++(all_open || none_open ? uniform : mixed);
        }
        return known->second;
    }

    lightmesh::Grid grid_;
    lightmesh::detail::LightTable table_;
    test::PlainTracer tracer_;
    std::map<std::tuple<int, int, int, std::size_t>, std::uint64_t> bits_;
};

}  // namespace

TEST_CASE("16 light points of a brick are samples, at least one in each cell") {
    CHECK(std::popcount(brick_samples) == 16);
    CHECK(lightmesh::detail::cell_bits(brick_samples) == 0xff);
}

TEST_CASE("adaptive long tests give what their rule says, light by light and all at once") {
    int wrong = 0;
    for (const std::uint64_t seed : {701u, 702u, 703u}) {
        const Work work(seed);
        PlainSamples plain(work);
        const Mesh mesh = work.mesh();
        for (const test::SurfacePoint& p : work.points) {
            const std::vector<float> all = ask(mesh, p);
            for (std::size_t light = 0; light < work.lights.size(); ++light) {
                const float expected = plain.visibility(p, light);
                CHECK(mesh.visibility(p.position, p.normal, light) == all[light]);
                if (expected >= 0.0f)
                    CHECK(all[light] == expected);
            }
        }
        CHECK(plain.mixed > 50);
        CHECK(plain.uniform > 500);
        wrong += plain.wrong;
    }
    // Else the rule is not tested.
    CHECK(wrong > 0);
}

TEST_CASE("adaptive long tests do not depend on the order of questions, nor on which lights were asked for") {
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked}) {
        const Work work(704, 70);
        const Mesh forward = work.mesh(short_test);
        const Mesh backward = work.mesh(short_test);
        const Mesh at_once = work.mesh(short_test);
        std::vector<std::vector<float>> expected;
        for (const test::SurfacePoint& p : work.points)
            expected.push_back(ask(forward, p));
        for (std::size_t i = work.points.size(); i-- > 0;) {
            const test::SurfacePoint& p = work.points[i];
            for (std::size_t light = 0; light < work.lights.size(); light += 3)
                CHECK(backward.visibility(p.position, p.normal, (7 * light + i) % work.lights.size()) ==
                      expected[i][(7 * light + i) % work.lights.size()]);
            CHECK(ask(backward, p) == expected[i]);
        }
        std::vector<glm::vec3> positions;
        std::vector<glm::vec3> normals;
        for (const test::SurfacePoint& p : work.points) {
            positions.push_back(p.position);
            normals.push_back(p.normal);
        }
        std::vector<float> all(positions.size() * work.lights.size());
        at_once.visibility(positions, normals, all);
        // A second time: what is uniform is known then.
        for (int round = 0; round < 2; ++round) {
            for (std::size_t i = 0; i < work.points.size(); ++i) {
                CHECK(std::equal(expected[i].begin(), expected[i].end(),
                                 all.begin() + static_cast<std::ptrdiff_t>(i * work.lights.size())));
                CHECK(ask(forward, work.points[i]) == expected[i]);
            }
            at_once.visibility(positions, normals, all);
        }
    }
}

TEST_CASE("exact short tests trace all long tests, whatever the setting says") {
    const Work work(705);
    const Mesh with = work.mesh(ShortTest::exact, true);
    const Mesh without = work.mesh(ShortTest::exact, false);
    for (const test::SurfacePoint& p : work.points)
        CHECK(ask(with, p) == ask(without, p));
    CHECK(with.statistics().long_rays == without.statistics().long_rays);
    CHECK(with.snapshot() == without.snapshot());
}

TEST_CASE("adaptive long tests save rays and memory, and err little") {
    const Work work(706, 24);
    const Mesh adaptive = work.mesh();
    const Mesh all = work.mesh(ShortTest::none, false);
    double error = 0.0;
    double count = 0.0;
    for (const test::SurfacePoint& p : work.points) {
        const std::vector<float> a = ask(adaptive, p);
        const std::vector<float> b = ask(all, p);
        for (std::size_t light = 0; light < work.lights.size(); ++light) {
            error += static_cast<double>(std::abs(a[light] - b[light]));
            count += 1.0;
        }
    }
    MESSAGE("mean absolute difference of S: " << error / count);
    CHECK(error / count < 0.005);
    CHECK(adaptive.statistics().long_rays < all.statistics().long_rays);
    CHECK(adaptive.statistics().bytes < all.statistics().bytes);
}

TEST_CASE("snapshots of adaptive meshes restore them, and are not merged into others") {
    const Work work(707, 70);
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked}) {
        const Mesh full = work.mesh(short_test);
        const Mesh half = work.mesh(short_test);
        for (std::size_t i = 0; i < work.points.size(); ++i) {
            ask(full, work.points[i]);
            if (i % 2 == 0)
                ask(half, work.points[i]);
        }
        const std::vector<std::byte> bytes = full.snapshot();
        Mesh empty = work.mesh(short_test);
        empty.merge(bytes);
        CHECK(empty.snapshot() == bytes);
        Mesh both = work.mesh(short_test);
        both.merge(half.snapshot());
        both.merge(bytes);
        const std::uint64_t long_rays = both.statistics().long_rays;
        for (const test::SurfacePoint& p : work.points)
            CHECK(ask(both, p) == ask(full, p));
        CHECK(both.statistics().long_rays == long_rays);
        const lightmesh::SnapshotView view{bytes};
        for (const test::SurfacePoint& p : work.points) {
            std::vector<float> all(work.lights.size());
            view.visibility(test::PlainTracer{&work.scene}, p.position, p.normal, all);
            CHECK(all == ask(full, p));
        }

        Mesh traces_all = work.mesh(short_test, false);
        CHECK_THROWS_WITH_AS(traces_all.merge(bytes),
                             doctest::Contains("its long tests are adaptive, where this mesh traces all"),
                             std::invalid_argument);
    }
}

TEST_CASE("where lights differ, adaptive meshes take what is left, and stay right") {
    const Work work(708, 40);
    const Mesh full = work.mesh(ShortTest::linked);
    for (const test::SurfacePoint& p : work.points)
        ask(full, p);
    Work moved = work;
    moved.lights[3] = lightmesh::PointLight{.position = {0.1f, 0.2f, 0.9f}};
    Mesh merged = moved.mesh(ShortTest::linked);
    merged.merge(full.snapshot());
    const Mesh fresh = moved.mesh(ShortTest::linked);
    for (const test::SurfacePoint& p : work.points)
        CHECK(ask(merged, p) == ask(fresh, p));
    CHECK(merged.statistics().long_rays < fresh.statistics().long_rays);
}

}  // namespace adaptive_long_tests_test
