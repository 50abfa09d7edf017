// SPDX-License-Identifier: MIT
// A storey of 36 rooms without its ceiling, like a doll's house: thin walls, doorways, furniture, a lamp in
// each room. One unit is a metre. The lamps hang lower than the walls are high, so no light gets over a wall
// into the next room.
#include "mesh_builder.hpp"
#include "random.hpp"
#include "rooms_plan.hpp"
#include "scene.hpp"

#include <array>
#include <cmath>

namespace demo {
namespace {

struct RoomMaterials {
    std::array<std::uint32_t, 6> paint;
    std::array<std::uint32_t, 4> floor;
    std::array<std::uint32_t, 8> cloth;
    std::uint32_t wall_top, outside, oak, walnut, white, metal, shade, leaf, clay, ground;
};

RoomMaterials add_room_materials(MeshBuilder& mesh) {
    const auto plain = [&](const char* name, glm::vec3 colour) {
        return mesh.add_material({.name = name, .diffuse = colour});
    };
    RoomMaterials m{};
    m.paint = {plain("paint cream", {0.80f, 0.74f, 0.62f}), plain("paint sage", {0.52f, 0.62f, 0.50f}),
               plain("paint blue", {0.46f, 0.58f, 0.68f}),  plain("paint terracotta", {0.74f, 0.46f, 0.34f}),
               plain("paint ochre", {0.80f, 0.62f, 0.32f}), plain("paint plum", {0.56f, 0.42f, 0.50f})};
    m.floor = {plain("floor oak", {0.58f, 0.42f, 0.27f}), plain("floor walnut", {0.40f, 0.27f, 0.18f}),
               plain("floor stone", {0.60f, 0.58f, 0.55f}), plain("floor ash", {0.68f, 0.57f, 0.43f})};
    m.cloth = {plain("cloth red", {0.62f, 0.14f, 0.12f}),   plain("cloth navy", {0.12f, 0.18f, 0.36f}),
               plain("cloth green", {0.16f, 0.36f, 0.22f}), plain("cloth mustard", {0.76f, 0.54f, 0.14f}),
               plain("cloth teal", {0.12f, 0.40f, 0.42f}),  plain("cloth ivory", {0.82f, 0.78f, 0.68f}),
               plain("cloth rust", {0.62f, 0.30f, 0.14f}),  plain("cloth grey", {0.36f, 0.37f, 0.40f})};
    m.wall_top = plain("wall top", {0.10f, 0.09f, 0.09f});
    m.outside = plain("outer wall", {0.55f, 0.50f, 0.46f});
    m.oak = plain("oak", {0.56f, 0.38f, 0.20f});
    m.walnut = plain("walnut", {0.32f, 0.19f, 0.11f});
    m.white = plain("white lacquer", {0.82f, 0.81f, 0.78f});
    m.metal = mesh.add_material(
        {.name = "metal", .diffuse = {0.10f, 0.10f, 0.11f}, .specular = glm::vec3{0.4f}, .shininess = 60.0f});
    m.shade = mesh.add_material(
        {.name = "lamp shade", .diffuse = {0.8f, 0.7f, 0.5f}, .emission = {0.9f, 0.62f, 0.30f}});
    m.leaf = plain("house plant", {0.20f, 0.44f, 0.16f});
    m.clay = plain("clay", {0.60f, 0.30f, 0.18f});
    m.ground = plain("ground", {0.10f, 0.11f, 0.12f});
    return m;
}

struct Rooms {
    Scene scene;
    MeshBuilder mesh{scene};
    Random random{36};
    RoomMaterials materials;
};

std::uint32_t paint_of(const Rooms& rooms, int column, int row) {
    if (column < 0 || row < 0 || column >= rooms_per_side || row >= rooms_per_side) {
        return rooms.materials.outside;
    }
    return rooms.materials.paint[static_cast<std::size_t>(column * 5 + row * 2 + row / 3) % 6];
}

/// A piece of wall from `from` to `to` along the local x axis; both sides in their own paint.
void build_wall_piece(Rooms& rooms, float from, float to, float bottom, std::uint32_t right,
                      std::uint32_t left) {
    MeshBuilder& mesh = rooms.mesh;
    const float d = half_wall;
    const float top = wall_height;
    mesh.use(right);
    mesh.quad({from, -d, bottom}, {to, -d, bottom}, {to, -d, top}, {from, -d, top});
    mesh.use(left);
    mesh.quad({to, d, bottom}, {from, d, bottom}, {from, d, top}, {to, d, top});
    mesh.use(rooms.materials.wall_top);
    mesh.quad({from, -d, top}, {to, -d, top}, {to, d, top}, {from, d, top});
    mesh.use(rooms.materials.white);
    mesh.quad({from, d, bottom}, {from, -d, bottom}, {from, -d, top}, {from, d, top});
    mesh.quad({to, -d, bottom}, {to, d, bottom}, {to, d, top}, {to, -d, top});
    if (bottom > 0.0f) {
        mesh.quad({from, d, bottom}, {to, d, bottom}, {to, -d, bottom}, {from, -d, bottom});
    }
}

/// A door frame of four posts and two lintels, a little proud of the wall.
void build_door_frame(Rooms& rooms, float middle) {
    MeshBuilder& mesh = rooms.mesh;
    constexpr float wood = 0.07f;
    constexpr float proud = half_wall + 0.02f;
    mesh.use(rooms.materials.white);
    mesh.box({middle - door_half_width - wood, -proud, 0},
             {middle - door_half_width + 0.02f, proud, door_height + wood});
    mesh.box({middle + door_half_width - 0.02f, -proud, 0},
             {middle + door_half_width + wood, proud, door_height + wood});
    mesh.box({middle - door_half_width, -proud, door_height - 0.02f},
             {middle + door_half_width, proud, door_height + wood});
}

void build_wall(Rooms& rooms, glm::vec3 middle, bool along_x, float door, bool with_door, std::uint32_t right,
                std::uint32_t left) {
    rooms.mesh.place(middle, along_x ? 0.0f : 0.25f);
    const float end = 0.5f * room_size;
    if (!with_door) {
        build_wall_piece(rooms, -end, end, 0.0f, right, left);
        return;
    }
    build_wall_piece(rooms, -end, door - door_half_width, 0.0f, right, left);
    build_wall_piece(rooms, door + door_half_width, end, 0.0f, right, left);
    build_wall_piece(rooms, door - door_half_width, door + door_half_width, door_height, right, left);
    build_door_frame(rooms, door);
}

void build_walls(Rooms& rooms) {
    for (int line = 0; line <= rooms_per_side; ++line) {
        const bool inner = line > 0 && line < rooms_per_side;
        for (int i = 0; i < rooms_per_side; ++i) {
            build_wall(rooms, wall_middle(i, line, true), true, door_offset(i, line, true), inner,
                       paint_of(rooms, i, line - 1), paint_of(rooms, i, line));
            build_wall(rooms, wall_middle(line, i, false), false, door_offset(line, i, false), inner,
                       paint_of(rooms, line, i), paint_of(rooms, line - 1, i));
        }
    }
}

// Furniture stands on the floor of its own frame, with its back at y = 0 and its front towards -y.

void build_shelf(Rooms& rooms, float width, float height) {
    MeshBuilder& mesh = rooms.mesh;
    constexpr float depth = 0.34f;
    const float half = 0.5f * width;
    mesh.use(rooms.random.index(2) == 0 ? rooms.materials.oak : rooms.materials.walnut);
    mesh.box({-half, -depth, 0}, {-half + 0.03f, 0, height});
    mesh.box({half - 0.03f, -depth, 0}, {half, 0, height});
    mesh.box({-half + 0.03f, -0.02f, 0}, {half - 0.03f, 0, height});
    constexpr float gap = 0.36f;
    const int boards = static_cast<int>(height / gap);
    for (int i = 0; i <= boards; ++i) {
        const float z = static_cast<float>(i) * gap;
        mesh.box({-half + 0.03f, -depth, z}, {half - 0.03f, -0.02f, z + 0.025f});
    }
    for (int i = 0; i < boards; ++i) {
        float x = -half + 0.05f;
        while (x < half - 0.19f) {
            const float thickness = rooms.random.uniform(0.06f, 0.14f);
            if (rooms.random.index(9) != 0) {
                const float z = static_cast<float>(i) * gap + 0.025f;
                mesh.use(rooms.materials.cloth[rooms.random.index(8)]);
                const float book_depth = rooms.random.uniform(0.22f, 0.30f);
                const float book_height = rooms.random.uniform(0.20f, 0.30f);
                mesh.box({x, -book_depth, z}, {x + thickness, -0.03f, z + book_height}, false);
            }
            x += thickness + 0.004f;
        }
    }
}

void build_chair(Rooms& rooms) {
    MeshBuilder& mesh = rooms.mesh;
    mesh.use(rooms.materials.oak);
    for (const float x : {-0.19f, 0.19f}) {
        mesh.tube({x, -0.40f, 0}, {x, -0.40f, 0.44f}, 0.018f, 0.024f, 8);
        mesh.tube({x, -0.02f, 0}, {x, 0.03f, 0.92f}, 0.024f, 0.018f, 8);
        mesh.tube({x, -0.40f, 0.2f}, {x, -0.01f, 0.2f}, 0.012f, 0.012f, 6);
    }
    mesh.box({-0.23f, -0.45f, 0.44f}, {0.23f, 0.0f, 0.47f});
    for (const float z : {0.62f, 0.74f, 0.86f}) {
        mesh.box({-0.20f, 0.005f + 0.03f * z, z - 0.03f}, {0.20f, 0.025f + 0.03f * z, z + 0.03f});
    }
}

/// A turned leg: a stack of short tubes.
void build_turned_leg(Rooms& rooms, float x, float y, float height) {
    constexpr std::array<float, 6> profile{0.030f, 0.042f, 0.028f, 0.045f, 0.032f, 0.045f};
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
        const float low = height * static_cast<float>(i) / 5.0f;
        const float high = height * static_cast<float>(i + 1) / 5.0f;
        rooms.mesh.tube({x, y, low}, {x, y, high}, profile[i], profile[i + 1], 10);
    }
}

void build_vase(Rooms& rooms, glm::vec3 foot) {
    constexpr std::array<float, 6> profile{0.06f, 0.11f, 0.13f, 0.09f, 0.045f, 0.06f};
    rooms.mesh.use(rooms.materials.cloth[rooms.random.index(8)]);
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
        rooms.mesh.tube(foot + glm::vec3{0, 0, 0.055f * static_cast<float>(i)},
                        foot + glm::vec3{0, 0, 0.055f * static_cast<float>(i + 1)}, profile[i],
                        profile[i + 1], 14);
    }
}

