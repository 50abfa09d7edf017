// SPDX-License-Identifier: MIT
#include "../examples/render/embree_scene.hpp"
#include "../examples/scene/scene.hpp"
#include "seen_points.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <vector>

// How near linked short tests come to exact ones in a built-in scene, at the points that its camera sees.

namespace linked_scenes_test {

namespace {

struct Compared {
    std::size_t points = 0;
    std::size_t lit = 0;           ///< pairs of a point and a light that are lit by exact short tests
    std::size_t black_points = 0;  ///< where these are all black by linked ones
    std::size_t black = 0;         ///< pairs that are
    double difference = 0.0;       ///< mean, of all pairs
};

Compared compare(const demo::Scene& scene, int side) {
    const demo::EmbreeScene traced(scene);
    const std::vector<lightmesh::Light> lights = demo::shapes_of_lights(scene);
    lightmesh::Settings settings{.radius = scene.radius, .quality = scene.quality};
    settings.short_test = lightmesh::ShortTest::exact;
    const lightmesh::LightMesh exact{traced.intersector(), lights, settings};
    settings.short_test = lightmesh::ShortTest::linked;
    settings.adaptive_long_tests = false;
    const lightmesh::LightMesh linked{traced.intersector(), lights, settings};
    std::vector<float> expected(lights.size());
    std::vector<float> found(lights.size());
    Compared all;
    for (const lightmesh::SurfacePoint& point : test::seen_points(traced, side)) {
        exact.visibility(point, expected);
        linked.visibility(point, found);
        ++all.points;
        std::size_t lit = 0;
        std::size_t black = 0;
        for (std::size_t l = 0; l < lights.size(); ++l) {
            all.difference += static_cast<double>(std::abs(found[l] - expected[l]));
            if (expected[l] <= 0.1f)
                continue;
            ++lit;
            black += found[l] == 0.0f ? 1u : 0u;
        }
        all.lit += lit;
        all.black += black;
        all.black_points += lit != 0 && black == lit ? 1u : 0u;
    }
    all.difference /= static_cast<double>(all.points * lights.size());
    return all;
}

}  // namespace

// Through narrow gaps points see few of the light points around: no twenty rays find them.
TEST_CASE("in rooms no visible point is black by linked short tests where it is lit by exact ones") {
    const Compared rooms = compare(demo::make_rooms(), 80);
    CHECK(rooms.points > 5000);
    CHECK(rooms.lit > rooms.points);
    CHECK(rooms.black == 0);
    CHECK(rooms.difference < 0.001);
}

TEST_CASE("nor is one among spheres or in the park") {
    const Compared spheres = compare(demo::make_spheres(), 40);
    CHECK(spheres.points > 1500);
    CHECK(spheres.lit > spheres.points);
    CHECK(spheres.black == 0);
    CHECK(spheres.difference < 0.0002);
    // There what is seen is not all that links lead to: single lights may be lost.
    const Compared park = compare(demo::make_park(), 40);
    CHECK(park.points > 1400);
    CHECK(park.lit > 10 * park.points);
    CHECK(park.black_points == 0);
    CHECK(10000 * park.black < park.lit);
    CHECK(park.difference < 0.02);
}

}  // namespace linked_scenes_test
