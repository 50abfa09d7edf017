// SPDX-License-Identifier: MIT
// Six balls on a floor and against a wall, one a mirror and one of glass, under eight lamps.
#include "mesh_builder.hpp"
#include "random.hpp"
#include "scene.hpp"

#include <array>

namespace demo {
namespace {

// Triangles: 2 x 500 + 2 x 320 + 2 x 180 for the balls, 2 x 10 for the plinths, 4 x 2 for floor and walls.
void build(MeshBuilder& mesh) {
    const auto floor = mesh.add_material({.name = "floor", .diffuse = {0.62f, 0.58f, 0.52f}});
    const auto wall = mesh.add_material({.name = "wall", .diffuse = {0.66f, 0.67f, 0.70f}});
    const auto left = mesh.add_material({.name = "left wall", .diffuse = {0.62f, 0.30f, 0.20f}});
    const auto right = mesh.add_material({.name = "right wall", .diffuse = {0.20f, 0.40f, 0.46f}});
    const auto plinth = mesh.add_material({.name = "plinth", .diffuse = {0.70f, 0.68f, 0.64f}});
    const auto mirror = mesh.add_material({.name = "mirror",
                                           .diffuse = {0.03f, 0.03f, 0.03f},
                                           .specular = glm::vec3{0.6f},
                                           .shininess = 300.0f,
                                           .k_s = 0.88f});
    const auto glass = mesh.add_material({.name = "glass",
                                          .diffuse = {0.01f, 0.015f, 0.015f},
                                          .specular = glm::vec3{0.8f},
                                          .shininess = 400.0f,
                                          .k_s = 0.08f,
                                          .k_t = 0.88f,
                                          .refraction_index = 1.5f});
    const auto glossy = [&](const char* name, glm::vec3 colour) {
        return mesh.add_material({.name = name,
                                  .diffuse = colour,
                                  .specular = glm::vec3{0.35f},
                                  .shininess = 60.0f,
                                  .k_s = 0.04f});
    };
    const auto red = glossy("red", {0.72f, 0.10f, 0.07f});
    const auto yellow = glossy("yellow", {0.85f, 0.58f, 0.10f});
    const auto blue = glossy("blue", {0.10f, 0.22f, 0.62f});
    const auto green = glossy("green", {0.14f, 0.48f, 0.22f});

    mesh.use(floor);
    mesh.quad({-60, -70, 0}, {60, -70, 0}, {60, 40, 0}, {-60, 40, 0});
    mesh.use(wall);
    mesh.quad({-60, 40, 0}, {60, 40, 0}, {60, 40, 70}, {-60, 40, 70});
    mesh.use(left);
    mesh.quad({-60, -70, 0}, {-60, 40, 0}, {-60, 40, 70}, {-60, -70, 70});
    mesh.use(right);
    mesh.quad({60, 40, 0}, {60, -70, 0}, {60, -70, 70}, {60, 40, 70});

    mesh.use(plinth);
    mesh.place({-30, 20, 0}, 0.03f);
    mesh.box({-11, -11, 0}, {11, 11, 10}, false);
    mesh.place({36, 23, 0}, -0.045f);
    mesh.box({-10, -10, 0}, {10, 10, 18}, false);
    mesh.place({0, 0, 0});

    mesh.use(mirror);
    mesh.ball({4, 18, 15.0f}, 15.0f, 5);
    mesh.use(glass);
    mesh.ball({14, -16, 10.0f}, 10.0f, 5);
    mesh.use(red);
    mesh.ball({-30, 20, 20.0f}, 10.0f, 4);
    mesh.use(yellow);
    mesh.ball({36, 23, 26.5f}, 8.5f, 4);
    mesh.use(blue);
    mesh.ball({-17, -13, 7.0f}, 7.0f, 3);
    mesh.use(green);
    mesh.ball({37, -5, 6.0f}, 6.0f, 3);
}

void hang_lights(Scene& scene) {
    constexpr int count = 8;
    constexpr std::array<float, count> strength{1300, 260, 420, 900, 380, 760, 420, 300};
    for (int i = 0; i < count; ++i) {
        const glm::vec2 around = circle_point((static_cast<float>(i) + 0.35f) / count);
        const float height = i % 2 == 0 ? 62.0f : 48.0f;
        const glm::vec3 position{46.0f * around.x, -24.0f + 34.0f * around.y, height};
        const glm::vec3 colour = i % 2 == 0 ? glm::vec3{1.0f, 0.86f, 0.68f} : glm::vec3{0.72f, 0.84f, 1.0f};
        scene.lights.push_back(
            {lightmesh::PointLight{position}, strength[static_cast<std::size_t>(i)] * colour});
    }
}

}  // namespace

Scene make_spheres() {
    Scene scene;
    scene.name = "spheres";
    MeshBuilder mesh{scene};
    build(mesh);
    hang_lights(scene);
    scene.camera = {.eye = {2, -104, 40}, .target = {2, 2, 14}, .vertical_field_of_view = 0.66f};
    scene.ambient = glm::vec3{0.05f};
    scene.background = {0.13f, 0.15f, 0.19f};  // seen in the mirror only
    scene.radius = 4.5f;
    scene.quality = 6.0f;
    return scene;
}

}  // namespace demo