void build_table_setting(Rooms& rooms, float half_x, float half_y, float top) {
    for (const float x : {-0.55f * half_x, 0.55f * half_x}) {
        for (const float y : {-0.6f * half_y, 0.6f * half_y}) {
            rooms.mesh.use(rooms.materials.white);
            rooms.mesh.tube({x, y, top}, {x, y, top + 0.025f}, 0.09f, 0.13f, 16);
            rooms.mesh.disc({x, y, top + 0.012f}, {0, 0, 1}, 0.10f, 16);
            rooms.mesh.use(rooms.materials.cloth[4]);
            rooms.mesh.tube({x + 0.2f, y, top}, {x + 0.2f, y, top + 0.1f}, 0.03f, 0.04f, 10);
        }
    }
}

/// A table with four chairs around, in the middle of its frame.
void build_dining_group(Rooms& rooms, glm::vec3 middle, float turns) {
    MeshBuilder& mesh = rooms.mesh;
    constexpr float half_x = 0.85f;
    constexpr float half_y = 0.50f;
    constexpr float top = 0.76f;
    mesh.place(middle, turns);
    mesh.use(rooms.materials.walnut);
    mesh.box({-half_x, -half_y, top - 0.04f}, {half_x, half_y, top});
    for (const float x : {-half_x + 0.1f, half_x - 0.1f}) {
        for (const float y : {-half_y + 0.1f, half_y - 0.1f}) {
            build_turned_leg(rooms, x, y, top - 0.04f);
        }
    }
    build_table_setting(rooms, half_x, half_y, top);
    build_vase(rooms, {0, 0, top});
    for (const float x : {-0.42f, 0.42f}) {
        for (const float way : {0.0f, 0.5f}) {
            const glm::vec2 turn = circle_point(turns + way);
            const glm::vec2 local{x, 0.88f};
            const glm::vec3 place{local.x * turn.x - local.y * turn.y, local.x * turn.y + local.y * turn.x,
                                  0.0f};
            mesh.place(middle + place, turns + way + rooms.random.uniform(-0.03f, 0.03f));
            build_chair(rooms);
        }
    }
}

