// SPDX-License-Identifier: MIT
//
// A lamp and a ball move from frame to frame. The cache is told what has changed, and finds again what has to
// do with it, and no more: the same values as of a new cache, for a part of its rays.
#include "scene.hpp"

namespace {

/// Beside the two balls that rest, one that rolls over the floor.
struct World {
    scene::Ball ball{{0.0f, -2.5f, 0.7f}, 0.7f};

    lightmesh::Bounds bounds() const { return {ball.middle - ball.radius, ball.middle + ball.radius}; }
};

struct Tracer {
    const World* world;

    bool occluded(const lightmesh::Segment& segment) const {
        const glm::vec3 way = segment.target - segment.origin, from = segment.origin - world->ball.middle;
        const float a = glm::dot(way, way), b = glm::dot(way, from);
        const float square = b * b - a * (glm::dot(from, from) - world->ball.radius * world->ball.radius);
        const auto is_between = [&](float t) {
            return t > 0.0f && t < a;
        };
        return scene::first_hit(segment.origin, way) < 1.0f ||
               (square > 0.0f && (is_between(-b - std::sqrt(square)) || is_between(-b + std::sqrt(square))));
    }
};

}  // namespace

int main() {
    World world;
    std::vector<lightmesh::Light> lamps;
    for (const float angle : {0.0f, 0.8f, 1.6f, 2.4f, 3.2f, 4.0f, 4.8f, 5.6f})
        lamps.push_back(lightmesh::PointLight{
            .position = {6.0f * std::cos(angle), 6.0f * std::sin(angle), 5.0f}, .radius = 0.3f});
    const lightmesh::CacheSettings settings{.spacing = 0.4f};
    lightmesh::VisibilityCache cache{Tracer{&world}, lamps, settings};
    std::vector<glm::vec3> points;
    for (int i = 0; i < 81 * 81; ++i)
        points.push_back(
            {0.15f * static_cast<float>(i % 81 - 40), 0.15f * static_cast<float>(i / 81 - 40), 0.0f});
    const std::vector<glm::vec3> normals(points.size(), scene::floor_normal);
    std::vector<float> shares(points.size() * lamps.size()), expected(shares.size()), row(81);
    for (const std::string frame : {"first", "lamp moves", "ball rolls", "both"}) {
        if (frame == "lamp moves" || frame == "both") {
            // Its colour and strength may change without a word: they stay with the renderer.
            auto& lamp = std::get<lightmesh::PointLight>(lamps[4]);
            lamp.position.z -= 1.0f;
            cache.set_light(4, lamp);
        }
        if (frame == "ball rolls" || frame == "both") {
            // Where it was, and where it is.
            const lightmesh::Bounds before = world.bounds();
            world.ball.middle.x += 0.5f;
            cache.scene_changed(std::array{before, world.bounds()});
        }
        const auto rays = cache.statistics().lamp_rays;
        cache.visibility(points, normals, shares);
        for (std::size_t i = 0; i < row.size(); ++i)
            row[i] = shares[(23 * 81 + i) * lamps.size() + 4];
        scene::print_row(frame, row);
        const lightmesh::VisibilityCache fresh{Tracer{&world}, lamps, settings};
        fresh.visibility(points, normals, expected);
        std::cout << "              " << cache.statistics().lamp_rays - rays << " rays, a new cache "
                  << fresh.statistics().lamp_rays << ", "
                  << (shares == expected ? "the same values" : "other values") << '\n';
        if (shares != expected)
            return 1;
    }
    return 0;
}
