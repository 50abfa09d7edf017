// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lightmesh.hpp>

#include <glm/glm.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <iostream>
#include <limits>
#include <span>
#include <string>
#include <vector>

/// A renderer small enough to be read in a minute: two balls on and above a floor, and a ray tracer for them.
/// The programs beside this file add one feature of the library each.

namespace scene {

using glm::vec3;

struct Ball {
    vec3 middle;
    float radius;
};

/// One lies on the floor z = 0, one hovers.
inline constexpr std::array<Ball, 2> balls{Ball{{-2.0f, 0.0f, 0.8f}, 0.8f}, Ball{{2.0f, 0.0f, 2.5f}, 0.8f}};

/// The place where a ray first crosses a surface, as a multiple of `way`; infinity if it does not.
inline float first_hit(const vec3& origin, const vec3& way) {
    float nearest = std::numeric_limits<float>::infinity();
    if (const float t = -origin.z / way.z; t > 0.0f)
        nearest = t;
    for (const Ball& ball : balls) {
        const vec3 to_middle = ball.middle - origin;
        const float a = glm::dot(way, way), b = glm::dot(way, to_middle);
        const float square = b * b - a * (glm::dot(to_middle, to_middle) - ball.radius * ball.radius);
        if (square < 0.0f)
            continue;
        const float root = std::sqrt(square);
        const float t = (b - root > 0.0f ? b - root : b + root) / a;
        if (t > 0.0f && t < nearest)
            nearest = t;
    }
    return nearest;
}

/// The adapter: all that a light mesh has to know of a ray tracer.
struct Tracer {
    bool occluded(const lightmesh::Segment& segment) const {
        return first_hit(segment.origin, segment.target - segment.origin) < 1.0f;
    }
};

/// The second adapter, for shadow maps: how far does a light see through the middle of each texel?
struct DepthRenderer {
    void render_depth(const lightmesh::DepthView& view, std::span<float> distance) {
        for (int row = 0; row < view.resolution; ++row)
            for (int column = 0; column < view.resolution; ++column) {
                const lightmesh::DepthRay ray = view.ray(column, row);
                distance[static_cast<std::size_t>(row * view.resolution + column)] =
                    first_hit(ray.origin, ray.direction);
            }
    }
    lightmesh::Bounds bounds() const { return {{-9.0f, -9.0f, 0.0f}, {9.0f, 9.0f, 4.0f}}; }
};

/// Two lamps, to either side of the balls.
inline const std::vector<lightmesh::Light> lights{lightmesh::PointLight{.position = {-4.0f, 0.0f, 8.0f}},
                                                  lightmesh::PointLight{.position = {5.0f, 1.0f, 7.0f}}};

/// Shading points: a row of the floor, from left to right through the shadows.
inline std::vector<vec3> floor_points(int count = 65) {
    std::vector<vec3> points;
    for (int i = 0; i < count; ++i)
        points.push_back({-6.0f + 12.0f * static_cast<float>(i) / static_cast<float>(count - 1), 0.0f, 0.0f});
    return points;
}
inline constexpr vec3 floor_normal{0.0f, 0.0f, 1.0f};

/// Prints visibilities as a row of digits: 0 is shadow, 9 lit.
inline void print_row(const std::string& name, std::span<const float> visibilities) {
    std::string digits;
    for (const float visibility : visibilities)
        digits += std::isnan(visibility) ? '?' : static_cast<char>('0' + std::lround(9.0f * visibility));
    std::cout << name << std::string(name.size() < 14 ? 14 - name.size() : 1, ' ') << digits << '\n';
}

}  // namespace scene
