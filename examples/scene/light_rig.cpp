// SPDX-License-Identifier: MIT
#include "light_rig.hpp"

#include "boxes.hpp"
#include "random.hpp"

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <variant>

namespace demo {
namespace {

/// Height above the ground that `spread_lights` aims at, as a share of the scene's diagonal.
constexpr float preferred_height = 0.035f;

/// The axis nearest to `up`, its sign, and the other two.
struct Axes {
    int u, v, up;
    float sign;

    explicit Axes(glm::vec3 direction) {
        const glm::vec3 size{std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)};
        up = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
        u = (up + 1) % 3;
        v = (up + 2) % 3;
        sign = direction[up] < 0.0f ? -1.0f : 1.0f;
    }

    glm::vec2 plan(glm::vec3 p) const { return {p[u], p[v]}; }
    float height(glm::vec3 p) const { return sign * p[up]; }
    glm::vec3 point(glm::vec2 place, float at_height) const {
        glm::vec3 p{0.0f};
        p[u] = place.x;
        p[v] = place.y;
        p[up] = sign * at_height;
        return p;
    }
};

/// The places where an upright line passes through a surface.
struct Crossing {
    float height;
    bool faces_up;
};

float cross(glm::vec2 a, glm::vec2 b) {
    return a.x * b.y - a.y * b.x;
}

/// The triangles of a scene sorted into the cells of its plan, to find what lies below and above a place.
class Plan {
public:
    Plan(const Scene& scene, const Axes& axes, const Bounds& bounds)
        : scene_(scene), axes_(axes), low_(axes.plan(bounds.low)), size_(axes.plan(bounds.high) - low_) {
        cells_.resize(cells_per_side * cells_per_side);
        for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
            const auto [a, b, c] = corners(t);
            const auto [x0, y0] = cell(glm::min(axes.plan(a), glm::min(axes.plan(b), axes.plan(c))));
            const auto [x1, y1] = cell(glm::max(axes.plan(a), glm::max(axes.plan(b), axes.plan(c))));
            for (std::size_t y = y0; y <= y1; ++y) {
                for (std::size_t x = x0; x <= x1; ++x) {
                    cells_[y * cells_per_side + x].push_back(t);
                }
            }
        }
    }

    /// `share` in [0, 1)^2 of the plan's rectangle.
    glm::vec2 place(glm::vec2 share) const { return low_ + share * size_; }

    /// From the lowest to the highest.
    std::vector<Crossing> crossings(glm::vec2 place) const {
        const auto [x, y] = cell(place);
        std::vector<Crossing> result;
        for (const std::uint32_t t : cells_[y * cells_per_side + x]) {
            const auto [a, b, c] = corners(t);
            const glm::vec2 ab = axes_.plan(b) - axes_.plan(a);
            const glm::vec2 ac = axes_.plan(c) - axes_.plan(a);
            const glm::vec2 ap = place - axes_.plan(a);
            const float area = cross(ab, ac);
            const float share_b = cross(ap, ac) / area;
            const float share_c = cross(ab, ap) / area;
            if (area != 0.0f && share_b >= 0.0f && share_c >= 0.0f && share_b + share_c <= 1.0f) {
                const float height = axes_.height(a + share_b * (b - a) + share_c * (c - a));
                result.push_back({height, area * axes_.sign > 0.0f});
            }
        }
        std::sort(result.begin(), result.end(),
                  [](const Crossing& p, const Crossing& q) { return p.height < q.height; });
        return result;
    }

private:
    static constexpr std::size_t cells_per_side = 128;

    std::array<glm::vec3, 3> corners(std::uint32_t t) const {
        const auto& vertex = scene_.triangles[t].vertex;
        return {scene_.positions[vertex[0]], scene_.positions[vertex[1]], scene_.positions[vertex[2]]};
    }

    std::array<std::size_t, 2> cell(glm::vec2 p) const {
        std::array<std::size_t, 2> result{};
        for (int k = 0; k < 2; ++k) {
            const float share = size_[k] > 0.0f ? (p[k] - low_[k]) / size_[k] : 0.0f;
            const float index =
                std::clamp(share * cells_per_side, 0.0f, static_cast<float>(cells_per_side - 1));
            result[static_cast<std::size_t>(k)] = static_cast<std::size_t>(index);
        }
        return result;
    }

    const Scene& scene_;
    Axes axes_;
    glm::vec2 low_;
    glm::vec2 size_;
    std::vector<std::vector<std::uint32_t>> cells_;
};

