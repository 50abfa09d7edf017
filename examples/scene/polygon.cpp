// SPDX-License-Identifier: MIT
#include "polygon.hpp"

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace demo {
namespace {

/// Polygons of more corners are cut as if they had no notches: ears would take the cube of their number.
constexpr std::size_t most_corners = 256;

double cross(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

/// A polygon in the plane in which it is widest, counterclockwise.
std::vector<glm::dvec2> flattened(std::span<const std::uint32_t> corners,
                                  const std::vector<glm::dvec3>& positions) {
    const glm::dvec3& start = positions[corners[0]];
    glm::dvec3 normal(0.0);
    for (std::size_t i = 1; i + 1 < corners.size(); ++i)
        normal += glm::cross(positions[corners[i]] - start, positions[corners[i + 1]] - start);
    const glm::dvec3 size = glm::abs(normal);
    const int dropped = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
    const int u = (dropped + 1) % 3;
    const int v = (dropped + 2) % 3;
    std::vector<glm::dvec2> flat;
    for (const std::uint32_t corner : corners) {
        const glm::dvec3 p = positions[corner] - start;
        flat.emplace_back(normal[dropped] < 0.0 ? p[v] : p[u], normal[dropped] < 0.0 ? p[u] : p[v]);
    }
    return flat;
}

}  // namespace

void add_polygon(std::span<const std::uint32_t> corners, const std::vector<glm::dvec3>& positions,
                 std::vector<std::uint32_t>& indices) {
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
        indices.insert(indices.end(), {corners[a], corners[b], corners[c]});
    };
    if (corners.size() < 3)
        return;
    if (corners.size() == 3 || corners.size() > most_corners) {
        for (std::size_t i = 1; i + 1 < corners.size(); ++i)
            add(0, i, i + 1);
        return;
    }
    const std::vector<glm::dvec2> flat = flattened(corners, positions);
    std::vector<std::size_t> left(corners.size());
    for (std::size_t i = 0; i < left.size(); ++i)
        left[i] = i;
    const auto is_ear = [&](std::size_t at) {
        const std::size_t before = left[(at + left.size() - 1) % left.size()];
        const std::size_t middle = left[at];
        const std::size_t after = left[(at + 1) % left.size()];
        const glm::dvec2 &a = flat[before], &b = flat[middle], &c = flat[after];
        if (!(cross(b - a, c - b) > 0.0))
            return false;
        return std::ranges::none_of(left, [&](std::size_t other) {
            const glm::dvec2& p = flat[other];
            return other != before && other != middle && other != after && cross(b - a, p - a) >= 0.0 &&
                   cross(c - b, p - b) >= 0.0 && cross(a - c, p - c) >= 0.0;
        });
    };
    while (left.size() > 3) {
        std::size_t ear = 1;  // of what has no ears any corner will do
        for (std::size_t at = 1; at <= left.size(); ++at)
            if (is_ear(at % left.size())) {
                ear = at % left.size();
                break;
            }
        add(left[(ear + left.size() - 1) % left.size()], left[ear], left[(ear + 1) % left.size()]);
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    add(left[0], left[1], left[2]);
}

}  // namespace demo
