// SPDX-License-Identifier: MIT
#include "blockers.hpp"

#include "surface.hpp"

#include <algorithm>
#include <array>

namespace demo {
namespace {

/// Parts of a triangle's side; fewer where there are many triangles.
int parts_of_side(std::size_t triangles) {
    if (triangles < 20000)
        return 8;
    return triangles < 200000 ? 4 : 2;
}

class Cutter {
public:
    Cutter(const Scene& scene, int parts) : scene_(scene), parts_(parts) {}

    void add(std::uint32_t triangle) {
        const Material& material = scene_.materials[scene_.triangles[triangle].material];
        const bool is_even =
            material.base_map.texture < 0 && material.opacity_map.texture < 0 && scene_.colours.empty();
        const int parts = is_even ? 1 : parts_;
        for (int row = 0; row < parts; ++row)
            for (int column = 0; column < 2 * (parts - row) - 1; ++column)
                add_part(triangle, row, column, parts);
    }

    Blockers take() { return std::move(result_); }

private:
    /// Row by row from the first side on, with parts upright and upside down in turn.
    void add_part(std::uint32_t triangle, int row, int column, int parts) {
        const int left = column / 2;
        const auto weights = [&](int u, int v) {
            return std::array{static_cast<float>(u) / static_cast<float>(parts),
                              static_cast<float>(v) / static_cast<float>(parts)};
        };
        const std::array<std::array<float, 2>, 3> corners =
            column % 2 == 0
                ? std::array{weights(left, row), weights(left + 1, row), weights(left, row + 1)}
                : std::array{weights(left + 1, row), weights(left + 1, row + 1), weights(left, row + 1)};
        const float u = (corners[0][0] + corners[1][0] + corners[2][0]) / 3.0f;
        const float v = (corners[0][1] + corners[1][1] + corners[2][1]) / 3.0f;
        if (share_let_through(scene_, triangle, u, v) >= 0.5f)
            return;
        const auto& vertex = scene_.triangles[triangle].vertex;
        for (const auto& [to_second, to_third] : corners) {
            result_.indices.push_back(static_cast<std::uint32_t>(result_.positions.size()));
            result_.positions.push_back((1.0f - to_second - to_third) * scene_.positions[vertex[0]] +
                                        to_second * scene_.positions[vertex[1]] +
                                        to_third * scene_.positions[vertex[2]]);
        }
    }

    const Scene& scene_;
    int parts_;
    Blockers result_;
};

bool is_translucent(const Scene& scene, const Triangle& triangle) {
    return may_let_light_through(scene.materials[triangle.material]);
}

}  // namespace

Blockers cut_blockers(const Scene& scene, std::span<const std::uint32_t> triangles) {
    Cutter cutter(scene, parts_of_side(triangles.size()));
    for (const std::uint32_t triangle : triangles)
        cutter.add(triangle);
    return cutter.take();
}

Blockers all_blockers(const Scene& scene) {
    std::vector<std::uint32_t> translucent;
    Blockers result;
    result.positions = scene.positions;
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
        const Triangle& triangle = scene.triangles[t];
        if (is_translucent(scene, triangle))
            translucent.push_back(t);
        else
            result.indices.insert(result.indices.end(), triangle.vertex, triangle.vertex + 3);
    }
    const Blockers cut = cut_blockers(scene, translucent);
    const auto first = static_cast<std::uint32_t>(result.positions.size());
    result.positions.insert(result.positions.end(), cut.positions.begin(), cut.positions.end());
    for (const std::uint32_t index : cut.indices)
        result.indices.push_back(first + index);
    return result;
}

bool has_translucent(const Scene& scene) {
    return std::ranges::any_of(scene.triangles,
                               [&](const Triangle& triangle) { return is_translucent(scene, triangle); });
}

}  // namespace demo
