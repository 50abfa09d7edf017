// SPDX-License-Identifier: MIT
#include "smooth_normals.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace demo {
namespace {

constexpr float cosine_of_sharpest = 0.7660444f;  // 40 degrees
/// In a place where more triangles meet all of them count: their pairs would take too long.
constexpr std::size_t most_around = 64;

/// A corner of a triangle, as it counts for the normal in its place.
struct Corner {
    glm::vec3 normal;  ///< of the triangle; 0 if it has no area
    float angle;
};

Corner corner_at(const ModelMesh& mesh, std::uint32_t corner) {
    const auto position = [&](std::uint32_t turn) {
        return mesh.positions[mesh.indices[corner / 3 * 3 + (corner + turn) % 3]];
    };
    const glm::dvec3 first = position(1) - position(0);
    const glm::dvec3 second = position(2) - position(0);
    const glm::dvec3 normal = glm::cross(first, second);
    const double length = glm::length(normal);
    if (!(length > 0.0))
        return {glm::vec3(0.0f), 0.0f};
    return {glm::vec3(normal / length), static_cast<float>(std::atan2(length, glm::dot(first, second)))};
}

/// Corners of triangles in the order of their places, so that those of one place follow each other.
std::vector<std::uint32_t> corners_by_place(const ModelMesh& mesh) {
    std::vector<std::uint32_t> corners(mesh.indices.size());
    std::iota(corners.begin(), corners.end(), 0u);
    const auto key = [&](std::uint32_t corner) {
        const glm::dvec3& p = mesh.positions[mesh.indices[corner]];
        return std::tuple(p.x, p.y, p.z, mesh.indices[corner], corner);
    };
    std::ranges::sort(corners, {}, key);
    return corners;
}

glm::vec3 unit(const glm::vec3& v) {
    const float length = glm::length(v);
    return length > 0.0f ? v / length : glm::vec3(0.0f);
}

/// The normal of a corner by those in its place, weighted by their angles (Thuermer and Wuethrich, "Computing
/// Vertex Normals from Polygonal Facets", 1998): however polygons are cut, it is the same.
glm::vec3 normal_of(const Corner& own, std::span<const Corner> around, float sharpest) {
    glm::vec3 sum(0.0f);
    for (const Corner& other : around)
        if (glm::dot(own.normal, other.normal) >= sharpest)
            sum += other.angle * other.normal;
    return unit(sum);
}

/// Adds a copy of a vertex.
std::uint32_t copy_vertex(ModelMesh& mesh, std::uint32_t vertex) {
    const auto copy = [vertex](auto& values) {
        if (!values.empty())
            values.push_back(values[vertex]);
    };
    const auto number = static_cast<std::uint32_t>(mesh.positions.size());
    copy(mesh.positions);
    copy(mesh.texture_coordinates[0]);
    copy(mesh.texture_coordinates[1]);
    copy(mesh.colours);
    copy(mesh.normals);
    return number;
}

}  // namespace

void smooth_normals(ModelMesh& mesh) {
    const std::vector<std::uint32_t> corners = corners_by_place(mesh);
    mesh.normals.assign(mesh.positions.size(), glm::vec3(0.0f));
    const auto position = [&](std::size_t i) {
        return mesh.positions[mesh.indices[corners[i]]];
    };
    std::vector<Corner> in_place;
    std::vector<std::uint32_t> vertices;                         // of the corners in one place
    std::vector<std::pair<std::uint32_t, std::uint32_t>> moved;  // vertices, with a copy of another normal
    for (std::size_t first = 0; first < corners.size();) {
        std::size_t last = first + 1;
        while (last < corners.size() && position(last) == position(first))
            ++last;
        const std::span around = std::span(corners).subspan(first, last - first);
        in_place.clear();
        for (const std::uint32_t corner : around)
            in_place.push_back(corner_at(mesh, corner));
        const bool is_crowded = around.size() > most_around;
        const glm::vec3 mean = normal_of(in_place[0], in_place, -2.0f);
        vertices.clear();
        moved.clear();
        for (std::size_t i = 0; i < around.size(); ++i) {
            const std::uint32_t own = mesh.indices[around[i]];
            const glm::vec3 normal = is_crowded ? mean : normal_of(in_place[i], in_place, cosine_of_sharpest);
            std::uint32_t vertex = own;
            if (mesh.normals[own] == glm::vec3(0.0f)) {
                mesh.normals[own] = normal;
            } else if (mesh.normals[own] != normal) {
                const auto same = std::ranges::find_if(moved, [&](const auto& copy) {
                    return copy.first == own && mesh.normals[copy.second] == normal;
                });
                vertex = same != moved.end() ? same->second : copy_vertex(mesh, own);
                if (same == moved.end()) {
                    mesh.normals[vertex] = normal;
                    moved.emplace_back(own, vertex);
                }
            }
            vertices.push_back(vertex);
        }
        for (std::size_t i = 0; i < around.size(); ++i)
            mesh.indices[around[i]] = vertices[i];
        first = last;
    }
}

}  // namespace demo
