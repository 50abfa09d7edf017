// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/shadows/shadow_volume.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

namespace shadow_volume_test {

namespace {

using Corners = std::array<glm::vec3, 3>;

struct Source {
    std::vector<Corners> triangles;
    std::size_t triangle_count() const { return triangles.size(); }
    Corners triangle(std::size_t i) const { return triangles[i]; }
};

struct NoCount {
    Corners triangle(std::size_t) const;
};
struct NotConst {
    std::size_t triangle_count() const;
    Corners triangle(std::size_t);
};
static_assert(lightmesh::check_occluders<Source>() && lightmesh::Occluders<Source>);
static_assert(!lightmesh::Occluders<NoCount> && !lightmesh::Occluders<NotConst> &&
              !lightmesh::Occluders<int>);

/// Triangles of all sizes, from 0.01 to 10, in a room of 20.
Source random_triangles(std::uint64_t seed, int count) {
    test::Random random(seed);
    Source source;
    for (int i = 0; i < count; ++i) {
        const test::Vec middle = random.in_box(test::Vec(-10.0), test::Vec(10.0));
        const double size = std::pow(10.0, random.uniform(-2.0, 1.0));
        Corners corners;
        for (glm::vec3& corner : corners)
            corner = glm::vec3(middle + size * random.direction());
        source.triangles.push_back(corners);
    }
    return source;
}

glm::dvec3 source_of(const lightmesh::Light& light, const glm::dvec3& point) {
    if (const auto* sun = std::get_if<lightmesh::DirectionalLight>(&light))
        return point - 1000.0 * glm::normalize(glm::dvec3(sun->direction));
    if (const auto* spot = std::get_if<lightmesh::SpotLight>(&light))
        return glm::dvec3(spot->position);
    return glm::dvec3(std::get<lightmesh::PointLight>(light).position);
}

bool blocked(const Source& source, const glm::dvec3& from, const glm::dvec3& to) {
    for (const Corners& corners : source.triangles)
        if (test::crosses(from, to, {glm::dvec3(corners[0]), glm::dvec3(corners[1]), glm::dvec3(corners[2])}))
            return true;
    return false;
}

/// The band of doubt: a segment from next to the light to next to the point answers otherwise.
bool in_band(const Source& source, const glm::dvec3& from, const glm::dvec3& to) {
    const bool answer = blocked(source, from, to);
    const double width = 1e-6 * glm::length(to - from);
    for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-width, width}) {
            glm::dvec3 other = to;
            other[axis] += side;
            if (blocked(source, from, other) != answer)
                return true;
        }
    }
    return false;
}

void compare_with_rays(const Source& source, const lightmesh::Light& light, int count = 3000) {
    const lightmesh::ShadowVolumes volumes(source, light);
    test::Random random(17);
    int wrong = 0;
    int dark = 0;
    for (int i = 0; i < count; ++i) {
        const glm::vec3 point(random.in_box(test::Vec(-12.0), test::Vec(12.0)));
        const glm::dvec3 from = source_of(light, glm::dvec3(point));
        const bool hidden = blocked(source, from, glm::dvec3(point));
        dark += hidden ? 1 : 0;
        if (volumes.visible(point) == hidden && !in_band(source, from, glm::dvec3(point)))
            ++wrong;
    }
    CHECK(wrong == 0);
    CHECK(dark > 0);
}

/// A square at x = 1, from -1 to 1 in y and z, cut into n x n squares of two triangles each.
Source wall(int n) {
    Source source;
    const auto corner = [n](int i, int j) {
        const auto step = [n](int k) {
            return 2.0f * static_cast<float>(k) / static_cast<float>(n) - 1.0f;
        };
        return glm::vec3(1.0f, step(i), step(j));
    };
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            source.triangles.push_back({corner(i, j), corner(i + 1, j), corner(i, j + 1)});
            source.triangles.push_back({corner(i + 1, j + 1), corner(i + 1, j), corner(i, j + 1)});
        }
    }
    return source;
}

}  // namespace

