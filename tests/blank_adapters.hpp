// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lightmesh.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

/// A scene in which there is nothing: for programs that are there to be compiled.

namespace test {

struct BlankTracer {
    bool occluded(const lightmesh::Segment&) const { return false; }
};

struct BlankPictures {
    void render_depth(const lightmesh::DepthView&, std::span<float> distance) {
        for (float& texel : distance)
            texel = std::numeric_limits<float>::infinity();
    }
};

struct BlankTriangles {
    std::size_t triangle_count() const { return 0; }
    std::array<glm::vec3, 3> triangle(std::size_t) const { return {}; }
};

/// The sum of all that a light mesh can be asked for one point and its two lights, 6 if all is well.
template <class Mesh>
float sum_of_queries(const Mesh& mesh) {
    const std::array points{glm::vec3(0.5f, 0.0f, 0.0f)};
    const std::array normals{glm::vec3(0.0f, 0.0f, 1.0f)};
    std::array<float, 2> all{};
    std::array<float, 2> many{};
    mesh.visibility(points[0], normals[0], all);
    mesh.visibility(points, normals, many);
    return all[0] + all[1] + many[0] + many[1] + mesh.visibility(points[0], normals[0], 0) +
           mesh.visibility(points[0], normals[0], 1);
}

/// The same for all kinds of light mesh and for visibility caches: 30.
inline float sum_of_meshes() {
    const std::vector<lightmesh::Light> lights{
        lightmesh::PointLight{{0.0f, 0.0f, 3.0f}},
        lightmesh::SpotLight{{0.0f, 0.0f, 3.0f}, {0.0f, 0.0f, -1.0f}, 1.0f},
    };
    const lightmesh::Settings settings;
    return sum_of_queries(lightmesh::LightMesh{BlankTracer{}, lights, settings}) +
           sum_of_queries(lightmesh::LightMesh{BlankTracer{}, BlankPictures{}, lights, settings}) +
           sum_of_queries(lightmesh::LightMesh{BlankTracer{}, BlankTriangles{}, lights, settings}) +
           sum_of_queries(lightmesh::VisibilityCache{BlankTracer{}, lights, lightmesh::CacheSettings{}}) +
           sum_of_queries(lightmesh::VisibilityCache{lightmesh::LightMesh{BlankTracer{}, lights, settings},
                                                     lightmesh::CacheSettings{}});
}

}  // namespace test
