// SPDX-License-Identifier: MIT
#pragma once

#include "hit_tracer.hpp"
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <vector>

namespace test {

/// What a mesh or a cache says of all lights.
template <class Subject>
std::vector<float> ask(const Subject& subject, const lightmesh::SurfacePoint& point) {
    std::vector<float> all(subject.light_count());
    subject.visibility(point, all);
    return all;
}

/// Some boxes, lights, and points to fill a mesh or cache at.
struct StillWorld {
    std::vector<Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<lightmesh::SurfacePoint> points;

    explicit StillWorld(int light_count, int point_count = 60) {
        Random random(5);
        scene = boxes_on_floor(random, 4);
        for (int i = 0; i < light_count; ++i)
            lights.push_back(lightmesh::PointLight{
                .position = glm::vec3(random.in_box({-4.0, -4.0, 1.0}, {4.0, 4.0, 4.5})), .radius = 0.4f});
        for (const auto& [position, normal] : surface_points(random, scene, point_count))
            points.push_back({.position = position, .normal = normal});
    }

    auto mesh(bool adaptive = true) const {
        lightmesh::Settings settings{.radius = 0.9f, .quality = 3.0f};
        settings.adaptive_long_tests = adaptive;
        return lightmesh::LightMesh{PlainTracer{&scene}, lights, settings};
    }
    auto cache() const {
        return lightmesh::VisibilityCache{HitTracer{&scene}, lights,
                                          lightmesh::CacheSettings{.spacing = 0.4f, .detail = 2}};
    }
};

}  // namespace test
