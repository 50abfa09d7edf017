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

// Through narrow gaps points see few of the light points around: twenty rays may miss these.
TEST_CASE("in rooms hardly a visible point is black by linked short tests where it is lit by exact ones") {
    const demo::Scene scene = demo::make_rooms();
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
    std::size_t lit = 0;
    std::size_t black = 0;
    double difference = 0.0;
    const std::vector<lightmesh::SurfacePoint> points = test::seen_points(traced, 80);
    for (const lightmesh::SurfacePoint& point : points) {
        exact.visibility(point, expected);
        linked.visibility(point, found);
        for (std::size_t l = 0; l < lights.size(); ++l) {
            difference += static_cast<double>(std::abs(found[l] - expected[l]));
            if (expected[l] <= 0.1f)
                continue;
            ++lit;
            black += found[l] == 0.0f ? 1u : 0u;
        }
    }
    CHECK(points.size() > 5000);
    CHECK(lit > points.size());
    CHECK(black * 2000 < lit);
    CHECK(difference / static_cast<double>(points.size() * lights.size()) < 0.001);
}

}  // namespace linked_scenes_test
