// SPDX-License-Identifier: MIT
//
// Penumbrae of a real lamp: sharp where things touch, soft with distance. A light mesh would blur both
// shadows alike.
#include "scene.hpp"

#include <algorithm>
#include <optional>

// Optional, and found by itself: with the first surface on a segment the cache finds places on surfaces by
// one ray instead of about 40.
struct HitTracer : scene::Tracer {
    std::optional<lightmesh::Hit> closest_hit(const lightmesh::Segment& segment) const {
        const glm::vec3 way = segment.target - segment.origin;
        const float t = scene::first_hit(segment.origin, way);
        if (!(t < 1.0f))
            return std::nullopt;
        const glm::vec3 point = segment.origin + t * way;
        glm::vec3 normal = scene::floor_normal;
        for (const scene::Ball& ball : scene::balls)
            if (glm::distance(point, ball.middle) < 1.001f * ball.radius)
                normal = glm::normalize(point - ball.middle);
        return lightmesh::Hit{t * glm::length(way), normal};
    }
};

int main() {
    const std::vector<lightmesh::Light> lamp{
        lightmesh::PointLight{.position = {0.0f, -4.0f, 9.0f}, .radius = 1.0f}};
    const lightmesh::VisibilityCache cache{HitTracer{}, lamp, lightmesh::CacheSettings{.spacing = 0.2f}};

    // Across each ball's shadow: how many points of a row see a part of the lamp?
    int partly[2] = {0, 0};
    for (const std::size_t i : {0u, 1u}) {
        const scene::Ball& ball = scene::balls[i];
        const glm::vec3 centre(0.0f, -4.0f, 9.0f);
        const glm::vec3 way = ball.middle - centre;
        const glm::vec3 shadow = centre - centre.z / way.z * way;  // of the ball's middle, on the floor
        std::vector<float> shares(65);
        for (std::size_t k = 0; k < shares.size(); ++k) {
            const glm::vec3 point = shadow + glm::vec3(0.05f * (static_cast<float>(k) - 32.0f), 0.0f, 0.0f);
            shares[k] = cache.visibility(point, scene::floor_normal, 0);
        }
        partly[i] = static_cast<int>(
            std::ranges::count_if(shares, [](float share) { return share > 0.05f && share < 0.95f; }));
        scene::print_row(i == 0 ? "lying" : "hovering", shares);
    }
    std::cout << "points that see a part of the lamp: " << partly[0] << " and " << partly[1] << '\n';
    std::cout << cache.statistics().records << " records, " << cache.statistics().lamp_rays << " rays\n";
    std::cout << "softer with distance: " << (partly[1] > partly[0] ? "yes" : "no") << '\n';
    return partly[1] > partly[0] ? 0 : 1;
}
