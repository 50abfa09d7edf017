// SPDX-License-Identifier: MIT
#include "moving_parts.hpp"

#include "random.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <variant>

namespace demo {
namespace {

glm::vec3 moved(const Motion& motion, const glm::vec3& p) {
    return glm::vec3(motion.to + motion.turn * (glm::dvec3(p) - motion.from));
}

class PartsAnimation final : public Animation {
public:
    PartsAnimation(const Scene& scene, std::vector<MovingPart> parts, std::function<Camera(double)> camera,
                   double length)
        : camera_(std::move(camera)), length_(length) {
        for (MovingPart& part : parts) {
            Rest& rest = parts_.emplace_back(Rest{std::move(part), {}, {}, {}});
            for (const std::uint32_t vertex : rest.part.vertices) {
                rest.positions.push_back(scene.positions[vertex]);
                rest.normals.push_back(scene.normals[vertex]);
            }
            for (const std::size_t light : rest.part.lights)
                rest.lights.push_back(std::get<lightmesh::PointLight>(scene.lights[light].shape).position);
        }
    }

    double length() const override { return length_; }

    void pose(Scene& scene, double seconds, const Moving& moving) const override {
        for (const Rest& rest : parts_) {
            const Motion motion = rest.part.motion(seconds);
            for (std::size_t i = 0; i < rest.positions.size() && moving.objects; ++i) {
                scene.positions[rest.part.vertices[i]] = moved(motion, rest.positions[i]);
                scene.normals[rest.part.vertices[i]] = glm::vec3(motion.turn * glm::dvec3(rest.normals[i]));
            }
            for (std::size_t i = 0; i < rest.lights.size() && moving.lights; ++i)
                std::get<lightmesh::PointLight>(scene.lights[rest.part.lights[i]].shape).position =
                    moved(motion, rest.lights[i]);
        }
        if (camera_ && moving.camera)
            scene.camera = camera_(seconds);
    }

private:
    /// A part with where it was before it moved.
    struct Rest {
        MovingPart part;
        std::vector<glm::vec3> positions;
        std::vector<glm::vec3> normals;
        std::vector<glm::vec3> lights;
    };

    std::vector<Rest> parts_;
    std::function<Camera(double)> camera_;
    double length_;
};

}  // namespace

Motion turned_about(const glm::dvec3& point, const glm::dvec3& axis, double turns) {
    const glm::dvec2 around = circle_point(static_cast<float>(turns));
    glm::dmat3 turn(1.0);
    for (int i = 0; i < 3; ++i) {  // Rodrigues' formula
        glm::dvec3 unit(0.0);
        unit[i] = 1.0;
        turn[i] = around.x * unit + around.y * glm::cross(axis, unit) + (1.0 - around.x) * axis[i] * axis;
    }
    return {point, point, turn};
}

std::vector<std::uint32_t> vertices_from(const Scene& scene, std::size_t first) {
    std::vector<std::uint32_t> vertices;
    for (std::size_t i = first; i < scene.positions.size(); ++i)
        vertices.push_back(static_cast<std::uint32_t>(i));
    return vertices;
}

std::vector<std::uint32_t> vertices_within(const Scene& scene, const glm::vec3& low, const glm::vec3& high) {
    std::vector<std::uint32_t> vertices;
    for (std::size_t i = 0; i < scene.positions.size(); ++i)
        if (glm::all(glm::greaterThanEqual(scene.positions[i], low)) &&
            glm::all(glm::lessThanEqual(scene.positions[i], high)))
            vertices.push_back(static_cast<std::uint32_t>(i));
    return vertices;
}

std::uint32_t material_named(const Scene& scene, const std::string& name) {
    const auto found = std::ranges::find(scene.materials, name, &Material::name);
    if (found == scene.materials.end())
        throw std::logic_error("there is no material '" + name + "' in " + scene.name);
    return static_cast<std::uint32_t>(found - scene.materials.begin());
}

AnimatedScene animate(Scene scene, std::vector<MovingPart> parts, std::function<Camera(double)> camera,
                      double length) {
    auto animation =
        std::make_shared<const PartsAnimation>(scene, std::move(parts), std::move(camera), length);
    animation->pose(scene, 0.0, {});
    return {std::move(scene), std::move(animation)};
}

}  // namespace demo
