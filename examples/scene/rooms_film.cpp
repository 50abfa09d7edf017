// SPDX-License-Identifier: MIT
// The rooms with a door in each doorway; some open one after another, and a lamp swings on its cable.
#include "animation.hpp"
#include "mesh_builder.hpp"
#include "moving_parts.hpp"
#include "random.hpp"
#include "rooms_plan.hpp"
#include "terrain.hpp"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace demo {
namespace {

constexpr double rooms_length = 8.0;

/// A doorway, and when its door begins to open; by how many turns, about the end at lower coordinates.
struct Opening {
    int column;
    int row;
    bool along_x;
    float turns;
    float start;
};

constexpr std::array openings{
    Opening{2, 1, true, 0.25f, 0.3f},  Opening{3, 1, false, 0.24f, 1.2f}, Opening{3, 2, true, 0.26f, 2.2f},
    Opening{2, 2, false, 0.25f, 3.0f}, Opening{3, 1, true, -0.25f, 4.0f}, Opening{2, 2, true, 0.22f, 4.8f},
};
constexpr int lamp_column = 2;
constexpr int lamp_row = 1;

/// The place where the leaf of a door hangs, on the floor, in the frame of its wall.
constexpr float hinge = -door_half_width + 0.045f;

/// A leaf with a handle on both sides.
void build_door(MeshBuilder& mesh, const Scene& scene, float middle) {
    constexpr float thickness = 0.018f;
    const float low = middle + hinge;
    const float high = middle - hinge - 0.005f;
    mesh.use(material_named(scene, "oak"));
    mesh.box({low, -thickness, 0.01f}, {high, thickness, door_height - 0.03f});
    mesh.use(material_named(scene, "metal"));
    for (const float side : {-1.0f, 1.0f}) {
        mesh.tube({high - 0.09f, side * thickness, 1.02f}, {high - 0.09f, side * 0.06f, 1.02f}, 0.012f,
                  0.012f, 6);
        mesh.tube({high - 0.09f, side * 0.06f, 1.02f}, {high - 0.20f, side * 0.06f, 1.02f}, 0.012f, 0.012f,
                  6);
    }
}

const Opening* opening_of(int column, int row, bool along_x) {
    for (const Opening& opening : openings)
        if (opening.column == column && opening.row == row && opening.along_x == along_x)
            return &opening;
    return nullptr;
}

void add_door(Scene& scene, int column, int row, bool along_x, std::vector<MovingPart>& parts) {
    MeshBuilder mesh(scene);
    mesh.place(wall_middle(column, row, along_x), along_x ? 0.0f : 0.25f);
    const float middle = door_offset(column, row, along_x);
    const std::size_t first = scene.positions.size();
    build_door(mesh, scene, middle);
    const Opening* opening = opening_of(column, row, along_x);
    if (opening == nullptr)
        return;
    MovingPart leaf;
    leaf.vertices = vertices_from(scene, first);
    leaf.motion = [opening, at = glm::dvec3(mesh.to_world({middle + hinge, 0, 0}))](double seconds) {
        constexpr float takes = 2.4f;
        const float share = smooth_step(opening->start, opening->start + takes, static_cast<float>(seconds));
        return turned_about(at, {0, 0, 1}, static_cast<double>(share * opening->turns));
    };
    parts.push_back(std::move(leaf));
}

/// The lamp of a room, with its light; nothing else hangs so high in the middle.
MovingPart swinging_lamp(const Scene& scene) {
    const glm::vec3 middle = room_middle(lamp_column, lamp_row);
    MovingPart lamp;
    lamp.vertices = vertices_within(scene, middle + glm::vec3{-0.25f, -0.25f, 2.3f},
                                    middle + glm::vec3{0.25f, 0.25f, 3.1f});
    lamp.lights.push_back(static_cast<std::size_t>(lamp_row * rooms_per_side + lamp_column));
    lamp.motion = [hook = glm::dvec3(middle) + glm::dvec3{0, 0, wall_height}](double seconds) {
        constexpr double period = 2.0;
        constexpr double most_turns = 0.07;
        const glm::vec2 across = circle_point(0.1f);
        return turned_about(hook, {across, 0.0f},
                            most_turns *
                                static_cast<double>(circle_point(static_cast<float>(seconds / period)).y));
    };
    return lamp;
}

}  // namespace

AnimatedScene animate_rooms() {
    Scene scene = make_rooms();
    std::vector<MovingPart> parts;
    parts.push_back(swinging_lamp(scene));
    for (int line = 1; line < rooms_per_side; ++line)
        for (int i = 0; i < rooms_per_side; ++i) {
            add_door(scene, i, line, true, parts);
            add_door(scene, line, i, false, parts);
        }
    return animate(std::move(scene), std::move(parts), {}, rooms_length);
}

}  // namespace demo