void build_sofa(Rooms& rooms) {
    MeshBuilder& mesh = rooms.mesh;
    mesh.use(rooms.materials.cloth[rooms.random.index(8)]);
    mesh.box({-1.0f, -0.85f, 0.12f}, {1.0f, 0.0f, 0.36f});
    mesh.box({-1.0f, -0.22f, 0.36f}, {1.0f, 0.0f, 0.86f});
    for (const float x : {-1.1f, 0.94f}) {
        mesh.box({x, -0.85f, 0.12f}, {x + 0.16f, 0.0f, 0.62f});
    }
    for (const float x : {-0.47f, 0.47f}) {
        mesh.box({x - 0.45f, -0.83f, 0.36f}, {x + 0.45f, -0.24f, 0.50f});
    }
    mesh.use(rooms.materials.cloth[rooms.random.index(8)]);
    mesh.ball({-0.7f, -0.36f, 0.64f}, 0.17f, 3);
    mesh.ball({0.72f, -0.36f, 0.64f}, 0.17f, 3);
    mesh.use(rooms.materials.walnut);
    for (const float x : {-0.95f, 0.95f}) {
        for (const float y : {-0.78f, -0.07f}) {
            mesh.tube({x, y, 0}, {x, y, 0.12f}, 0.02f, 0.035f, 8);
        }
    }
}

