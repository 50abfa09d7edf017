// SPDX-License-Identifier: MIT
// A flight over the lawn before the pond, a walker who carries a lantern along a path, and a swing.
#include "animation.hpp"
#include "mesh_builder.hpp"
#include "moving_parts.hpp"
#include "park_plan.hpp"
#include "random.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace demo {
namespace {

constexpr double park_length = 12.0;

// The swing hangs on a beam on two pairs of legs.
constexpr glm::vec2 swing_place{3.0f, -35.8f};
constexpr float swing_turns = 0.04f;
constexpr float beam_height = 6.2f;
constexpr float half_beam = 2.9f;

void build_swing_frame(MeshBuilder& mesh, const Scene& scene) {
    const Terrain terrain;
    mesh.use(material_named(scene, "bench wood"));
    const float top = beam_height;
    mesh.tube({-half_beam - 0.3f, 0, top}, {half_beam + 0.3f, 0, top}, 0.15f, 0.15f, 8);
    mesh.disc({-half_beam - 0.3f, 0, top}, {-1, 0, 0}, 0.15f, 8);
    mesh.disc({half_beam + 0.3f, 0, top}, {1, 0, 0}, 0.15f, 8);
    for (const float x : {-half_beam, half_beam})
        for (const float y : {-2.0f, 2.0f}) {
            const glm::vec3 foot{1.1f * x, y, 0.0f};
            const glm::vec3 in_world = mesh.to_world(foot);
            const float ground = terrain.height(glm::vec2(in_world)) - in_world.z;
            mesh.tube({foot.x, foot.y, ground - 0.3f}, {x, 0.06f * y, top + 0.1f}, 0.14f, 0.11f, 6);
        }
}

void build_swing_seat(MeshBuilder& mesh, const Scene& scene) {
    mesh.use(material_named(scene, "iron"));
    for (const float x : {-0.85f, 0.85f})
        mesh.tube({x, 0, 1.42f}, {x, 0, beam_height - 0.14f}, 0.045f, 0.045f, 4);
    mesh.use(material_named(scene, "bench wood"));
    mesh.box({-1.05f, -0.45f, 1.3f}, {1.05f, 0.45f, 1.44f});
}

MovingPart add_swing(Scene& scene) {
    MeshBuilder mesh(scene);
    const Terrain terrain;
    mesh.place(terrain.on_ground(swing_place), swing_turns);
    build_swing_frame(mesh, scene);
    const std::size_t first = scene.positions.size();
    build_swing_seat(mesh, scene);
    const glm::dvec3 hook = mesh.to_world({0, 0, beam_height});
    const glm::dvec3 axis{circle_point(swing_turns), 0.0f};
    MovingPart seat;
    seat.vertices = vertices_from(scene, first);
    seat.motion = [hook, axis](double seconds) {
        constexpr double period = 2.8;  // of a pendulum of 2 m
        constexpr double most_turns = 0.11;
        return turned_about(hook, axis,
                            most_turns *
                                static_cast<double>(circle_point(static_cast<float>(seconds / period)).x));
    };
    return seat;
}

/// Places along a path by the way from its start.
class Walk {
public:
    explicit Walk(const Path& path) : points_(path.points()), lengths_{0.0f} {
        for (std::size_t i = 1; i < points_.size(); ++i)
            lengths_.push_back(lengths_.back() + glm::length(points_[i] - points_[i - 1]));
    }

    glm::vec2 at(float way) const {
        const float kept = std::clamp(way, 0.0f, lengths_.back());
        const auto next = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, kept);
        const auto i = static_cast<std::size_t>(next - lengths_.begin());
        return glm::mix(points_[i - 1], points_[i],
                        (kept - lengths_[i - 1]) / (lengths_[i] - lengths_[i - 1]));
    }

private:
    std::vector<glm::vec2> points_;
    std::vector<float> lengths_;
};

