// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/query/seeds.hpp>
#include <lightmesh/support/vectors.hpp>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <cstddef>
#include <vector>

namespace seeds_test {

namespace {

using lightmesh::detail::SeedCandidates;

std::vector<glm::ivec3> all_of(SeedCandidates seeds) {
    std::vector<glm::ivec3> all;
    while (!seeds.empty())
        all.push_back(seeds.next());
    return all;
}

bool is_even(const glm::ivec3& pos) {
    return ((pos.x ^ pos.y ^ pos.z) & 1) == 0;
}

}  // namespace

TEST_CASE(
    "seeds are the corners of the cube in front of a point, even ones first, nearer ones before others") {
    const lightmesh::Grid grid(lightmesh::Settings{.radius = 1.0f, .quality = 4.0f});
    test::Random random(31);
    for (int i = 0; i < 500; ++i) {
        const glm::vec3 point(random.in_box(test::Vec(-3.0), test::Vec(3.0)));
        const glm::vec3 normal = lightmesh::detail::unit_or_zero(glm::vec3(random.direction()));
        const glm::dvec3 pos = grid.locate(point);
        const glm::dvec3 ahead = pos + 0x1p-7 * glm::dvec3(normal);
        const std::vector<glm::ivec3> seeds = all_of(SeedCandidates(grid, pos, point, normal));
        REQUIRE(seeds.size() == 8);
        for (std::size_t k = 0; k < seeds.size(); ++k) {
            const glm::dvec3 offset = glm::dvec3(seeds[k]) - glm::floor(ahead);
            CHECK((offset.x == 0.0 || offset.x == 1.0));
            CHECK((offset.y == 0.0 || offset.y == 1.0));
            CHECK((offset.z == 0.0 || offset.z == 1.0));
            CHECK(is_even(seeds[k]) == (k < 4));
            // To a 1024th of a step along each axis.
            if (k % 4 != 0)
                CHECK(glm::distance(glm::dvec3(seeds[k - 1]), ahead) <
                      glm::distance(glm::dvec3(seeds[k]), ahead) + 0.005);
            for (std::size_t other = 0; other < k; ++other)
                CHECK(seeds[other] != seeds[k]);
        }
    }
}

TEST_CASE("seeds of a wall on a plane of the grid lie before it, on either side") {
    const lightmesh::Grid grid(
        lightmesh::Settings{.radius = 1.0f, .quality = 4.0f, .origin = glm::vec3(0.0f)});
    for (const float side : {-1.0f, 1.0f}) {
        const glm::vec3 point(0.3f, 0.4f, 0.5f);
        const glm::vec3 normal(0.0f, 0.0f, side);
        bool is_ahead = false;
        for (const glm::ivec3& seed : all_of(SeedCandidates(grid, grid.locate(point), point, normal))) {
            CHECK((seed.z == 2 || seed.z == 2 + static_cast<int>(side)));
            is_ahead |= seed.z == 2 + static_cast<int>(side);
        }
        CHECK(is_ahead);
    }
}

}  // namespace seeds_test
