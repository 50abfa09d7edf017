// SPDX-License-Identifier: MIT
// A park at dusk: meadows and a pond between hills, paths with benches and lamps, a pavilion, a hundred trees
// of loose leaves. One unit is about 0.4 m.
#include "mesh_builder.hpp"
#include "park_plan.hpp"
#include "plants.hpp"
#include "random.hpp"
#include "scene.hpp"
#include "terrain.hpp"

#include <stdexcept>
#include <string>

namespace demo {
namespace {

constexpr std::size_t triangle_goal = 145970;
constexpr std::size_t lamp_goal = 64;
constexpr float path_half_width = 2.3f;
constexpr glm::vec2 pavilion_place{14.0f, 21.0f};
constexpr glm::vec2 view_from = park_view_from;
constexpr glm::vec2 view_to = park_view_to;

struct ParkMaterials {
    std::uint32_t grass, gravel, water, stone, wood, iron, bulb, plaster, roof;
    std::array<std::uint32_t, 4> ground_leaves;
    std::array<std::uint32_t, 3> blades;
    Foliage oak, lime, maple, birch, fir;
};

ParkMaterials add_park_materials(MeshBuilder& mesh) {
    const auto plain = [&](const char* name, glm::vec3 colour) {
        return mesh.add_material({.name = name, .diffuse = colour});
    };
    ParkMaterials m{};
    m.grass = plain("grass", {0.16f, 0.24f, 0.08f});
    m.gravel = plain("gravel", {0.52f, 0.44f, 0.33f});
    m.water = mesh.add_material({.name = "water",
                                 .diffuse = {0.012f, 0.022f, 0.03f},
                                 .specular = glm::vec3{0.5f},
                                 .shininess = 220.0f,
                                 .k_s = 0.62f});
    m.stone = plain("stone", {0.42f, 0.40f, 0.38f});
    m.wood = plain("bench wood", {0.44f, 0.22f, 0.10f});
    m.iron = mesh.add_material(
        {.name = "iron", .diffuse = {0.05f, 0.06f, 0.06f}, .specular = glm::vec3{0.25f}, .shininess = 40.0f});
    m.bulb = mesh.add_material({.name = "bulb", .diffuse = glm::vec3{0.8f}, .emission = {2.2f, 1.7f, 1.0f}});
    m.plaster = plain("plaster", {0.78f, 0.74f, 0.66f});
    m.roof = plain("roof", {0.30f, 0.14f, 0.10f});
    const auto dark_bark = plain("dark bark", {0.17f, 0.12f, 0.08f});
    const auto pale_bark = plain("birch bark", {0.66f, 0.64f, 0.58f});
    const auto three = [&](const char* name, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
        return std::array<std::uint32_t, 3>{plain(name, a), plain(name, b), plain(name, c)};
    };
    m.oak = {dark_bark,
             three("oak leaf", {0.20f, 0.34f, 0.09f}, {0.27f, 0.40f, 0.11f}, {0.36f, 0.42f, 0.12f})};
    m.lime = {dark_bark,
              three("lime leaf", {0.44f, 0.46f, 0.10f}, {0.58f, 0.52f, 0.11f}, {0.66f, 0.50f, 0.10f})};
    m.maple = {dark_bark,
               three("maple leaf", {0.66f, 0.22f, 0.06f}, {0.74f, 0.34f, 0.07f}, {0.56f, 0.13f, 0.05f})};
    m.birch = {pale_bark,
               three("birch leaf", {0.74f, 0.58f, 0.12f}, {0.66f, 0.60f, 0.16f}, {0.52f, 0.52f, 0.14f})};
    m.fir = {dark_bark,
             three("fir twig", {0.07f, 0.18f, 0.10f}, {0.10f, 0.23f, 0.12f}, {0.12f, 0.27f, 0.13f})};
    m.ground_leaves = {m.lime.leaves[2], m.maple.leaves[0], m.maple.leaves[1], m.birch.leaves[0]};
    m.blades = three("grass blade", {0.18f, 0.30f, 0.08f}, {0.24f, 0.36f, 0.10f}, {0.30f, 0.38f, 0.13f});
    return m;
}

struct Park {
    Scene scene;
    MeshBuilder mesh{scene};
    Random random{100};
    Terrain terrain;
    ParkMaterials materials;
    std::vector<Path> paths;
    std::vector<glm::vec2> lamps;
    std::vector<glm::vec2> trees;
};

float distance_to_paths(const Park& park, glm::vec2 p) {
    float closest = 1e9f;
    for (const Path& path : park.paths) {
        closest = (std::min)(closest, path.distance(p));
    }
    return closest;
}

float distance_to_any(const std::vector<glm::vec2>& places, glm::vec2 p) {
    float closest = 1e9f;
    for (const glm::vec2& place : places) {
        closest = (std::min)(closest, glm::length(p - place));
    }
    return closest;
}

void build_ground(Park& park) {
    constexpr int cells = 92;
    constexpr float half = 82.0f;
    park.mesh.use(park.materials.grass);
    for (int j = 0; j <= cells; ++j) {
        for (int i = 0; i <= cells; ++i) {
            const glm::vec2 p{-half + 2.0f * half * static_cast<float>(i) / cells,
                              -half + 2.0f * half * static_cast<float>(j) / cells};
            park.mesh.vertex(park.terrain.on_ground(p), park.terrain.normal(p));
        }
    }
    for (std::uint32_t j = 0; j < cells; ++j) {
        for (std::uint32_t i = 0; i < cells; ++i) {
            const std::uint32_t corner = j * (cells + 1) + i;
            park.mesh.face(corner, corner + 1, corner + cells + 2);
            park.mesh.face(corner, corner + cells + 2, corner + cells + 1);
        }
    }
}

void build_paths(Park& park) {
    park.mesh.use(park.materials.gravel);
    float lift = path_lift;
    for (const Path& path : park.paths) {
        const auto first = static_cast<std::uint32_t>(park.scene.positions.size());
        for (std::size_t i = 0; i < path.points().size(); ++i) {
            for (const float across : {path_half_width, 0.0f, -path_half_width}) {
                const glm::vec2 p = path.points()[i] + across * path.left(i);
                park.mesh.vertex(park.terrain.on_ground(p, across == 0.0f ? lift + 0.02f : lift),
                                 park.terrain.normal(p));
            }
        }
        for (std::uint32_t i = 0; i + 1 < path.points().size(); ++i) {
            for (std::uint32_t k = 0; k < 2; ++k) {
                const std::uint32_t corner = first + 3 * i + k;
                park.mesh.face(corner, corner + 1, corner + 4);
                park.mesh.face(corner, corner + 4, corner + 3);
            }
        }
        lift += 0.012f;  // paths that cross must not lie in one plane
    }
}

void build_pond(Park& park) {
    const Pond& pond = park.terrain.pond;
    constexpr std::uint32_t sides = 48;
    park.mesh.use(park.materials.water);
    const std::uint32_t middle = park.mesh.vertex({pond.centre, pond.water_level}, {0, 0, 1});
    for (std::uint32_t i = 0; i < sides; ++i) {
        const glm::vec2 around = circle_point(static_cast<float>(i) / sides);
        park.mesh.vertex({pond.centre + 1.12f * around * pond.radii, pond.water_level}, {0, 0, 1});
    }
    for (std::uint32_t i = 0; i < sides; ++i) {
        park.mesh.face(middle, middle + 1 + i, middle + 1 + (i + 1) % sides);
    }
    park.mesh.use(park.materials.stone);
    for (int i = 0; i < 70; ++i) {
        const glm::vec2 around = circle_point(park.random.uniform());
        const glm::vec2 p = pond.centre + park.random.uniform(0.97f, 1.08f) * around * pond.radii;
        park.mesh.ball(park.terrain.on_ground(p, 0.05f), park.random.uniform(0.25f, 0.8f), 1);
    }
}

/// A post with an arm; the light hangs under a small hat, where the post throws a thin shadow only.
void build_lamp(Park& park, glm::vec2 place, glm::vec2 towards) {
    MeshBuilder& mesh = park.mesh;
    const glm::vec3 foot = park.terrain.on_ground(place);
    const glm::vec3 arm{towards.x, towards.y, 0.0f};
    const glm::vec3 top = foot + glm::vec3{0, 0, 8.6f};
    const glm::vec3 lamp = top + 1.3f * arm;
    mesh.place({0, 0, 0});
    mesh.use(park.materials.iron);
    mesh.tube(foot - glm::vec3{0, 0, 0.4f}, foot + glm::vec3{0, 0, 0.9f}, 0.34f, 0.20f, 6);
    mesh.tube(foot + glm::vec3{0, 0, 0.9f}, top, 0.13f, 0.10f, 6);
    mesh.tube(top - glm::vec3{0, 0, 0.15f} - 0.1f * arm, lamp + glm::vec3{0, 0, 0.15f}, 0.09f, 0.07f, 4);
    mesh.tube(lamp - glm::vec3{0, 0, 0.1f}, lamp + glm::vec3{0, 0, 0.45f}, 0.72f, 0.0f, 10);
    mesh.use(park.materials.bulb);
    mesh.ball(lamp - glm::vec3{0, 0, 0.12f}, 0.27f, 1);
    park.scene.lights.push_back(
        {lightmesh::PointLight{lamp - glm::vec3{0, 0, 0.55f}}, 34.0f * glm::vec3{1.0f, 0.74f, 0.42f}});
    park.lamps.push_back(place);
}

bool is_free_for_lamp(const Park& park, glm::vec2 place) {
    return distance_to_any(park.lamps, place) > 8.5f &&
           distance_to_paths(park, place) > path_half_width + 0.4f &&
           glm::length(place - view_from) > 24.0f && glm::length(place - pavilion_place) > 9.0f &&
           (std::max)(std::abs(place.x), std::abs(place.y)) < 70.0f;
}

void build_lamps(Park& park) {
    bool on_left = true;
    for (const Path& path : park.paths) {
        for (std::size_t i = 2; i < path.points().size(); i += 5) {
            const glm::vec2 outwards = (on_left ? 1.0f : -1.0f) * path.left(i);
            const glm::vec2 place = path.points()[i] + (path_half_width + 0.9f) * outwards;
            on_left = !on_left;
            if (park.scene.lights.size() < lamp_goal && is_free_for_lamp(park, place)) {
                build_lamp(park, place, -outwards);
            }
        }
    }
}

void build_bench(Park& park, glm::vec2 place, glm::vec2 facing) {
    MeshBuilder& mesh = park.mesh;
    // `place` turns by an angle; only directions are known here, so the frame is spelled out.
    const glm::vec3 foot = park.terrain.on_ground(place);
    const glm::vec3 ahead{facing.x, facing.y, 0.0f};
    const glm::vec3 side{-facing.y, facing.x, 0.0f};
    const auto plank = [&](glm::vec3 low, glm::vec3 high) {
        const auto at = [&](float x, float y, float z) {
            return foot + x * side + y * ahead + glm::vec3{0, 0, z};
        };
        mesh.quad(at(low.x, low.y, high.z), at(low.x, high.y, high.z), at(high.x, high.y, high.z),
                  at(high.x, low.y, high.z));
        mesh.quad(at(low.x, low.y, low.z), at(high.x, low.y, low.z), at(high.x, high.y, low.z),
                  at(low.x, high.y, low.z));
        mesh.quad(at(low.x, low.y, low.z), at(low.x, low.y, high.z), at(high.x, low.y, high.z),
                  at(high.x, low.y, low.z));
        mesh.quad(at(low.x, high.y, low.z), at(high.x, high.y, low.z), at(high.x, high.y, high.z),
                  at(low.x, high.y, high.z));
        mesh.quad(at(low.x, low.y, low.z), at(low.x, high.y, low.z), at(low.x, high.y, high.z),
                  at(low.x, low.y, high.z));
        mesh.quad(at(high.x, low.y, low.z), at(high.x, low.y, high.z), at(high.x, high.y, high.z),
                  at(high.x, high.y, low.z));
    };
    mesh.place({0, 0, 0});
    mesh.use(park.materials.wood);
    for (const float y : {-0.45f, 0.0f, 0.45f}) {
        plank({-2.3f, y - 0.18f, 1.1f}, {2.3f, y + 0.18f, 1.25f});
    }
    for (const float z : {1.6f, 2.1f}) {
        plank({-2.3f, -0.78f, z}, {2.3f, -0.65f, z + 0.36f});
    }
    mesh.use(park.materials.iron);
    for (const float x : {-1.8f, 1.8f}) {
        plank({x - 0.12f, -0.6f, -0.3f}, {x + 0.12f, 0.6f, 1.1f});
        plank({x - 0.12f, -0.9f, -0.3f}, {x + 0.12f, -0.78f, 2.4f});
    }
}

void build_benches(Park& park) {
    constexpr std::size_t spacing = 8;
    for (const Path& path : park.paths) {
        for (std::size_t i = spacing; i + 2 < path.points().size(); i += 2 * spacing) {
            for (const float way : {1.0f, -1.0f}) {
                const glm::vec2 outwards = way * path.left(i);
                const glm::vec2 place = path.points()[i] + (path_half_width + 1.4f) * outwards;
                if (distance_to_any(park.lamps, place) > 3.2f &&
                    distance_to_paths(park, place) > path_half_width + 1.0f &&
                    park.terrain.pond.distance(place) > 1.2f && glm::length(place - pavilion_place) > 9.0f) {
                    build_bench(park, place, -outwards);
                    break;
                }
            }
        }
    }
}

void build_pavilion(Park& park) {
    MeshBuilder& mesh = park.mesh;
    constexpr int columns = 8;
    mesh.place(park.terrain.on_ground(pavilion_place));
    mesh.use(park.materials.stone);
    for (int i = 0; i < 3; ++i) {
        const float radius = 7.2f - 0.7f * static_cast<float>(i);
        const float top = 0.5f + 0.4f * static_cast<float>(i);
        mesh.tube({0, 0, -2.0f}, {0, 0, top}, radius, radius, 32);
        mesh.disc({0, 0, top}, {0, 0, 1}, radius, 32);
    }
    mesh.use(park.materials.plaster);
    for (int i = 0; i < columns; ++i) {
        const glm::vec2 around = circle_point((static_cast<float>(i) + 0.5f) / columns);
        const glm::vec3 foot{4.9f * around, 1.3f};
        mesh.tube(foot, foot + glm::vec3{0, 0, 0.4f}, 0.62f, 0.46f, 12);
        mesh.tube(foot + glm::vec3{0, 0, 0.4f}, foot + glm::vec3{0, 0, 7.0f}, 0.42f, 0.36f, 12);
        mesh.tube(foot + glm::vec3{0, 0, 7.0f}, foot + glm::vec3{0, 0, 7.4f}, 0.38f, 0.62f, 12);
    }
    mesh.tube({0, 0, 8.7f}, {0, 0, 9.5f}, 5.6f, 5.6f, 32);
    mesh.tube({0, 0, 9.5f}, {0, 0, 8.7f}, 4.3f, 4.3f, 32);
    mesh.use(park.materials.roof);
    mesh.disc({0, 0, 9.4f}, {0, 0, -1}, 5.6f, 32);
    mesh.tube({0, 0, 9.45f}, {0, 0, 13.4f}, 6.5f, 0.0f, 32);
    mesh.use(park.materials.bulb);
    mesh.ball({0, 0, 8.5f}, 0.35f, 2);
    mesh.use(park.materials.iron);
    mesh.tube({0, 0, 8.7f}, {0, 0, 9.4f}, 0.06f, 0.06f, 4);
    park.scene.lights.push_back(
        {lightmesh::PointLight{mesh.to_world({0, 0, 7.9f})}, 38.0f * glm::vec3{1.0f, 0.78f, 0.48f}});
}

/// Trees stand where the camera sees them, but leave the view of the pond open.
bool is_in_the_picture(glm::vec2 p) {
    const glm::vec2 ahead = glm::normalize(view_to - view_from);
    const float along = glm::dot(p - view_from, ahead);
    const float across = std::abs(glm::dot(p - view_from, glm::vec2{-ahead.y, ahead.x}));
    const bool before_the_pond = along < 64.0f && across < 7.0f + 0.25f * along;
    return along > 26.0f && across < 14.0f + 0.52f * along && !before_the_pond;
}

bool is_free_for_tree(const Park& park, glm::vec2 p, float spacing) {
    return distance_to_any(park.trees, p) > spacing && distance_to_any(park.lamps, p) > 3.0f &&
           park.terrain.pond.distance(p) > 1.35f && glm::length(p - pavilion_place) > 12.0f &&
           distance_to_paths(park, p) > path_half_width + 1.5f && is_in_the_picture(p);
}

void build_tree(Park& park, glm::vec2 place) {
    const ParkMaterials& m = park.materials;
    const glm::vec3 root = park.terrain.on_ground(place);
    const std::uint32_t kind = park.random.index(20);
    const float height = park.random.uniform(12.5f, 18.0f);
    if (kind < 4) {
        add_conifer(park.mesh, park.random, m.fir, root, height * 1.15f, 440);
        return;
    }
    const Foliage& foliage = kind < 9 ? m.oak : kind < 13 ? m.lime : kind < 17 ? m.maple : m.birch;
    add_broadleaf(park.mesh, park.random, foliage, root, height, 440);
}

void plant_trees(Park& park) {
    constexpr std::size_t goal = 100;
    constexpr int tries = 40000;
    for (const glm::vec2& place : {glm::vec2{-6.0f, -31.5f}, glm::vec2{17.5f, -30.0f}}) {
        park.trees.push_back(place);
        add_broadleaf(park.mesh, park.random, place.x < 0.0f ? park.materials.birch : park.materials.maple,
                      park.terrain.on_ground(place), 8.5f, 300);
    }
    const std::array<glm::vec2, 3> chosen{glm::vec2{-27.5f, -31.0f}, glm::vec2{33.0f, -25.5f},
                                          glm::vec2{-4.5f, 26.5f}};
    for (const glm::vec2& place : chosen) {
        park.trees.push_back(place);
        build_tree(park, place);
    }
    for (int i = 0; i < tries && park.trees.size() < goal; ++i) {
        const glm::vec2 place{park.random.uniform(-72.0f, 72.0f), park.random.uniform(-60.0f, 76.0f)};
        if (is_free_for_tree(park, place, 7.0f)) {
            park.trees.push_back(place);
            build_tree(park, place);
        }
    }
}

void plant_bushes(Park& park) {
    const ParkMaterials& m = park.materials;
    for (int planted = 0, tries = 0; planted < 45 && tries < 4000; ++tries) {
        const glm::vec2 place{park.random.uniform(-60.0f, 60.0f), park.random.uniform(-56.0f, 60.0f)};
        const float from_path = distance_to_paths(park, place);
        if (from_path < path_half_width + 2.0f || from_path > path_half_width + 6.0f ||
            park.terrain.pond.distance(place) < 1.3f || glm::length(place - pavilion_place) < 10.0f) {
            continue;
        }
        const Foliage& foliage = planted % 3 == 0 ? m.maple : planted % 3 == 1 ? m.oak : m.lime;
        const float size = park.random.uniform(1.3f, 2.1f);
        park.mesh.place({0, 0, 0});
        add_leaf_cluster(park.mesh, park.random, foliage, park.terrain.on_ground(place, 0.7f * size),
                         {size, size, 0.85f * size}, 85, 0.85f);
        ++planted;
    }
}

/// Leaves on the ground, near trees, and blades of grass: as many as are missing to the goal.
void scatter_to_goal(Park& park) {
    MeshBuilder& mesh = park.mesh;
    if (mesh.triangle_count() > triangle_goal) {
        throw std::logic_error("make_park: " + std::to_string(mesh.triangle_count()) +
                               " triangles, more than planned");
    }
    mesh.place({0, 0, 0});
    while (mesh.triangle_count() < triangle_goal) {
        const glm::vec2 around = circle_point(park.random.uniform());
        if (mesh.triangle_count() % 5 == 0) {
            const glm::vec2 tree =
                park.trees[park.random.index(static_cast<std::uint32_t>(park.trees.size()))];
            const glm::vec2 p = tree + 6.5f * std::sqrt(park.random.uniform()) * around;
            const glm::vec3 root = park.terrain.on_ground(p, 0.22f);
            mesh.use(park.materials.ground_leaves[park.random.index(4)]);
            add_blade(mesh, root, {0.22f * around.y, -0.22f * around.x, 0.04f},
                      root + glm::vec3{0.6f * around, park.random.uniform(-0.05f, 0.2f)});
            continue;
        }
        const float away = park.random.uniform();  // most of the grass near the camera
        const glm::vec2 p{park.random.uniform(-38.0f, 44.0f), -52.0f + 75.0f * away * away};
        if (distance_to_paths(park, p) > path_half_width + 0.3f && park.terrain.pond.distance(p) > 1.04f) {
            const glm::vec3 root = park.terrain.on_ground(p, -0.05f);
            mesh.use(park.materials.blades[park.random.index(3)]);
            add_blade(mesh, root, {0.10f * around.y, -0.10f * around.x, 0.0f},
                      root + glm::vec3{0.25f * around, park.random.uniform(0.5f, 1.1f)});
        }
    }
}

}  // namespace

Scene make_park() {
    Park park;
    park.scene.name = "park";
    park.materials = add_park_materials(park.mesh);
    park.paths = park_paths(park.terrain.pond);
    build_ground(park);
    build_paths(park);
    build_pond(park);
    build_pavilion(park);
    build_lamps(park);
    build_benches(park);
    plant_trees(park);
    plant_bushes(park);
    scatter_to_goal(park);
    Scene scene = std::move(park.scene);
    scene.camera = {.eye = {view_from, 17.0f}, .target = {view_to, 1.0f}, .vertical_field_of_view = 0.70f};
    scene.ambient = {0.030f, 0.036f, 0.055f};
    scene.background = {0.020f, 0.032f, 0.075f};
    scene.radius = 3.0f;
    scene.quality = 4.0f;
    return scene;
}

}  // namespace demo