/// A height in the lowest open space over a place: between a surface that faces up and the next one that
/// faces down. In a solid it is the other way round, so lights stay out of furniture and walls.
float open_height(const std::vector<Crossing>& crossings, float wanted, float lowest) {
    if (crossings.empty()) {
        return lowest + wanted;
    }
    for (std::size_t i = 0; i + 1 < crossings.size(); ++i) {
        const float gap = crossings[i + 1].height - crossings[i].height;
        if (crossings[i].faces_up && !crossings[i + 1].faces_up && gap > 0.75f * wanted) {
            return crossings[i].height + (std::min)(wanted, 0.6f * gap);
        }
    }
    return crossings.back().height + wanted;
}

/// The R2 sequence: an even spread however many of its points are taken, and the first n stay where they are.
glm::vec2 low_discrepancy(std::size_t i) {
    const double n = static_cast<double>(i) + 0.5;
    const double x = 0.5 + n * 0.7548776662466927;
    const double y = 0.5 + n * 0.5698402909980532;
    return {static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y))};
}

}  // namespace

glm::vec3 total_strength(const Scene& scene) {
    const Axes axes{scene.camera.up};
    const Bounds bounds = bounds_of(scene);
    const glm::vec2 size = axes.plan(bounds.high) - axes.plan(bounds.low);
    glm::vec3 total{0.0f};
    for (const SceneLight& light : scene.lights) {
        // Half of the 4 pi I of a point light goes down: that is E times the area for a directional one. A
        // side of a patch has pi I.
        if (std::holds_alternative<lightmesh::DirectionalLight>(light.shape))
            total += light.intensity * (size.x * size.y / (2.0f * std::numbers::pi_v<float>));
        else if (std::holds_alternative<lightmesh::RectLight>(light.shape))
            total += 0.25f * light.intensity;
        else
            total += (light.facing == glm::vec3{0.0f} ? 1.0f : 0.5f) * light.intensity;
    }
    return total;
}

void add_light_rig(Scene& scene) {
    const Axes axes{scene.camera.up};
    const Bounds bounds = bounds_of(scene);
    const glm::vec3 centre = centre_of(bounds);
    const float size = diagonal_of(bounds) > 0.0f ? diagonal_of(bounds) : 1.0f;
    constexpr int count = 6;
    for (int i = 0; i < count; ++i) {
        const bool key = i % 2 == 0;
        const glm::vec2 around = circle_point((static_cast<float>(i) + 0.3f) / count);
        const glm::vec2 place = axes.plan(centre) + (key ? 0.45f : 0.7f) * size * around;
        const float height = axes.height(centre) + (key ? 0.85f : 0.55f) * size;
        const glm::vec3 position = axes.point(place, height);
        const glm::vec3 colour = key ? glm::vec3{1.0f, 0.92f, 0.80f} : glm::vec3{0.70f, 0.82f, 1.0f};
        const float distance = glm::length(position - centre);
        scene.lights.push_back(
            {lightmesh::PointLight{position}, (key ? 0.36f : 0.12f) * distance * distance * colour});
    }
}

Camera view_of_all(const Scene& scene, glm::vec3 up) {
    Camera camera;
    const Bounds bounds = bounds_of(scene);
    // Right-handed: with +y up the front is +z, with +z up it is -y.
    const glm::vec3 front = up.y != 0.0f ? glm::vec3{0, 0, 1} : glm::vec3{0, -1, 0};
    const glm::vec3 right{1, 0, 0};
    const float size = diagonal_of(bounds) > 0.0f ? diagonal_of(bounds) : 1.0f;
    camera.up = up;
    camera.target = centre_of(bounds);
    camera.vertical_field_of_view = 0.7f;
    camera.eye = camera.target + 1.3f * size * glm::normalize(front + 0.5f * right + 0.45f * up);
    return camera;
}

void spread_lights(Scene& scene, std::size_t count) {
    if (count == 0) {
        throw std::invalid_argument("spread_lights: 0 lights");
    }
    const Bounds bounds = bounds_of(scene);
    if (!(diagonal_of(bounds) > 0.0f)) {
        throw std::invalid_argument("spread_lights: the scene '" + scene.name + "' has no size");
    }
    if (scene.lights.empty()) {
        add_light_rig(scene);
    }
    const glm::vec3 share = total_strength(scene) / static_cast<float>(count);
    const Axes axes{scene.camera.up};
    const Plan plan{scene, axes, bounds};
    const float wanted = preferred_height * diagonal_of(bounds);
    const float lowest = (std::min)(axes.height(bounds.low), axes.height(bounds.high));
    scene.lights.clear();
    scene.lights.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec2 place = plan.place(low_discrepancy(i));
        const float height = open_height(plan.crossings(place), wanted, lowest);
        scene.lights.push_back({lightmesh::PointLight{axes.point(place, height)}, share});
    }
}

}  // namespace demo