void build_cupboard(Rooms& rooms) {
    MeshBuilder& mesh = rooms.mesh;
    mesh.use(rooms.random.index(2) == 0 ? rooms.materials.white : rooms.materials.oak);
    mesh.box({-0.7f, -0.5f, 0.06f}, {0.7f, 0, 2.0f});
    mesh.box({-0.74f, -0.54f, 2.0f}, {0.74f, 0, 2.06f});
    for (const float x : {-0.66f, 0.04f}) {
        mesh.box({x, -0.525f, 0.12f}, {x + 0.62f, -0.5f, 0.62f});
        mesh.box({x, -0.525f, 0.70f}, {x + 0.62f, -0.5f, 1.92f});
    }
    mesh.use(rooms.materials.metal);
    for (const float x : {-0.09f, 0.09f}) {
        mesh.ball({x, -0.55f, 1.1f}, 0.025f, 2);
        mesh.ball({x, -0.55f, 0.5f}, 0.025f, 2);
    }
    build_vase(rooms, {-0.3f, -0.28f, 2.06f});
}

void build_bed(Rooms& rooms) {
    MeshBuilder& mesh = rooms.mesh;
    mesh.use(rooms.materials.oak);
    mesh.box({-0.85f, -0.06f, 0}, {0.85f, 0, 1.05f});
    mesh.box({-0.85f, -2.1f, 0.12f}, {0.85f, -0.06f, 0.32f});
    mesh.box({-0.85f, -2.16f, 0}, {0.85f, -2.1f, 0.55f});
    mesh.use(rooms.materials.white);
    mesh.box({-0.8f, -2.08f, 0.32f}, {0.8f, -0.08f, 0.50f});
    mesh.use(rooms.materials.cloth[rooms.random.index(8)]);
    mesh.box({-0.84f, -2.09f, 0.36f}, {0.84f, -0.75f, 0.55f});
    mesh.use(rooms.materials.white);
    for (const float x : {-0.4f, 0.4f}) {
        mesh.tube({x - 0.3f, -0.32f, 0.57f}, {x + 0.3f, -0.32f, 0.57f}, 0.13f, 0.13f, 14);
        mesh.disc({x - 0.3f, -0.32f, 0.57f}, {-1, 0, 0}, 0.13f, 14);
        mesh.disc({x + 0.3f, -0.32f, 0.57f}, {1, 0, 0}, 0.13f, 14);
    }
}

