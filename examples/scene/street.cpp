// SPDX-License-Identifier: MIT
// A street at night, 212 m long, at true scale: houses with windows and doors on both sides, lamp posts,
// lamps over the doors, parked cars. One unit is a metre; the view runs along the street.
#include "mesh_builder.hpp"
#include "random.hpp"
#include "scene.hpp"

#include <array>
#include <cstdint>
#include <utility>

namespace demo {
namespace {

constexpr float street_length = 212.0f;
constexpr float road_half_width = 4.2f;
constexpr float front = 7.5f;  // of the houses, from the middle of the street
constexpr float kerb = 0.13f;
constexpr float storey = 3.1f;
constexpr float post_spacing = 21.0f;

struct StreetMaterials {
    std::uint32_t asphalt, pavement, paint, glass, door, iron, roof, stone, rubber, bulb;
    std::array<std::uint32_t, 6> plaster;
    std::array<std::uint32_t, 4> car;
};

StreetMaterials add_street_materials(MeshBuilder& mesh) {
    const auto plain = [&](const char* name, glm::vec3 colour) {
        return mesh.add_material({.name = name, .diffuse = colour});
    };
    StreetMaterials m{};
    m.asphalt = plain("asphalt", {0.16f, 0.16f, 0.17f});
    m.pavement = plain("pavement", {0.44f, 0.43f, 0.41f});
    m.paint = plain("paint", {0.80f, 0.79f, 0.75f});
    m.glass = mesh.add_material({.name = "window",
                                 .diffuse = {0.05f, 0.06f, 0.08f},
                                 .specular = glm::vec3{0.5f},
                                 .shininess = 200.0f,
                                 .k_s = 0.25f});
    m.door = plain("door", {0.24f, 0.11f, 0.06f});
    m.iron = mesh.add_material(
        {.name = "iron", .diffuse = {0.07f, 0.08f, 0.08f}, .specular = glm::vec3{0.2f}, .shininess = 40.0f});
    m.roof = plain("roof", {0.30f, 0.13f, 0.09f});
    m.stone = plain("stone", {0.58f, 0.54f, 0.47f});
    m.rubber = plain("rubber", {0.04f, 0.04f, 0.04f});
    m.bulb = mesh.add_material({.name = "bulb", .diffuse = glm::vec3{0.8f}, .emission = {2.4f, 1.9f, 1.2f}});
    m.plaster = {plain("ochre", {0.66f, 0.50f, 0.28f}),        plain("white plaster", {0.76f, 0.74f, 0.69f}),
                 plain("brick", {0.46f, 0.22f, 0.15f}),        plain("grey plaster", {0.52f, 0.53f, 0.54f}),
                 plain("rose plaster", {0.64f, 0.42f, 0.36f}), plain("green plaster", {0.42f, 0.50f, 0.36f})};
    const auto lacquer = [&](const char* name, glm::vec3 colour) {
        return mesh.add_material(
            {.name = name, .diffuse = colour, .specular = glm::vec3{0.4f}, .shininess = 90.0f, .k_s = 0.06f});
    };
    m.car = {lacquer("red lacquer", {0.45f, 0.05f, 0.04f}), lacquer("blue lacquer", {0.07f, 0.13f, 0.32f}),
             lacquer("white lacquer", {0.72f, 0.72f, 0.70f}), lacquer("grey lacquer", {0.25f, 0.26f, 0.28f})};
    return m;
}

struct Street {
    Scene scene;
    MeshBuilder mesh{scene};
    Random random{1847};
    StreetMaterials materials{};

