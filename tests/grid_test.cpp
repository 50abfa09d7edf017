// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/mesh/grid.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <stdexcept>

// The errors of Grid are in errors_test.cpp.

namespace grid_test {

namespace {

lightmesh::Grid grid_of(float radius, float quality, const glm::vec3& origin = lightmesh::Settings{}.origin) {
    lightmesh::Settings settings;
    settings.radius = radius;
    settings.quality = quality;
    settings.origin = origin;
    return lightmesh::Grid(settings);
}

}  // namespace

TEST_CASE("the step is radius over quality") {
    CHECK(grid_of(3.0f, 4.0f).step() == 0.75);
    CHECK(grid_of(1.0f, 3.0f).step() == doctest::Approx(1.0 / 3.0).epsilon(1e-15));
    CHECK(grid_of(3.0f, 4.0f).radius() == 3.0f);
    CHECK(grid_of(3.0f, 4.0f).quality() == 4.0f);
}

TEST_CASE("light points lie at origin + step * index, and are located there") {
    test::Random random(81);
    for (const glm::vec3& origin : {glm::vec3(0.0f), glm::vec3(0.5f, -2.0f, 100.0f)}) {
        const lightmesh::Grid grid = grid_of(1.3f, 3.7f, origin);
        CHECK(grid.position({0, 0, 0}) == origin);
        for (int i = 0; i < 200; ++i) {
            const glm::ivec3 index(random.in_box(test::Vec(-1e5), test::Vec(1e5)));
            const test::Vec exact = test::Vec(origin) + 1.3f / static_cast<double>(3.7f) * test::Vec(index);
            CHECK(glm::distance(test::Vec(grid.position(index)), exact) <= 0x1p-23 * glm::length(exact));
            CHECK(glm::distance(grid.locate(grid.position(index)), test::Vec(index)) < 0.05);
        }
    }
}

TEST_CASE("the default origin is an uneven part of a step in each axis") {
    for (const float radius : {1.0f, 3.0f, 0.01f}) {
        const lightmesh::Grid grid = grid_of(radius, 4.0f);
        const test::Vec part = grid.origin() / grid.step();
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(part[axis] > 0.1);
            CHECK(part[axis] < 0.9);
            for (int denominator = 1; denominator <= 8; ++denominator) {
                const double multiple = part[axis] * denominator;
                CHECK(std::abs(multiple - std::round(multiple)) > 0.01);
            }
        }
    }
}

TEST_CASE("the grid ends where a float cannot tell light points apart") {
    const lightmesh::Grid grid = grid_of(1.0f, 1.0f, glm::vec3(0.0f));
    constexpr float end = 0x1p24f;
    CHECK_NOTHROW(grid.locate({0.99f * end, -0.99f * end, 0}));
    CHECK_THROWS_AS(grid.locate({end, 0, 0}), std::out_of_range);
    CHECK_THROWS_AS(grid.locate({0, -end, 0}), std::out_of_range);
    CHECK_THROWS_AS(grid.locate({0, 0, 2.0f * end}), std::out_of_range);
}

}  // namespace grid_test