void build_desk(Rooms& rooms) {
    MeshBuilder& mesh = rooms.mesh;
    mesh.use(rooms.materials.walnut);
    mesh.box({-0.8f, -0.7f, 0.70f}, {0.8f, 0, 0.74f});
    mesh.box({0.35f, -0.65f, 0.05f}, {0.78f, -0.02f, 0.70f});
    mesh.box({-0.78f, -0.65f, 0}, {-0.74f, -0.02f, 0.70f});
    mesh.use(rooms.materials.oak);
    for (const float z : {0.10f, 0.31f, 0.52f}) {
        mesh.box({0.38f, -0.67f, z}, {0.75f, -0.65f, z + 0.17f});
    }
    mesh.use(rooms.materials.metal);
    mesh.box({-0.35f, -0.2f, 0.84f}, {0.25f, -0.17f, 1.2f});
    mesh.tube({-0.05f, -0.18f, 0.74f}, {-0.05f, -0.18f, 0.9f}, 0.03f, 0.03f, 8);
    mesh.tube({-0.05f, -0.18f, 0.74f}, {-0.05f, -0.18f, 0.76f}, 0.14f, 0.12f, 14);
    for (int i = 0; i < 5; ++i) {
        const float z = 0.74f + 0.03f * static_cast<float>(i);
        mesh.use(rooms.materials.cloth[rooms.random.index(8)]);
        mesh.box({0.42f + rooms.random.uniform(0.0f, 0.05f), -0.4f, z}, {0.68f, -0.2f, z + 0.03f});
    }
}

void build_plant(Rooms& rooms) {
    MeshBuilder& mesh = rooms.mesh;
    mesh.use(rooms.materials.clay);
    mesh.tube({0, 0, 0}, {0, 0, 0.36f}, 0.14f, 0.2f, 14);
    mesh.disc({0, 0, 0.33f}, {0, 0, 1}, 0.19f, 14);
    mesh.use(rooms.materials.leaf);
    for (int i = 0; i < 60; ++i) {
        const glm::vec2 around = circle_point(rooms.random.uniform());
        const float reach = rooms.random.uniform(0.12f, 0.5f);
        const float height = rooms.random.uniform(0.5f, 1.25f);
        const glm::vec3 side{0.05f * around.y, -0.05f * around.x, 0};
        const glm::vec3 root{0.03f * around, 0.33f};
        const glm::vec3 knee{0.55f * reach * around, 0.33f + 0.8f * (height - 0.33f)};
        const glm::vec3 tip{reach * around, height};
        mesh.quad(root - 0.3f * side, root + 0.3f * side, knee + side, knee - side);
        mesh.triangle(knee - side, knee + side, tip);
    }
}

