// SPDX-License-Identifier: MIT
#include "kernels_that_run.hpp"
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/kernels/kernels.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <tuple>
#include <vector>

namespace hemisphere_test {

namespace {

using lightmesh::Grid;
using lightmesh::detail::Hemisphere;
using test::Vec;
using Index = std::tuple<int, int, int>;

Grid grid_of(float radius, float quality, const glm::vec3& origin = lightmesh::Settings{}.origin) {
    lightmesh::Settings settings;
    settings.radius = radius;
    settings.quality = quality;
    settings.origin = origin;
    return Grid(settings);
}

/// The positions in the grid of a hemisphere's light points, by one kind of kernels.
std::set<Index> points_of(const lightmesh::detail::Kernels& kernels, const Hemisphere& hemisphere) {
    std::set<Index> points;
    std::vector<lightmesh::detail::BrickMask> masks(1001);
    const std::size_t size = kernels.find_masks(hemisphere, masks.data());
    for (std::size_t i = 0; i < size; ++i) {
        for (int bit = 0; bit < 64; ++bit) {
            if ((masks[i].points >> bit & 1) == 0)
                continue;
            const glm::ivec3 pos = lightmesh::detail::grid_pos_of(
                hemisphere.first_brick + glm::ivec3(masks[i].x, masks[i].y, masks[i].z), bit);
            points.insert({pos.x, pos.y, pos.z});
        }
    }
    return points;
}

/// The same for all kernels, or a failed check.
std::set<Index> points_of(const Grid& grid, const glm::vec3& point, const glm::vec3& normal) {
    const Hemisphere hemisphere(grid, grid.locate(point), point, lightmesh::detail::unit_or_zero(normal));
    const auto points = points_of(lightmesh::detail::portable_kernels, hemisphere);
    for (const lightmesh::detail::Kernels* kernels : test::kernels_that_run())
        CHECK(points_of(*kernels, hemisphere) == points);
    return points;
}

}  // namespace

TEST_CASE("the numbers of a brick's light points and their coordinates are inverse") {
    std::set<int> seen;
    for (int bit = 0; bit < 64; ++bit) {
        const glm::ivec3 place = lightmesh::detail::coord_of(bit);
        CHECK(lightmesh::detail::bit_of(place.x, place.y, place.z) == bit);
        seen.insert(place.x + 4 * place.y + 16 * place.z);
    }
    CHECK(seen.size() == 64);
}

TEST_CASE("a hemisphere is that of equation (2) but for its documented rounding") {
    test::Random random(71);
    std::size_t sure = 0;
    std::size_t unsure = 0;
    for (const float quality : {1.0f, 1.7f, 2.0f, 3.0f, 4.0f, 7.9f, 8.0f, 8.1f, 16.0f}) {
        const Grid grid = grid_of(1.5f, quality);
        for (int i = 0; i < (quality < 5.0f ? 60 : 8); ++i) {
            const glm::vec3 p(random.in_box(Vec(-9.0), Vec(9.0)));
            glm::vec3 n(random.direction());
            if (i % 4 == 0)
                n = glm::vec3(glm::round(Vec(n)));  // Along axes and diagonals, or zero.
            const std::set<Index> found = points_of(grid, p, n);
            const test::PlainMesh plain({}, {}, grid.origin(), grid.step(), static_cast<double>(quality),
                                        lightmesh::ShortTest::none);
            std::size_t expected = 0;
            std::size_t possible = 0;
            for (const test::Neighbour& x : plain.neighbours(p, n)) {
                const Vec place = glm::round((x.position - grid.origin()) / grid.step());
                const Index index{static_cast<int>(place.x), static_cast<int>(place.y),
                                  static_cast<int>(place.z)};
                const bool is_in = found.count(index) > 0;
                if (x.belongs == test::Answer::yes)
                    CHECK(is_in);
                expected += x.belongs == test::Answer::yes;
                possible += is_in;
                (x.belongs == test::Answer::yes ? sure : unsure) += 1;
            }
            CHECK(possible == found.size());  // Nothing else.
            CHECK(found.size() >= expected);
        }
    }
    CHECK(unsure < sure / 200);
}

TEST_CASE("light points on the tangent plane are out") {
    for (const float quality : {1.0f, 3.0f, 4.0f, 9.0f}) {
        for (const double moved : {0.0, 1000.0}) {
            const Grid grid = grid_of(1.0f, quality, glm::vec3(0.0f));
            for (int axis = 0; axis < 3; ++axis) {
                for (const int side : {-1, 1}) {
                    const int layer = static_cast<int>(std::round(moved / grid.step())) + 3;
                    Vec place = Vec(moved + 0.013, moved - 0.21, moved + 0.4);
                    place[axis] = layer * grid.step();
                    Vec normal(0.0);
                    normal[axis] = side;
                    for (const auto& [x, y, z] : points_of(grid, glm::vec3(place), glm::vec3(normal)))
                        CHECK(side * (glm::ivec3(x, y, z)[axis] - layer) >= 1);
                }
            }
        }
    }
}

TEST_CASE("a grid too fine for its coordinates has empty hemispheres, in all kernels") {
    const Grid grid = grid_of(1.0f, 4.0f, glm::vec3(0, 3e8f, 0));
    CHECK(points_of(grid, {0, 3e8f, 0}, {0, 1, 0}).empty());
    CHECK(points_of(grid, {0, 3e8f, 0}, {-1, 0, 0}).empty());
}

TEST_CASE("a zero normal has an empty hemisphere") {
    CHECK(points_of(grid_of(1.0f, 16.0f), {1, 2, 3}, {0, 0, 0}).empty());
    CHECK(points_of(grid_of(1.0f, 1.0f), {1, 2, 3}, {0, 0, 0}).empty());
}

}  // namespace hemisphere_test
