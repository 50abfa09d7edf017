// SPDX-License-Identifier: MIT
// The blue ball rolls over the floor towards the camera, and back.
#include "animation.hpp"
#include "moving_parts.hpp"
#include "random.hpp"

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>

#include <utility>

namespace demo {
namespace {

constexpr double spheres_length = 6.0;
constexpr float radius = 7.0f;
constexpr glm::vec3 start{-17.0f, -13.0f, radius};

}  // namespace

AnimatedScene animate_spheres() {
    Scene scene = make_spheres();
    MovingPart ball;
    const glm::vec3 reach{1.001f * radius};
    ball.vertices = vertices_within(scene, start - reach, start + reach);
    ball.motion = [](double seconds) {
        constexpr double way = 22.0;
        const glm::dvec3 ahead = glm::normalize(glm::dvec3{-0.2, -0.98, 0.0});
        const auto phase = static_cast<double>(circle_point(static_cast<float>(seconds / spheres_length)).x);
        const double rolled = 0.5 * way * (1.0 - phase);
        Motion motion = turned_about(start, glm::cross({0.0, 0.0, 1.0}, ahead),
                                     rolled / (2.0 * glm::pi<double>() * static_cast<double>(radius)));
        motion.to += rolled * ahead;
        return motion;
    };
    return animate(std::move(scene), {std::move(ball)}, {}, spheres_length);
}

}  // namespace demo
