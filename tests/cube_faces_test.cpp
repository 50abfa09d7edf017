// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/shadows/cube_faces.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <cstddef>

namespace cube_faces_test {

using namespace lightmesh::detail;

TEST_CASE("a direction passes through the face whose axis is nearest to it") {
    test::Random random(41);
    for (int i = 0; i < 1000; ++i) {
        const test::Vec direction = random.uniform(1e-3, 1e3) * random.direction();
        const std::size_t found = cube_face_of(direction);
        for (std::size_t face = 0; face < cube_face_count; ++face)
            CHECK(glm::dot(direction, test::Vec(cube_face_axis(found))) >=
                  glm::dot(direction, test::Vec(cube_face_axis(face))));
    }
}

TEST_CASE("each face's axis passes through it, and an edge belongs to the first of its faces") {
    for (std::size_t face = 0; face < cube_face_count; ++face) {
        CHECK(cube_face_of(cube_face_axis(face)) == face);
        CHECK(glm::length(cube_face_axis(face)) == 1.0f);
    }
    CHECK(cube_face_of(glm::vec3(1.0f, 1.0f, -1.0f)) == 0);
    CHECK(cube_face_of(glm::vec3(0.5f, -1.0f, 1.0f)) == 3);
}

}  // namespace cube_faces_test
