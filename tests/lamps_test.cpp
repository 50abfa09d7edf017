// SPDX-License-Identifier: MIT
#include "render/embree_scene.hpp"
#include "render/lamps.hpp"
#include "render/visibility.hpp"
#include "scene/scene.hpp"

#include <lightmesh/lights.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <variant>
#include <vector>

namespace lamps_test {

namespace {

/// A triangle with one light of each kind; the spot has a size of its own.
demo::Scene scene_of_lights() {
    demo::Scene scene;
    scene.positions = {{0, 0, 0}, {6, 0, 0}, {0, 8, 0}};
    scene.triangles = {{{0, 1, 2}, 0}};
    scene.materials = {{}};
    scene.lights = {{lightmesh::PointLight{{0, 0, 5}}},
                    {lightmesh::SpotLight{.position = {1, 0, 5}, .radius = 0.25f}},
                    {lightmesh::DirectionalLight{{0, 0, -1}}},
                    {lightmesh::RectLight{.position = {0, 1, 5}, .half_u = {2, 0, 0}, .half_v = {0, 1, 0}}}};
    return scene;
}

}  // namespace

TEST_CASE("lamps: sizes are the scene's, else a third of r and the sun's angle") {
    const demo::Scene scene = scene_of_lights();
    const demo::EmbreeScene embree(scene);
    demo::VisibilityOptions options;
    options.settings.radius = 0.9f;
    const std::vector<lightmesh::Light> lamps = demo::lamps_of(embree, options);
    REQUIRE(lamps.size() == 4);
    CHECK(std::get<lightmesh::PointLight>(lamps[0]).radius == doctest::Approx(0.3));
    CHECK(std::get<lightmesh::SpotLight>(lamps[1]).radius == 0.25f);
    CHECK(std::get<lightmesh::DirectionalLight>(lamps[2]).angular_radius == doctest::Approx(0.00465));
    CHECK(std::get<lightmesh::RectLight>(lamps[3]).half_u == glm::vec3(2, 0, 0));
    CHECK(demo::lamp_size_text(lamps) == "0.25 to 0.3, 0.00465 rad");
}

TEST_CASE("lamps: a size that is asked for is that of all but rectangles") {
    const demo::Scene scene = scene_of_lights();
    const demo::EmbreeScene embree(scene);
    demo::VisibilityOptions options;
    options.light_size = 0.5f;
    const std::vector<lightmesh::Light> lamps = demo::lamps_of(embree, options);
    CHECK(std::get<lightmesh::PointLight>(lamps[0]).radius == 0.5f);
    CHECK(std::get<lightmesh::SpotLight>(lamps[1]).radius == 0.5f);
    // The triangle's box has a diagonal of 10: seen from its middle, half of it away.
    CHECK(std::get<lightmesh::DirectionalLight>(lamps[2]).angular_radius == doctest::Approx(std::atan(0.1)));
    CHECK(std::get<lightmesh::RectLight>(lamps[3]).half_v == glm::vec3(0, 1, 0));
    CHECK(demo::lamp_size_text(lamps) == "0.5, 0.09967 rad");
    CHECK(demo::lamp_size_text({}) == "-");
}

}  // namespace lamps_test
