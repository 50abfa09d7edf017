// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

// Cones of 1e-4 radians and ranges that end at a point, in a scene where much is in shadow, against the plain
// version.

namespace narrow_cones_test {

namespace {

using lightmesh::ShortTest;

/// A spot light at a point, by a narrow cone and a range of which either may just hold it, or just not.
lightmesh::SpotLight aimed_at(test::Random& random, const test::SurfacePoint& at, bool in_cone,
                              bool in_range) {
    constexpr double cone = 1e-4;
    const glm::vec3 position(random.in_box(test::Vec(-5.0, -5.0, 0.0), test::Vec(5.0, 5.0, 6.0)));
    const test::Vec to_point = test::Vec(at.position) - test::Vec(position);
    const test::Vec aside = glm::normalize(glm::cross(to_point, random.direction()));
    const double angle = in_cone ? 0.8 * cone : 1.2 * cone;
    const double length = glm::length(to_point);
    return {.position = position,
            .axis = glm::vec3(to_point + length * std::tan(angle) * aside),
            .cone = static_cast<float>(cone),
            .range = static_cast<float>(in_range ? 1.001 * length : 0.999 * length)};
}

}  // namespace

TEST_CASE("narrow cones and ranges that end at a point have equation 3 among blockers") {
    test::Random random(28);
    const std::vector<test::Triangle> scene = test::boxes_on_floor(random, 6);
    const std::vector<test::SurfacePoint> points = test::surface_points(random, scene, 120);
    std::vector<lightmesh::Light> lights;
    for (const test::SurfacePoint& point : points)
        for (int i = 0; i < 4; ++i)
            lights.emplace_back(aimed_at(random, point, i != 1, i != 2));
    for (const ShortTest short_test : {ShortTest::linked, ShortTest::exact}) {
        CAPTURE(static_cast<int>(short_test));
        lightmesh::Settings settings;
        settings.radius = 0.8f;
        settings.quality = 3.0f;
        settings.short_test = short_test;
        settings.adaptive_long_tests = false;
        const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights, settings};
        const test::PlainMesh plain(scene, lights, mesh.grid().origin(), mesh.grid().step(), 3.0, short_test);
        std::vector<float> all(lights.size());
        int lit = 0;
        int between = 0;
        int blocked = 0;
        int unsure = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto& [position, normal] = points[i];
            const auto neighbours = plain.neighbours(position, normal);
            mesh.visibility(position, normal, std::span<float>(all));
            for (std::size_t l = 0; l < lights.size(); ++l) {
                CAPTURE(i);
                CAPTURE(l);
                CAPTURE(all[l]);
                const test::Interval expected = plain.visibility(position, normal, neighbours, l);
                CHECK(expected.contains(all[l]));
                // Its own lights, of which two hold it and two do not.
                if (l / 4 != i)
                    continue;
                const float one = mesh.visibility(position, normal, l);
                CHECK(std::bit_cast<std::uint32_t>(one) == std::bit_cast<std::uint32_t>(all[l]));
                unsure += expected.is_sure() ? 0 : 1;
                if (l % 4 == 1 || l % 4 == 2) {
                    CHECK(all[l] == 0.0f);
                    continue;
                }
                const bool faces =
                    glm::dot(normal, std::get<lightmesh::SpotLight>(lights[l]).position - position) > 0.0f;
                lit += all[l] == 1.0f ? 1 : 0;
                between += all[l] > 0.0f && all[l] < 1.0f ? 1 : 0;
                blocked += faces && all[l] == 0.0f ? 1 : 0;
            }
        }
        CHECK(lit > 20);
        CHECK(between > 10);
        CHECK(blocked > 20);
        CHECK(unsure < 120);
    }
}

}  // namespace narrow_cones_test
