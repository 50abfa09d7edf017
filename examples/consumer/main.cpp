// SPDX-License-Identifier: MIT
#include <lightmesh/lightmesh.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cstdio>
#include <vector>

// A ball over the ground z = 0, one lamp above it, and how lit the ground is on a line under the ball.

struct Ball {
    glm::vec3 middle;
    float radius;

    bool occluded(const lightmesh::Segment& segment) const {
        const glm::vec3 way = segment.target - segment.origin;
        const float length = glm::dot(way, way);
        const float nearest = length > 0.0f ? glm::dot(middle - segment.origin, way) / length : 0.0f;
        const glm::vec3 point = segment.origin + std::clamp(nearest, 0.0f, 1.0f) * way;
        return glm::distance(point, middle) < radius;
    }
};

int main() {
    const std::vector<lightmesh::Light> lights{lightmesh::PointLight{{0.0f, 0.0f, 8.0f}}};
    lightmesh::Settings settings;
    settings.radius = 0.5f;
    settings.quality = 5.0f;
    const lightmesh::LightMesh mesh{Ball{{0.0f, 0.0f, 3.0f}, 1.0f}, lights, settings};
    for (const float x : {0.0f, 1.4f, 1.6f, 1.8f, 3.0f}) {
        const float lit = mesh.visibility({x, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0);
        std::printf("%.1f m from the middle of the shadow: %.2f lit\n", static_cast<double>(x),
                    static_cast<double>(lit));
    }
}