void build_rug(Rooms& rooms, glm::vec3 middle, float turns) {
    rooms.mesh.place(middle, turns);
    rooms.mesh.use(rooms.materials.cloth[rooms.random.index(8)]);
    rooms.mesh.box({-1.35f, -0.95f, 0}, {1.35f, 0.95f, 0.012f}, false);
    rooms.mesh.use(rooms.materials.cloth[5]);
    rooms.mesh.box({-1.15f, -0.75f, 0.012f}, {1.15f, 0.75f, 0.02f}, false);
}

void build_low_table(Rooms& rooms, glm::vec3 middle) {
    rooms.mesh.place(middle);
    rooms.mesh.use(rooms.materials.walnut);
    rooms.mesh.tube({0, 0, 0.36f}, {0, 0, 0.40f}, 0.45f, 0.45f, 28);
    rooms.mesh.disc({0, 0, 0.40f}, {0, 0, 1}, 0.45f, 28);
    rooms.mesh.disc({0, 0, 0.36f}, {0, 0, -1}, 0.45f, 28);
    for (int i = 0; i < 3; ++i) {
        const glm::vec2 around = circle_point(static_cast<float>(i) / 3.0f);
        rooms.mesh.tube({0.36f * around, 0}, {0.26f * around, 0.36f}, 0.018f, 0.025f, 8);
    }
    build_vase(rooms, {0.1f, 0.05f, 0.40f});
}

/// A pendant lamp: a cable, an open shade, and the light below it, so that nothing of the lamp hides the
/// room.
void build_lamp(Rooms& rooms, glm::vec3 middle) {
    constexpr std::array<glm::vec3, 3> tints{glm::vec3{1.0f, 0.80f, 0.55f}, glm::vec3{1.0f, 0.88f, 0.70f},
                                             glm::vec3{1.0f, 0.74f, 0.46f}};
    rooms.mesh.place(middle);
    rooms.mesh.use(rooms.materials.metal);
    rooms.mesh.tube({0, 0, 2.55f}, {0, 0, wall_height}, 0.012f, 0.012f, 5);
    rooms.mesh.use(rooms.materials.shade);
    rooms.mesh.tube({0, 0, 2.36f}, {0, 0, 2.56f}, 0.20f, 0.06f, 20);
    rooms.mesh.disc({0, 0, 2.56f}, {0, 0, 1}, 0.06f, 20);
    rooms.mesh.disc({0, 0, 2.40f}, {0, 0, -1}, 0.168f, 20);
    const float strength = rooms.random.uniform(4.2f, 5.6f);
    const glm::vec3 tint = tints[rooms.random.index(3)];
    rooms.scene.lights.push_back({lightmesh::PointLight{middle + glm::vec3{0, 0, 2.30f}}, strength * tint});
}

/// A frame with its back to the middle of a wall (0: north, then clockwise), `along` metres from the wall's
/// middle.
void place_at_wall(Rooms& rooms, glm::vec3 middle, int wall, float along, float from_wall = 0.07f) {
    const float distance = 0.5f * room_size - from_wall;
    const float turns = -0.25f * static_cast<float>(wall);
    const glm::vec2 turn = circle_point(turns);
    const glm::vec2 local{along, distance};
    rooms.mesh.place(
        middle + glm::vec3{local.x * turn.x - local.y * turn.y, local.x * turn.y + local.y * turn.x, 0},
        turns);
}

