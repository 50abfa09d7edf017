// SPDX-License-Identifier: MIT
#include "smooth_normals.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
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
/// Around a place where more triangles meet all of them count: their pairs would take too long.
constexpr std::size_t most_around = 64;

/// The normal of each triangle, as long as twice its area.
std::vector<glm::vec3> triangle_normals(const ModelMesh& mesh) {
    std::vector<glm::vec3> normals;
    normals.reserve(mesh.indices.size() / 3);
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        const glm::dvec3& a = mesh.positions[mesh.indices[i]];
        const glm::dvec3 normal =
            glm::cross(mesh.positions[mesh.indices[i + 1]] - a, mesh.positions[mesh.indices[i + 2]] - a);
        normals.emplace_back(normal);
    }
    return normals;
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

/// The normal of the corner of triangle `own`, by the triangles of all corners in its place.
glm::vec3 normal_of(std::span<const std::uint32_t> around, std::uint32_t own,
                    const std::vector<glm::vec3>& normals) {
    const glm::vec3 direction = unit(normals[own]);
    glm::vec3 sum(0.0f);
    for (const std::uint32_t corner : around) {
        const glm::vec3& other = normals[corner / 3];
        if (around.size() > most_around || glm::dot(direction, unit(other)) >= cosine_of_sharpest)
            sum += other;
    }
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
    const std::vector<glm::vec3> normals = triangle_normals(mesh);
    const std::vector<std::uint32_t> corners = corners_by_place(mesh);
    mesh.normals.assign(mesh.positions.size(), glm::vec3(0.0f));
    const auto position = [&](std::size_t i) {
        return mesh.positions[mesh.indices[corners[i]]];
    };
    std::vector<std::uint32_t> vertices;                         // of the corners in one place
    std::vector<std::pair<std::uint32_t, std::uint32_t>> moved;  // vertices, with a copy of another normal
    for (std::size_t first = 0; first < corners.size();) {
        std::size_t last = first + 1;
        while (last < corners.size() && position(last) == position(first))
            ++last;
        const std::span around = std::span(corners).subspan(first, last - first);
        vertices.clear();
        moved.clear();
        for (const std::uint32_t corner : around) {
            const std::uint32_t own = mesh.indices[corner];
            const glm::vec3 normal = normal_of(around, corner / 3, normals);
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