TEST_SUITE("shadow volumes") {
    TEST_CASE("the same as rays, for every kind of light, inside the scene and outside") {
        for (const int triangles : {10, 30, 300}) {
            const Source source = random_triangles(static_cast<std::uint64_t>(triangles), triangles);
            compare_with_rays(source, lightmesh::PointLight{{0.5f, 1.0f, -2.0f}});
            compare_with_rays(source, lightmesh::PointLight{{60.0f, 5.0f, 40.0f}});
            compare_with_rays(source, lightmesh::SpotLight{{-3.0f, 0.0f, 11.0f}, {0.0f, 0.3f, -1.0f}, 0.5f});
            compare_with_rays(source, lightmesh::DirectionalLight{{0.3f, -0.2f, -1.0f}});
            compare_with_rays(source, lightmesh::DirectionalLight{{0.0f, 1.0f, 0.0f}});
        }
    }

    TEST_CASE("nothing leaks between triangles that share edges, nor at the edges of the cube") {
        const Source source = wall(10);
        const lightmesh::ShadowVolumes volumes(source, lightmesh::PointLight{});
        const lightmesh::ShadowVolumes parallel(source, lightmesh::DirectionalLight{{1.0f, 0.0f, 0.0f}});
        for (int i = -100; i <= 100; ++i) {
            for (int j = -100; j <= 100; ++j) {
                const glm::vec3 way(1.0f, static_cast<float>(i) / 100.0f, static_cast<float>(j) / 100.0f);
                CHECK(volumes.visible(0.999f * way));
                CHECK_FALSE(volumes.visible(1.001f * way));
                CHECK_FALSE(parallel.visible(glm::vec3(1.1f, 0.999f * way.y, 0.999f * way.z)));
                CHECK(parallel.visible(glm::vec3(0.9f, way.y, way.z)));
            }
        }
    }

    TEST_CASE("a light in a corner, close to a wall, and in the plane of a wall") {
        Source source = random_triangles(5, 40);
        source.triangles.push_back(
            {glm::vec3(-10.0f, -99.0f, -99.0f), {-10.0f, 99.0f, -99.0f}, {-10.0f, 0.0f, 99.0f}});
        source.triangles.push_back(
            {glm::vec3(-99.0f, -99.0f, -10.0f), {99.0f, -99.0f, -10.0f}, {0.0f, 99.0f, -10.0f}});
        compare_with_rays(source, lightmesh::PointLight{{-9.999f, 0.0f, -9.999f}});
        compare_with_rays(source, lightmesh::PointLight{{-10.00001f, 3.0f, 0.0f}});
        const lightmesh::ShadowVolumes volumes(source, lightmesh::PointLight{{-10.0f, 3.0f, 0.0f}});
        CHECK(volumes.visible({-10.1f, 3.0f, 0.0f}));  // seen from its edge, the wall hides nothing
    }

    TEST_CASE("clearance: what is nearer to the light hides nothing") {
        const Source source = wall(1);
        const lightmesh::PointLight light{{0.5f, 0.0f, 0.0f}};
        CHECK_FALSE(lightmesh::ShadowVolumes(source, light, 0.49f).visible({2.0f, 0.0f, 0.0f}));
        CHECK(lightmesh::ShadowVolumes(source, light, 0.51f).visible({2.0f, 0.0f, 0.0f}));
        CHECK_FALSE(lightmesh::ShadowVolumes(source, light, 0.51f).visible({1.5f, 0.9f, 0.0f}));
        CHECK_THROWS_AS(lightmesh::ShadowVolumes(source, light, -1.0f), std::invalid_argument);
    }

    TEST_CASE("the scale of the scene does not matter") {
        for (const float scale : {1e-12f, 1e-3f, 1e3f, 1e12f}) {
            Source source = wall(4);
            for (Corners& corners : source.triangles)
                for (glm::vec3& corner : corners)
                    corner *= scale;
            for (const lightmesh::Light& light :
                 {lightmesh::Light(lightmesh::PointLight{}),
                  lightmesh::Light(lightmesh::DirectionalLight{{1.0f, 0.0f, 0.0f}})}) {
                const lightmesh::ShadowVolumes volumes(source, light);
                CHECK(volumes.visible(scale * glm::vec3(0.99f, 0.3f, 0.4f)));
                CHECK_FALSE(volumes.visible(scale * glm::vec3(1.01f, 0.3f, 0.4f)));
                CHECK(volumes.visible(scale * glm::vec3(1.01f, 1.3f, 0.4f)));
            }
        }
    }

    TEST_CASE("no triangles, triangles of no area, points that are no points") {
        const lightmesh::PointLight light;
        const float nan = std::numeric_limits<float>::quiet_NaN();
        for (const lightmesh::Light& any :
             {lightmesh::Light(light), lightmesh::Light(lightmesh::DirectionalLight{})}) {
            const lightmesh::ShadowVolumes none(Source{}, any);
            CHECK(none.visible({1.0f, 2.0f, 3.0f}));
            CHECK_FALSE(none.visible({1.0f, nan, 3.0f}));
            CHECK(none.visible(glm::vec3(0.0f)));
        }
        Source thin;
        thin.triangles.push_back({glm::vec3(1.0f, -1.0f, 0.0f), {1.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 0.0f}});
        CHECK(lightmesh::ShadowVolumes(thin, light).visible({2.0f, 0.0f, 0.0f}));

        Source wrong = wall(1);
        wrong.triangles[1][2].y = nan;
        CHECK_THROWS_WITH_AS(lightmesh::OccluderTriangles{wrong},
                             "lightmesh: a corner of occluder 1 is (1, nan, 1); it must be finite",
                             std::invalid_argument);
        CHECK_THROWS_AS(lightmesh::ShadowVolumes(wall(1), lightmesh::PointLight{{nan, 0.0f, 0.0f}}),
                        std::invalid_argument);
    }

    TEST_CASE("many points at once, from many threads, all lights on one copy of the triangles") {
        const auto triangles = std::make_shared<const lightmesh::OccluderTriangles>(random_triangles(9, 200));
        const lightmesh::ShadowVolumes volumes(triangles, lightmesh::PointLight{});
        const std::size_t before = volumes.bytes();
        test::Random random(4);
        std::vector<glm::vec3> points;
        for (int i = 0; i < 2000; ++i)
            points.emplace_back(random.in_box(test::Vec(-10.0), test::Vec(10.0)));
        std::vector<std::vector<std::uint8_t>> lit(4, std::vector<std::uint8_t>(points.size()));
        {
            std::vector<std::jthread> threads;
            for (auto& answers : lit)
                threads.emplace_back([&] { volumes.visible(points, answers); });
        }
        for (std::size_t i = 0; i < points.size(); ++i)
            CHECK((lit[0][i] != 0) == volumes.visible(points[i]));
        for (const auto& answers : lit)
            CHECK(answers == lit[0]);
        CHECK(volumes.bytes() > before);
        CHECK_THROWS_AS(volumes.visible(points, std::span(lit[0]).first(3)), std::invalid_argument);
    }
}

}  // namespace shadow_volume_test