    void add_lamp(glm::vec3 position, glm::vec3 intensity) {
        scene.lights.push_back({lightmesh::PointLight{position}, intensity});
    }
};

/// The local frame of a house or a lamp on one side (-1 or 1): x runs along the street to the right of who
/// faces the house, y into it, from the kerb's height up.
void place_at(Street& street, float side, float away, float along) {
    street.mesh.place({side * away, along, kerb}, side < 0.0f ? 0.25f : -0.25f);
}

void build_ground(Street& street) {
    MeshBuilder& mesh = street.mesh;
    mesh.place({0, 0, 0});
    mesh.use(street.materials.asphalt);
    mesh.quad({-road_half_width, -15, 0}, {road_half_width, -15, 0}, {road_half_width, street_length + 8, 0},
              {-road_half_width, street_length + 8, 0});
    mesh.use(street.materials.paint);
    for (float y = -12.0f; y < street_length; y += 6.0f)
        mesh.box({-0.07f, y, 0}, {0.07f, y + 2.5f, 0.006f}, false);
    for (const float side : {-1.0f, 1.0f}) {
        const float low = side < 0.0f ? -front - 14.0f : road_half_width;
        mesh.use(street.materials.pavement);
        mesh.box({low, -15, -0.3f}, {low + front + 14.0f - road_half_width, street_length + 8, kerb}, false);
        mesh.use(street.materials.stone);
        const float edge = side * (road_half_width - 0.09f);
        for (float y = -15.0f; y < street_length + 7.0f; y += 1.2f)
            mesh.box({edge - 0.08f, y, 0}, {edge + 0.08f, y + 1.185f, kerb + 0.01f}, false);
    }
}

/// Of the house's front, which is the plane y = 0; the window's lower middle at (x, z).
void build_window(Street& street, float x, float z, float width, float height) {
    MeshBuilder& mesh = street.mesh;
    const float half = 0.5f * width;
    mesh.use(street.materials.glass);
    mesh.quad({x - half, -0.01f, z}, {x + half, -0.01f, z}, {x + half, -0.01f, z + height},
              {x - half, -0.01f, z + height});
    mesh.use(street.materials.paint);
    for (const float edge : {x - half - 0.04f, x - 0.02f, x + half - 0.04f})
        mesh.box({edge, -0.06f, z}, {edge + 0.08f, 0, z + height});
    for (const float edge : {z - 0.02f, z + 0.66f * height, z + height - 0.04f})
        mesh.box({x - half, -0.05f, edge}, {x + half, 0, edge + 0.07f});
    mesh.use(street.materials.stone);
    mesh.box({x - half - 0.14f, -0.2f, z - 0.11f}, {x + half + 0.14f, 0, z - 0.03f});
    mesh.box({x - half - 0.12f, -0.13f, z + height + 0.05f}, {x + half + 0.12f, 0, z + height + 0.2f});
}

void build_balcony(Street& street, float x, float z, float width) {
    MeshBuilder& mesh = street.mesh;
    const float half = 0.5f * width;
    mesh.use(street.materials.stone);
    mesh.box({x - half, -1.1f, z - 0.16f}, {x + half, 0, z});
    mesh.use(street.materials.iron);
    mesh.box({x - half, -1.1f, z + 0.95f}, {x + half, -1.06f, z + 1.0f});
    for (float bar = x - half; bar < x + half; bar += 0.14f)
        mesh.box({bar, -1.09f, z}, {bar + 0.022f, -1.068f, z + 0.95f}, false);
    for (const float end : {x - half, x + half - 0.04f})
        mesh.box({end, -1.06f, z + 0.95f}, {end + 0.04f, 0, z + 1.0f});
}

/// With steps, a canopy, and a lamp below it.
void build_door(Street& street, float x) {
    MeshBuilder& mesh = street.mesh;
    mesh.use(street.materials.door);
    mesh.box({x - 0.55f, -0.03f, 0.3f}, {x + 0.55f, 0, 2.5f});
    mesh.use(street.materials.stone);
    mesh.box({x - 0.9f, -0.8f, 0}, {x + 0.9f, 0, 0.15f}, false);
    mesh.box({x - 0.75f, -0.45f, 0.15f}, {x + 0.75f, 0, 0.3f}, false);
    for (const float edge : {x - 0.72f, x + 0.55f})
        mesh.box({edge, -0.1f, 0.3f}, {edge + 0.17f, 0, 2.7f});
    mesh.box({x - 1.0f, -0.9f, 2.95f}, {x + 1.0f, 0, 3.06f});
    mesh.use(street.materials.bulb);
    mesh.ball({x, -0.5f, 2.89f}, 0.05f, 2);
    street.add_lamp(mesh.to_world({x, -0.5f, 2.72f}), glm::vec3{1.0f, 0.72f, 0.42f} * 2.4f);
}

void build_house(Street& street, float width, int storeys) {
    MeshBuilder& mesh = street.mesh;
    Random& random = street.random;
    const float half = 0.5f * width;
    const float height = storey * static_cast<float>(storeys) + 0.9f;
    const float depth = 11.0f;
    mesh.use(street.materials.plaster[random.index(6)]);
    mesh.box({-half, 0, 0}, {half, depth, height}, false);
    mesh.use(street.materials.stone);
    mesh.box({-half, -0.08f, 0}, {half, 0, 0.55f}, false);
    for (int s = 1; s <= storeys; ++s) {
        const float z = storey * static_cast<float>(s) + 0.5f;
        const float out = s == storeys ? 0.4f : 0.12f;
        mesh.box({-half, -out, z}, {half, 0, z + 0.16f});
    }
    mesh.use(street.materials.roof);
    const float ridge = height + random.uniform(2.2f, 3.6f);
    mesh.quad({-half, -0.35f, height}, {half, -0.35f, height}, {half, 0.5f * depth, ridge},
              {-half, 0.5f * depth, ridge});
    mesh.quad({-half, 0.5f * depth, ridge}, {half, 0.5f * depth, ridge}, {half, depth, height},
              {-half, depth, height});
    mesh.use(street.materials.plaster[2]);
    for (const float x : {-half, half - 0.3f})
        mesh.box({x, 3.0f, height}, {x + 0.3f, 4.2f, ridge + 0.9f}, false);

    const int columns = static_cast<int>(width / 2.3f);
    const float spacing = width / static_cast<float>(columns);
    const int door = static_cast<int>(random.index(static_cast<std::uint32_t>(columns)));
    const bool has_balconies = random.index(3) == 0;
    for (int c = 0; c < columns; ++c) {
        const float x = -half + (static_cast<float>(c) + 0.5f) * spacing;
        for (int s = 0; s < storeys; ++s) {
            const float z = storey * static_cast<float>(s) + 1.35f;
            if (s == 0 && c == door) {
                build_door(street, x);
                continue;
            }
            build_window(street, x, z, 1.1f, 1.65f);
            if (s > 0 && has_balconies && c % 2 == 1)
                build_balcony(street, x, storey * static_cast<float>(s) + 0.66f, 1.9f);
        }
    }
}

void build_houses(Street& street) {
    for (const float side : {-1.0f, 1.0f}) {
        float y = -15.0f;
        while (y < street_length) {
            const float width = street.random.uniform(8.0f, 14.0f);
            const int storeys = 3 + static_cast<int>(street.random.index(3));
            place_at(street, side, front + street.random.uniform(0.0f, 0.25f), y + 0.5f * width);
            build_house(street, width, storeys);
            y += width;
        }
    }
    street.mesh.place({0, street_length + 8.0f, 0});
    build_house(street, 26.0f, 5);
}

void build_posts(Street& street) {
    int number = 0;
    for (float y = 4.0f; y < street_length; y += 0.5f * post_spacing, ++number) {
        const float side = number % 2 == 0 ? -1.0f : 1.0f;
        place_at(street, side, road_half_width + 0.45f, y);
        MeshBuilder& mesh = street.mesh;
        mesh.use(street.materials.iron);
        mesh.tube({0, 0, 0}, {0, 0, 0.8f}, 0.11f, 0.09f, 12);
        mesh.tube({0, 0, 0.8f}, {0, 0, 5.6f}, 0.06f, 0.045f, 10);
        mesh.tube({0, 0, 5.55f}, {0, -1.5f, 5.85f}, 0.04f, 0.03f, 8);
        mesh.box({-0.16f, -2.0f, 5.8f}, {0.16f, -1.4f, 5.9f});
        mesh.use(street.materials.bulb);
        mesh.box({-0.12f, -1.95f, 5.77f}, {0.12f, -1.45f, 5.8f});
        street.add_lamp(mesh.to_world({0, -1.7f, 5.6f}), glm::vec3{1.0f, 0.80f, 0.52f} * 26.0f);
    }
}

void build_car(Street& street) {
    MeshBuilder& mesh = street.mesh;
    mesh.use(street.materials.car[street.random.index(4)]);
    mesh.box({-2.1f, -0.86f, 0.32f}, {2.1f, 0.86f, 0.88f});
    mesh.box({-1.3f, -0.74f, 1.34f}, {1.0f, 0.74f, 1.42f});
    for (const float x : {-1.3f, -0.15f, 0.92f})
        for (const float y : {-0.74f, 0.66f})
            mesh.box({x, y, 0.88f}, {x + 0.08f, y + 0.08f, 1.34f});
    mesh.use(street.materials.glass);
    mesh.box({-1.24f, -0.7f, 0.88f}, {0.96f, 0.7f, 1.34f});
    mesh.use(street.materials.rubber);
    for (const float x : {-1.35f, 1.3f}) {
        for (const float y : {-0.88f, 0.7f}) {
            mesh.tube({x, y, 0.31f}, {x, y + 0.18f, 0.31f}, 0.31f, 0.31f, 16);
            mesh.disc({x, y, 0.31f}, {0, -1, 0}, 0.31f, 16);
            mesh.disc({x, y + 0.18f, 0.31f}, {0, 1, 0}, 0.31f, 16);
        }
    }
}

void build_things(Street& street) {
    MeshBuilder& mesh = street.mesh;
    Random& random = street.random;
    for (const float side : {-1.0f, 1.0f}) {
        for (float y = 8.0f; y < street_length - 4.0f; y += random.uniform(5.5f, 14.0f)) {
            mesh.place({side * (road_half_width - 1.15f), y, 0}, 0.25f * side);
            build_car(street);
        }
        for (float y = 1.0f; y < street_length; y += 3.5f) {
            place_at(street, side, road_half_width + 0.3f, y);
            mesh.use(street.materials.iron);
            mesh.tube({0, 0, 0}, {0, 0, 0.85f}, 0.05f, 0.05f, 10);
            mesh.ball({0, 0, 0.88f}, 0.07f, 2);
        }
        for (float y = 11.0f; y < street_length; y += random.uniform(12.0f, 25.0f)) {
            place_at(street, side, front - 0.9f, y);
            mesh.use(street.materials.door);
            for (const float plank : {-0.42f, -0.26f, -0.1f})
                mesh.box({-0.9f, plank, 0.43f}, {0.9f, plank + 0.13f, 0.47f});
            mesh.use(street.materials.iron);
            for (const float leg : {-0.8f, 0.72f})
                mesh.box({leg, -0.4f, 0}, {leg + 0.08f, 0.02f, 0.43f}, false);
        }
    }
}

}  // namespace

Scene make_street() {
    Street street;
    street.scene.name = "street";
    street.materials = add_street_materials(street.mesh);
    build_ground(street);
    build_posts(street);
    build_houses(street);
    build_things(street);
    Scene scene = std::move(street.scene);
    scene.camera = {
        .eye = {1.2f, -6.0f, 2.1f}, .target = {-0.2f, 50.0f, 4.4f}, .vertical_field_of_view = 0.75f};
    scene.ambient = {0.035f, 0.038f, 0.055f};
    scene.background = {0.015f, 0.02f, 0.045f};
    scene.radius = 0.5f;
    scene.quality = 4.0f;
    return scene;
}

}  // namespace demo
