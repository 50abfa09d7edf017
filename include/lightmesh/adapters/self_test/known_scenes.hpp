// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/self_test/segments.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/segment.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

/// Scenes of which the right answers are known.

namespace lightmesh::detail {

using TestTriangle = std::array<glm::vec3, 3>;

/// A question with its answer.
struct Question {
    Segment segment;
    bool is_blocked = false;
};

/// Puts a scene down that was thought of near the origin, along z: at a scale that is a power of two, z
/// turned to one of the three axes. Nothing is rounded.
struct Placement {
    float scale = 1.0f;
    int axis = 2;

    glm::vec3 operator()(const glm::vec3& v) const {
        glm::vec3 result;
        result[(axis + 1) % 3] = scale * v.x;
        result[(axis + 2) % 3] = scale * v.y;
        result[axis] = scale * v.z;
        return result;
    }
    Segment operator()(const Segment& s) const { return {(*this)(s.origin), (*this)(s.target)}; }
};

inline void add_test_quad(std::vector<TestTriangle>& scene, const glm::vec3& corner, const glm::vec3& u,
                          const glm::vec3& v) {
    scene.push_back({corner, corner + u, corner + u + v});
    scene.push_back({corner, corner + u + v, corner + v});
}

/// A closed box of 12 triangles; of no thickness if `low` and `high` have the same z: 8 of them are empty.
inline std::vector<TestTriangle> test_box(const glm::vec3& low, const glm::vec3& high) {
    std::vector<TestTriangle> scene;
    const glm::vec3 x{high.x - low.x, 0.0f, 0.0f};
    const glm::vec3 y{0.0f, high.y - low.y, 0.0f};
    const glm::vec3 z{0.0f, 0.0f, high.z - low.z};
    add_test_quad(scene, low, y, x);
    add_test_quad(scene, low + z, x, y);
    add_test_quad(scene, low, x, z);
    add_test_quad(scene, low + y, z, x);
    add_test_quad(scene, low, z, y);
    add_test_quad(scene, low + x, y, z);
    return scene;
}

/// Half the side of the sheets; what crosses them keeps off edges by 1/2 and off the diagonal by 1/8.
inline constexpr float test_sheet_size = 4.0f;

/// A square of two triangles over z = slope * (2 x + y).
inline std::vector<TestTriangle> test_sheet(float slope) {
    const float s = test_sheet_size;
    const auto corner = [slope](float x, float y) {
        return glm::vec3{x, y, slope * (2.0f * x + y)};
    };
    return {{corner(-s, -s), corner(s, -s), corner(s, s)}, {corner(-s, -s), corner(s, s), corner(-s, s)}};
}

/// A point on such a sheet.
inline glm::vec3 point_on_sheet(TestNumbers& numbers, float slope) {
    for (;;) {
        const float x = numbers.dyadic(-3, 3);
        const float y = numbers.dyadic(-3, 3);
        if (std::abs(x - y) >= 0.125f)
            return {x, y, slope * (2.0f * x + y)};
    }
}

/// A step through a sheet, 1 in z.
inline glm::vec3 step_through_sheet(TestNumbers& numbers, bool is_straight) {
    if (is_straight)
        return {0.0f, 0.0f, 1.0f};
    const float x = numbers.dyadic(1, 2) * (numbers.below(2) == 0 ? -0.25f : 0.25f);
    const float y = numbers.dyadic(1, 2) * (numbers.below(2) == 0 ? -0.25f : 0.25f);
    return {x, y, 1.0f};
}

/// Triangles of all sizes in all directions within +-5.
inline std::vector<TestTriangle> test_soup(TestNumbers& numbers) {
    std::vector<TestTriangle> scene;
    const Bounds centres{glm::vec3(-4.0f), glm::vec3(4.0f)};
    const Bounds corners{glm::vec3(-1.0f), glm::vec3(1.0f)};
    while (scene.size() < 32) {
        const glm::vec3 centre = numbers.inside(centres);
        const TestTriangle triangle{centre + numbers.inside(corners), centre + numbers.inside(corners),
                                    centre + numbers.inside(corners)};
        if (glm::length(glm::cross(triangle[1] - triangle[0], triangle[2] - triangle[0])) > 0.5f)
            scene.push_back(triangle);
    }
    return scene;
}

/// True if a triangle blocks, in double, by signed volumes; nothing where the segment comes near to an edge,
/// an end to the triangle, or the segment to the triangle's plane.
inline std::optional<bool> blocks(const TestTriangle& triangle, const Segment& segment) {
    using Vector = std::array<double, 3>;
    const auto between = [](const glm::vec3& from, const glm::vec3& to) {
        return Vector{static_cast<double>(to.x) - static_cast<double>(from.x),
                      static_cast<double>(to.y) - static_cast<double>(from.y),
                      static_cast<double>(to.z) - static_cast<double>(from.z)};
    };
    const auto cross = [](const Vector& a, const Vector& b) {
        return Vector{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    const auto dot = [](const Vector& a, const Vector& b) {
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    };
    constexpr double doubt = 1e-3;

    const Vector direction = between(segment.origin, segment.target);
    const Vector normal = cross(between(triangle[0], triangle[1]), between(triangle[0], triangle[2]));
    const double slope = dot(normal, direction);
    const double along = dot(normal, between(segment.origin, triangle[0]));
    const double size = std::sqrt(dot(normal, normal));
    const double length = std::sqrt(dot(direction, direction));
    if (std::abs(slope) < doubt * size * length)
        return std::abs(along) > 2.0 * doubt * size * length ? std::optional(false) : std::nullopt;
    const double t = along / slope;
    const double end_doubt = doubt / length + doubt;
    if (t < -end_doubt || t > 1.0 + end_doubt)
        return false;
    bool is_sure = std::abs(t) > end_doubt && std::abs(t - 1.0) > end_doubt;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector a = between(segment.origin, triangle[i]);
        const Vector b = between(segment.origin, triangle[(i + 1) % 3]);
        const double share = dot(direction, cross(a, b)) / slope;
        if (share < -doubt)
            return false;
        is_sure = is_sure && share > doubt;
    }
    return is_sure ? std::optional(true) : std::nullopt;
}

/// The same for all of them.
inline std::optional<bool> blocks(const std::vector<TestTriangle>& scene, const Segment& segment) {
    bool is_sure = true;
    for (const TestTriangle& triangle : scene) {
        const std::optional<bool> answer = blocks(triangle, segment);
        if (answer == true)
            return true;
        is_sure = is_sure && answer.has_value();
    }
    return is_sure ? std::optional(false) : std::nullopt;
}

}  // namespace lightmesh::detail
