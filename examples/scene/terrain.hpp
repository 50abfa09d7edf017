// SPDX-License-Identifier: MIT
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace demo {

inline float smooth_step(float low, float high, float value) {
    const float t = std::clamp((value - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

/// Smooth value noise in [-1, 1] over the plane, with hills about one unit wide.
inline float value_noise(glm::vec2 p) {
    const auto lattice = [](std::int32_t x, std::int32_t y) {
        std::uint32_t h =
            static_cast<std::uint32_t>(x) * 0x9E3779B1U ^ static_cast<std::uint32_t>(y) * 0x85EBCA77U;
        h = (h ^ (h >> 15U)) * 0x2C1B3C6DU;
        h = (h ^ (h >> 12U)) * 0x297A2D39U;
        return static_cast<float>((h ^ (h >> 15U)) >> 8U) * 0x1p-23f - 1.0f;
    };
    const float fx = std::floor(p.x);
    const float fy = std::floor(p.y);
    const auto x = static_cast<std::int32_t>(fx);
    const auto y = static_cast<std::int32_t>(fy);
    const float u = smooth_step(0.0f, 1.0f, p.x - fx);
    const float v = smooth_step(0.0f, 1.0f, p.y - fy);
    const float low = lattice(x, y) + u * (lattice(x + 1, y) - lattice(x, y));
    const float high = lattice(x, y + 1) + u * (lattice(x + 1, y + 1) - lattice(x, y + 1));
    return low + v * (high - low);
}

/// The pond of the park: an ellipse with water at `water_level`.
struct Pond {
    glm::vec2 centre{9.0f, -4.0f};
    glm::vec2 radii{19.0f, 12.5f};
    float water_level = -1.0f;

    /// 0 in the middle, 1 on the rim.
    float distance(glm::vec2 p) const { return glm::length((p - centre) / radii); }
};

/// The ground: rolling meadows, a hollow for the pond, hills all around.
struct Terrain {
    Pond pond;

    float height(glm::vec2 p) const {
        const float from_pond = pond.distance(p);
        const float meadows =
            1.5f * value_noise(p / 21.0f) + 0.5f * value_noise(p / 9.0f + glm::vec2{40.0f, 17.0f});
        const float hollow = -3.2f * (1.0f - smooth_step(0.55f, 1.22f, from_pond));
        const float hills =
            24.0f * smooth_step(46.0f, 96.0f, glm::length(p * glm::vec2{0.95f, 1.0f} + glm::vec2{0, 4}));
        return meadows * smooth_step(1.0f, 1.9f, from_pond) + hollow + hills;
    }

    glm::vec3 on_ground(glm::vec2 p, float above = 0.0f) const { return {p.x, p.y, height(p) + above}; }

    glm::vec3 normal(glm::vec2 p) const {
        constexpr float step = 0.5f;
        const float dx = height(p + glm::vec2{step, 0}) - height(p - glm::vec2{step, 0});
        const float dy = height(p + glm::vec2{0, step}) - height(p - glm::vec2{0, step});
        return glm::normalize(glm::vec3{-dx, -dy, 2.0f * step});
    }
};

/// A way through the plan: a smooth curve through points (Catmull-Rom), cut into steps of about equal length.
class Path {
public:
    Path(const std::vector<glm::vec2>& corners, bool closed, float step) {
        const std::vector<glm::vec2> fine = curve(corners, closed);
        float travelled = 0.0f;
        float next = 0.0f;
        for (std::size_t i = 0; i + 1 < fine.size(); ++i) {
            const float length = glm::length(fine[i + 1] - fine[i]);
            while (next < travelled + length) {
                points_.push_back(fine[i] + (next - travelled) / length * (fine[i + 1] - fine[i]));
                next += step;
            }
            travelled += length;
        }
        if (travelled - (next - step) < 0.5f * step) {
            points_.pop_back();  // a last step much shorter than the others has no safe direction
        }
        points_.push_back(fine.back());
    }

    const std::vector<glm::vec2>& points() const { return points_; }

    /// Unit vector to the left of the way at point i.
    glm::vec2 left(std::size_t i) const {
        const std::size_t last = points_.size() - 1;
        const bool closed = glm::length(points_.front() - points_.back()) < 1e-3f;
        const glm::vec2 before = i > 0 ? points_[i - 1] : closed ? points_[last - 1] : points_[0];
        const glm::vec2 after = i < last ? points_[i + 1] : closed ? points_[1] : points_[last];
        const glm::vec2 ahead = glm::normalize(after - before);
        return {-ahead.y, ahead.x};
    }

    float distance(glm::vec2 p) const {
        float closest = 1e9f;
        for (const glm::vec2& q : points_) {
            closest = (std::min)(closest, glm::length(p - q));
        }
        return closest;
    }

private:
    static std::vector<glm::vec2> curve(const std::vector<glm::vec2>& corners, bool closed) {
        constexpr int parts = 24;
        const auto count = static_cast<int>(corners.size());
        const auto corner = [&](int i) {
            const int wrapped = closed ? (i + count) % count : std::clamp(i, 0, count - 1);
            return corners[static_cast<std::size_t>(wrapped)];
        };
        std::vector<glm::vec2> result;
        const int spans = closed ? count : count - 1;
        for (int i = 0; i < spans; ++i) {
            for (int k = 0; k < parts; ++k) {
                const float t = static_cast<float>(k) / parts;
                const glm::vec2 a = corner(i - 1);
                const glm::vec2 b = corner(i);
                const glm::vec2 c = corner(i + 1);
                const glm::vec2 d = corner(i + 2);
                result.push_back(
                    b +
                    0.5f * t *
                        (c - a + t * (2.0f * a - 5.0f * b + 4.0f * c - d + t * (3.0f * (b - c) + d - a))));
            }
        }
        result.push_back(corner(closed ? 0 : count - 1));
        return result;
    }

    std::vector<glm::vec2> points_;
};

}  // namespace demo