/// The walker's frame: feet at 0, ahead is +y.
void build_walker(MeshBuilder& mesh, Scene& scene, const glm::vec3& lantern) {
    mesh.use(mesh.add_material({.name = "coat", .diffuse = {0.30f, 0.10f, 0.09f}}));
    mesh.tube({0, 0, 0}, {0, 0, 2.9f}, 0.75f, 0.38f, 16);
    mesh.tube({0, 0, 2.9f}, {0, 0, 3.35f}, 0.38f, 0.16f, 16);
    const glm::vec3 hand{lantern.x, lantern.y, 2.45f};
    mesh.tube({0.3f, 0, 2.85f}, hand, 0.16f, 0.10f, 8);
    mesh.ball(hand, 0.12f, 2);
    mesh.use(mesh.add_material({.name = "skin", .diffuse = {0.62f, 0.44f, 0.34f}}));
    mesh.ball({0, 0, 3.65f}, 0.38f, 3);
    mesh.use(material_named(scene, "dark bark"));
    mesh.tube({0, 0, 3.72f}, {0, 0, 3.80f}, 0.60f, 0.60f, 16);
    mesh.tube({0, 0, 3.80f}, {0, 0, 4.25f}, 0.42f, 0.30f, 16);
    mesh.disc({0, 0, 3.80f}, {0, 0, 1}, 0.60f, 16);
    mesh.disc({0, 0, 3.72f}, {0, 0, -1}, 0.60f, 16);
    mesh.disc({0, 0, 4.25f}, {0, 0, 1}, 0.30f, 16);
    mesh.use(material_named(scene, "iron"));
    mesh.tube(lantern + glm::vec3{0, 0, 0.40f}, hand, 0.03f, 0.03f, 4);
    mesh.tube(lantern + glm::vec3{0, 0, 0.18f}, lantern + glm::vec3{0, 0, 0.42f}, 0.26f, 0.04f, 8);
    mesh.use(material_named(scene, "bulb"));
    mesh.ball(lantern + glm::vec3{0, 0, 0.08f}, 0.16f, 2);
}

MovingPart add_walker(Scene& scene) {
    const glm::vec3 lantern{0.95f, 0.75f, 1.75f};
    MeshBuilder mesh(scene);
    const std::size_t first = scene.positions.size();
    build_walker(mesh, scene, lantern);
    MovingPart walker;
    walker.vertices = vertices_from(scene, first);
    walker.lights.push_back(scene.lights.size());
    scene.lights.push_back(
        {lightmesh::PointLight{lantern - glm::vec3{0, 0, 0.22f}}, 16.0f * glm::vec3{1.0f, 0.70f, 0.36f}});
    walker.motion = [walk = Walk(park_paths(Pond{})[0])](double seconds) {
        constexpr float start = 84.0f;  // of the path around the pond, on the left of it
        constexpr float speed = 2.3f;
        constexpr float stride = 0.9f;
        const float way = start + speed * static_cast<float>(seconds);
        const glm::vec2 place = walk.at(way);
        const glm::dvec2 ahead = glm::normalize(walk.at(way + stride) - walk.at(way - stride));
        Motion motion;
        motion.to = Terrain{}.on_ground(place, path_lift + 0.04f);
        motion.turn = glm::dmat3(ahead.y, -ahead.x, 0, ahead.x, ahead.y, 0, 0, 0, 1);
        return motion;
    };
    return walker;
}

/// Slowly forwards and down, from the still picture's view on.
Camera camera_at(double seconds, Camera camera) {
    const float share = smooth_step(0.0f, 1.0f, static_cast<float>(seconds / park_length));
    camera.eye = glm::mix(camera.eye, glm::vec3{-4.0f, -53.0f, 13.5f}, share);
    camera.target = glm::mix(camera.target, glm::vec3{5.0f, 0.0f, 2.0f}, share);
    return camera;
}

}  // namespace

AnimatedScene animate_park() {
    Scene scene = make_park();
    std::vector<MovingPart> parts;
    parts.push_back(add_swing(scene));
    parts.push_back(add_walker(scene));
    const auto camera = [still = scene.camera](double seconds) {
        return camera_at(seconds, still);
    };
    return animate(std::move(scene), std::move(parts), camera, park_length);
}

}  // namespace demo
