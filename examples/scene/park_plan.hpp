// SPDX-License-Identifier: MIT
#pragma once

#include "random.hpp"
#include "terrain.hpp"

#include <glm/vec2.hpp>

#include <vector>

namespace demo {

/// The place where the park is seen from, and the one in the middle of the picture.
inline constexpr glm::vec2 park_view_from{-9.0f, -66.0f};
inline constexpr glm::vec2 park_view_to{4.0f, 6.0f};

/// Height of the first path over the ground; each other one lies a little higher.
inline constexpr float path_lift = 0.07f;

/// The park's paths: around the pond, from the camera past its left side, and others.
inline std::vector<Path> park_paths(const Pond& pond) {
    std::vector<glm::vec2> ring;
    for (int i = 0; i < 10; ++i) {
        const glm::vec2 around = circle_point(static_cast<float>(i) / 10.0f);
        ring.push_back(pond.centre + around * (pond.radii + glm::vec2{8.0f, 7.5f}));
    }
    constexpr float step = 1.3f;
    std::vector<Path> paths;
    paths.emplace_back(ring, true, step);
    paths.emplace_back(std::vector<glm::vec2>{{-20, -78}, {-14, -58}, {-17, -40}, {-13, -24}, {-17, -7}},
                       false, step);
    paths.emplace_back(std::vector<glm::vec2>{{-16, 2}, {-30, 10}, {-44, 8}, {-66, 18}}, false, step);
    paths.emplace_back(std::vector<glm::vec2>{{16, 17}, {10, 32}, {16, 46}, {10, 70}}, false, step);
    paths.emplace_back(std::vector<glm::vec2>{{35, -6}, {48, -14}, {58, -8}, {74, -14}}, false, step);
    paths.emplace_back(
        std::vector<glm::vec2>{{-30, 10}, {-26, 30}, {-8, 40}, {13, 40}, {38, 34}, {50, 12}, {48, -14}},
        false, step);
    paths.emplace_back(std::vector<glm::vec2>{{-17, -40}, {4, -42}, {26, -36}, {48, -38}, {70, -44}}, false,
                       step);
    return paths;
}

}  // namespace demo
