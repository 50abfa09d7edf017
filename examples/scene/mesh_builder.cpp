// SPDX-License-Identifier: MIT
#include "mesh_builder.hpp"

#include "random.hpp"

#include <glm/geometric.hpp>

#include <array>
#include <cmath>

namespace demo {
namespace {

/// Two unit vectors that make a right-handed frame with the unit vector `axis`.
std::array<glm::vec3, 2> frame_around(glm::vec3 axis) {
    const glm::vec3 helper = std::abs(axis.z) < 0.9f ? glm::vec3{0, 0, 1} : glm::vec3{1, 0, 0};
    const glm::vec3 u = glm::normalize(glm::cross(helper, axis));
    return {u, glm::cross(axis, u)};
}

constexpr float golden = 1.618034f;
constexpr std::array<glm::vec3, 12> icosahedron_corners{{{-1, golden, 0},
                                                         {1, golden, 0},
                                                         {-1, -golden, 0},
                                                         {1, -golden, 0},
                                                         {0, -1, golden},
                                                         {0, 1, golden},
                                                         {0, -1, -golden},
                                                         {0, 1, -golden},
                                                         {golden, 0, -1},
                                                         {golden, 0, 1},
                                                         {-golden, 0, -1},
                                                         {-golden, 0, 1}}};
constexpr std::array<std::array<std::size_t, 3>, 20> icosahedron_faces{
    {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};

}  // namespace

std::uint32_t MeshBuilder::add_material(const Material& material) {
    scene_.materials.push_back(material);
    return static_cast<std::uint32_t>(scene_.materials.size() - 1);
}

void MeshBuilder::place(glm::vec3 origin, float turns, float scale) {
    origin_ = origin;
    turn_ = circle_point(turns);
    scale_ = scale;
}

glm::vec3 MeshBuilder::to_world(glm::vec3 p) const {
    return origin_ + scale_ * glm::vec3{turn_.x * p.x - turn_.y * p.y, turn_.y * p.x + turn_.x * p.y, p.z};
}

std::uint32_t MeshBuilder::vertex(glm::vec3 position, glm::vec3 normal) {
    scene_.positions.push_back(to_world(position));
    scene_.normals.push_back(
        {turn_.x * normal.x - turn_.y * normal.y, turn_.y * normal.x + turn_.x * normal.y, normal.z});
    return static_cast<std::uint32_t>(scene_.positions.size() - 1);
}

void MeshBuilder::face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    scene_.triangles.push_back({{a, b, c}, material_});
}

void MeshBuilder::triangle(glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    const glm::vec3 normal = glm::normalize(glm::cross(b - a, c - a));
    const std::uint32_t first = vertex(a, normal);
    vertex(b, normal);
    vertex(c, normal);
    face(first, first + 1, first + 2);
}

void MeshBuilder::quad(glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) {
    const glm::vec3 normal = glm::normalize(glm::cross(c - a, d - b));
    const std::uint32_t first = vertex(a, normal);
    vertex(b, normal);
    vertex(c, normal);
    vertex(d, normal);
    face(first, first + 1, first + 2);
    face(first, first + 2, first + 3);
}

void MeshBuilder::box(glm::vec3 low, glm::vec3 high, bool with_bottom) {
    const auto corner = [&](int x, int y, int z) {
        return glm::vec3{x ? high.x : low.x, y ? high.y : low.y, z ? high.z : low.z};
    };
    quad(corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1));
    quad(corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1));
    quad(corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1));
    quad(corner(1, 1, 0), corner(0, 1, 0), corner(0, 1, 1), corner(1, 1, 1));
    quad(corner(0, 1, 0), corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1));
    if (with_bottom) {
        quad(corner(0, 1, 0), corner(1, 1, 0), corner(1, 0, 0), corner(0, 0, 0));
    }
}

void MeshBuilder::ball(glm::vec3 centre, float radius, int frequency) {
    for (const auto& corners : icosahedron_faces) {
        const glm::vec3 a = icosahedron_corners[corners[0]];
        const glm::vec3 b = icosahedron_corners[corners[1]];
        const glm::vec3 c = icosahedron_corners[corners[2]];
        // Row i, column j of the face; neighbouring faces compute the same bits for the edge they share.
        const auto first = static_cast<std::uint32_t>(scene_.positions.size());
        for (int i = 0; i <= frequency; ++i) {
            for (int j = 0; j <= i; ++j) {
                const glm::vec3 p = a * static_cast<float>(frequency - i) + b * static_cast<float>(i - j) +
                                    c * static_cast<float>(j);
                const glm::vec3 direction = glm::normalize(p);
                vertex(centre + radius * direction, direction);
            }
        }
        const auto at = [first](int i, int j) {
            return first + static_cast<std::uint32_t>(i * (i + 1) / 2 + j);
        };
        for (int i = 0; i < frequency; ++i) {
            for (int j = 0; j <= i; ++j) {
                face(at(i, j), at(i + 1, j), at(i + 1, j + 1));
                if (j < i) {
                    face(at(i, j), at(i + 1, j + 1), at(i, j + 1));
                }
            }
        }
    }
}

void MeshBuilder::tube(glm::vec3 from, glm::vec3 to, float from_radius, float to_radius, int sides) {
    const glm::vec3 axis = glm::normalize(to - from);
    const auto [u, v] = frame_around(axis);
    const float slope = (from_radius - to_radius) / glm::length(to - from);
    const auto first = static_cast<std::uint32_t>(scene_.positions.size());
    for (int side = 0; side < sides; ++side) {
        const glm::vec2 around = circle_point(static_cast<float>(side) / static_cast<float>(sides));
        const glm::vec3 outwards = u * around.x + v * around.y;
        const glm::vec3 normal = glm::normalize(outwards + slope * axis);
        vertex(from + from_radius * outwards, normal);
        vertex(to + to_radius * outwards, normal);
    }
    const auto count = static_cast<std::uint32_t>(sides);
    for (std::uint32_t side = 0; side < count; ++side) {
        const std::uint32_t here = first + 2 * side;
        const std::uint32_t beside = first + 2 * ((side + 1) % count);
        face(here, beside, beside + 1);
        if (to_radius > 0.0f) {
            face(here, beside + 1, here + 1);
        }
    }
}

void MeshBuilder::disc(glm::vec3 centre, glm::vec3 normal, float radius, int sides) {
    const auto [u, v] = frame_around(normal);
    const std::uint32_t middle = vertex(centre, normal);
    for (int side = 0; side < sides; ++side) {
        const glm::vec2 around = circle_point(static_cast<float>(side) / static_cast<float>(sides));
        vertex(centre + radius * (u * around.x + v * around.y), normal);
    }
    const auto count = static_cast<std::uint32_t>(sides);
    for (std::uint32_t side = 0; side < count; ++side) {
        face(middle, middle + 1 + side, middle + 1 + (side + 1) % count);
    }
}

}  // namespace demo
