// SPDX-License-Identifier: MIT

// Compiled for GLM's macros that change its types or conventions, several at a time.

#include "analytic.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <vector>

namespace {

/// A slab over the middle of the ground.
const test::BoxScene scene{{lightmesh::Bounds{{-1.0f, -1.0f, 1.0f}, {1.0f, 1.0f, 1.2f}}}};

struct Tracer {
    bool occluded(const lightmesh::Segment& segment) const {
        return scene.blocked(glm::dvec3(segment.origin), glm::dvec3(segment.target));
    }
};

/// The slab's upper side.
struct Triangles {
    std::size_t triangle_count() const { return 2; }
    std::array<glm::vec3, 3> triangle(std::size_t i) const {
        const float other = i == 0 ? 1.0f : -1.0f;
        return {glm::vec3(-1.0f, -1.0f, 1.1f), glm::vec3(1.0f, 1.0f, 1.1f), glm::vec3(other, -other, 1.1f)};
    }
};

const std::vector<lightmesh::Light> lights{
    lightmesh::PointLight{{0.2f, -0.1f, 6.0f}},
    lightmesh::SpotLight{{-0.1f, 0.2f, 6.0f}, {0.0f, 0.0f, -1.0f}, 1.2f},
    lightmesh::DirectionalLight{{0.1f, 0.0f, -1.0f}},
};

lightmesh::Settings settings(lightmesh::ShortTest short_test) {
    lightmesh::Settings chosen;
    chosen.radius = 0.25f;
    chosen.short_test = short_test;
    chosen.shadow_map_size = 128;
    chosen.scene_bounds = lightmesh::Bounds{{-4.0f, -4.0f, 0.0f}, {4.0f, 4.0f, 2.0f}};
    return chosen;
}

void check(const auto& mesh) {
    const glm::vec3 up(0.0f, 0.0f, 1.0f);
    std::array<float, 3> all{};
    mesh.visibility(glm::vec3(0.1f, 0.1f, 0.0f), up, all);
    CHECK(all == std::array{0.0f, 0.0f, 0.0f});
    mesh.visibility(glm::vec3(2.5f, -2.5f, 0.0f), up, all);
    CHECK(all == std::array{1.0f, 1.0f, 1.0f});
    mesh.visibility(glm::vec3(0.1f, 0.1f, 0.0f), -up, all);
    CHECK(all == std::array{0.0f, 0.0f, 0.0f});
}

}  // namespace

TEST_CASE("lit and dark points, whatever GLM's macros are") {
    using lightmesh::ShortTest;
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked, ShortTest::exact}) {
        check(lightmesh::LightMesh{Tracer{}, lights, settings(short_test)});
        check(lightmesh::LightMesh{Tracer{}, test::BoxRenderer{&scene}, lights, settings(short_test)});
        check(lightmesh::LightMesh{Tracer{}, Triangles{}, lights, settings(short_test)});
    }
    check(lightmesh::VisibilityCache{Tracer{}, lights, lightmesh::CacheSettings{.spacing = 0.25f}});
}