void furnish(Rooms& rooms, int column, int row) {
    const glm::vec3 middle = room_middle(column, row);
    const float corner = 2.15f;
    build_lamp(rooms, middle);
    switch ((column + 2 * row) % 4) {
    case 0:  // dining room
        build_rug(rooms, middle, 0.0f);
        build_dining_group(rooms, middle, 0.02f);
        place_at_wall(rooms, middle, 0, corner - 0.1f);
        build_cupboard(rooms);
        place_at_wall(rooms, middle, 3, -corner);
        build_shelf(rooms, 1.3f, 1.9f);
        break;
    case 1:  // living room
        build_rug(rooms, middle + glm::vec3{0, 0.2f, 0}, 0.0f);
        build_low_table(rooms, middle + glm::vec3{0, 0.2f, 0.02f});
        rooms.mesh.place(middle + glm::vec3{0, 2.0f, 0});
        build_sofa(rooms);
        rooms.mesh.place(middle + glm::vec3{-1.7f, -0.1f, 0}, 0.25f, 0.9f);
        build_sofa(rooms);
        place_at_wall(rooms, middle, 1, corner);
        build_shelf(rooms, 1.4f, 2.2f);
        place_at_wall(rooms, middle, 2, corner);
        build_shelf(rooms, 1.4f, 1.5f);
        break;
    case 2:  // bedroom
        build_rug(rooms, middle + glm::vec3{0, -0.7f, 0}, 0.0f);
        rooms.mesh.place(middle + glm::vec3{-0.1f, 2.2f, 0});
        build_bed(rooms);
        place_at_wall(rooms, middle, 2, -corner + 0.1f);
        build_cupboard(rooms);
        place_at_wall(rooms, middle, 1, -corner);
        build_shelf(rooms, 1.2f, 1.5f);
        break;
    default:  // study
        place_at_wall(rooms, middle, 0, -corner + 0.1f);
        build_shelf(rooms, 1.5f, 2.2f);
        place_at_wall(rooms, middle, 3, corner);
        build_shelf(rooms, 1.5f, 2.2f);
        place_at_wall(rooms, middle, 1, -0.2f, 1.3f);
        build_desk(rooms);
        place_at_wall(rooms, middle, 1, -0.2f, 2.5f);
        rooms.mesh.place(rooms.mesh.to_world({0, 0, 0}), 0.27f);
        build_chair(rooms);
        build_rug(rooms, middle + glm::vec3{-0.4f, 0, 0}, 0.25f);
        break;
    }
    for (const glm::vec2 p : {glm::vec2{2.55f, -2.55f}, glm::vec2{-2.55f, 2.55f}}) {
        const float turns = rooms.random.uniform();
        const float size = rooms.random.uniform(0.8f, 1.15f);
        rooms.mesh.place(middle + glm::vec3{p, 0}, turns, size);
        build_plant(rooms);
    }
}

void build_floors(Rooms& rooms) {
    rooms.mesh.place({0, 0, 0});
    rooms.mesh.use(rooms.materials.ground);
    rooms.mesh.box({-22, -22, -0.3f}, {22, 22, -0.1f});
    for (int row = 0; row < rooms_per_side; ++row) {
        for (int column = 0; column < rooms_per_side; ++column) {
            rooms.mesh.place(room_middle(column, row));
            rooms.mesh.use(rooms.materials.floor[static_cast<std::size_t>(column * 3 + row) % 4]);
            const float end = 0.5f * room_size;
            rooms.mesh.quad({-end, -end, 0}, {end, -end, 0}, {end, end, 0}, {-end, end, 0});
        }
    }
}

}  // namespace

Scene make_rooms() {
    Rooms rooms;
    rooms.scene.name = "rooms";
    rooms.materials = add_room_materials(rooms.mesh);
    build_floors(rooms);
    build_walls(rooms);
    for (int row = 0; row < rooms_per_side; ++row) {
        for (int column = 0; column < rooms_per_side; ++column) {
            furnish(rooms, column, row);
        }
    }
    Scene scene = std::move(rooms.scene);
    scene.camera = {
        .eye = {-4.0f, -21.0f, 17.5f}, .target = {-0.6f, -5.2f, 0.5f}, .vertical_field_of_view = 0.72f};
    scene.ambient = glm::vec3{0.045f, 0.045f, 0.055f};
    scene.background = {0.02f, 0.02f, 0.03f};
    scene.radius = 1.0f;
    scene.quality = 4.0f;
    return scene;
}

}  // namespace demo
