// SPDX-License-Identifier: MIT
#include "../examples/scene/boxes.hpp"
#include "../examples/scene/light_rig.hpp"
#include "../examples/scene/scene.hpp"

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <variant>

namespace scene_test {

namespace {

/// FNV-1a over the bits of all that a picture depends on.
class Fingerprint {
public:
    template <typename Value>
    void add(const Value& value) {
        unsigned char bytes[sizeof(Value)];
        std::memcpy(bytes, &value, sizeof(Value));
        for (const unsigned char byte : bytes) {
            value_ = (value_ ^ byte) * 1099511628211ULL;
        }
    }
    template <typename Value>
    void add_all(const std::vector<Value>& values) {
        for (const Value& value : values) {
            add(value);
        }
    }
    std::uint64_t value() const { return value_; }

private:
    std::uint64_t value_ = 14695981039346656037ULL;
};

glm::vec3 position_of(const demo::SceneLight& light) {
    return std::get<lightmesh::PointLight>(light.shape).position;
}

std::uint64_t fingerprint(const demo::Scene& scene) {
    Fingerprint result;
    result.add_all(scene.positions);
    result.add_all(scene.normals);
    result.add_all(scene.triangles);
    for (const demo::SceneLight& light : scene.lights) {
        result.add(position_of(light));
        result.add(light.intensity);
    }
    return result.value();
}

glm::vec3 closest_on_triangle(glm::vec3 p, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    const glm::vec3 n = glm::cross(b - a, c - a);
    const auto inside = [&](glm::vec3 from, glm::vec3 to) {
        return glm::dot(glm::cross(to - from, p - from), n) >= 0;
    };
    if (inside(a, b) && inside(b, c) && inside(c, a)) {
        return p - glm::dot(p - a, n) / glm::dot(n, n) * n;
    }
    const auto on_edge = [&](glm::vec3 from, glm::vec3 to) {
        const float t = glm::dot(p - from, to - from) / glm::dot(to - from, to - from);
        return from + std::clamp(t, 0.0f, 1.0f) * (to - from);
    };
    glm::vec3 best = on_edge(a, b);
    for (const glm::vec3 q : {on_edge(b, c), on_edge(c, a)}) {
        best = glm::length(p - q) < glm::length(p - best) ? q : best;
    }
    return best;
}

float distance_to_geometry(const demo::Scene& scene, glm::vec3 p) {
    float closest = 1e30f;
    for (const demo::Triangle& triangle : scene.triangles) {
        const glm::vec3 q =
            closest_on_triangle(p, scene.positions[triangle.vertex[0]], scene.positions[triangle.vertex[1]],
                                scene.positions[triangle.vertex[2]]);
        closest = (std::min)(closest, glm::length(p - q));
    }
    return closest;
}

bool is_finite(glm::vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

TEST_CASE("the built-in scenes have exactly the triangles and lights they are known for") {
    CHECK(demo::make_spheres().triangles.size() == 2028);
    CHECK(demo::make_spheres().lights.size() == 8);
    CHECK(demo::make_park().triangles.size() == 145970);
    CHECK(demo::make_park().lights.size() == 64);
    CHECK(demo::make_rooms().triangles.size() == 97538);
    CHECK(demo::make_rooms().lights.size() == 36);
    CHECK(demo::make_street().triangles.size() == 134728);
    CHECK(demo::make_street().lights.size() == 64);
}

TEST_CASE("the built-in scenes are the same to the last bit with every compiler") {
    // Changed a scene on purpose? Then these change, and the stored pictures with them.
    CHECK(fingerprint(demo::make_spheres()) == 14854768534095745953ULL);
    CHECK(fingerprint(demo::make_park()) == 1976375601634144084ULL);
    CHECK(fingerprint(demo::make_rooms()) == 16652981455499529757ULL);
    CHECK(fingerprint(demo::make_street()) == 3071032065263591419ULL);
}

TEST_CASE("the built-in scenes are sound") {
    for (const std::string& name : demo::built_in_scenes()) {
        CAPTURE(name);
        const demo::Scene scene = demo::load_scene(name);
        CHECK(scene.name == name);
        CHECK(scene.remarks.empty());
        CHECK(scene.radius > 0.0f);
        CHECK(scene.quality >= 1.0f);
        CHECK(scene.camera.vertical_field_of_view > 0.0f);
        REQUIRE(scene.normals.size() == scene.positions.size());
        CHECK(std::all_of(scene.positions.begin(), scene.positions.end(), is_finite));
        const auto is_unit = [](glm::vec3 n) {
            return std::abs(glm::length(n) - 1.0f) < 1e-4f;
        };
        CHECK(std::all_of(scene.normals.begin(), scene.normals.end(), is_unit));

        std::size_t bad_indices = 0;
        std::size_t degenerate = 0;
        std::size_t against_normal = 0;
        for (const demo::Triangle& triangle : scene.triangles) {
            const auto [a, b, c] = triangle.vertex;
            if (a >= scene.positions.size() || b >= scene.positions.size() || c >= scene.positions.size() ||
                triangle.material >= scene.materials.size()) {
                ++bad_indices;
                continue;
            }
            const glm::vec3 ab = scene.positions[b] - scene.positions[a];
            const glm::vec3 ac = scene.positions[c] - scene.positions[a];
            const glm::vec3 normal = glm::cross(ab, ac);
            degenerate += glm::length(normal) > 1e-6f * glm::dot(ab, ab) ? 0 : 1;
            against_normal += glm::dot(normal, scene.normals[a]) > 0.0f ? 0 : 1;
        }
        CHECK(bad_indices == 0);
        CHECK(degenerate == 0);
        CHECK(against_normal == 0);
    }
}

TEST_CASE("the lamps of the built-in scenes hang free") {
    for (const std::string& name : demo::built_in_scenes()) {
        CAPTURE(name);
        const demo::Scene scene = demo::load_scene(name);
        for (const demo::SceneLight& light : scene.lights) {
            CHECK(distance_to_geometry(scene, position_of(light)) > 0.04f);
        }
    }
}

TEST_CASE("spreading lights keeps their strength and is deterministic") {
    demo::Scene scene = demo::make_spheres();
    const glm::vec3 before = demo::total_strength(scene);
    demo::spread_lights(scene, 50);
    REQUIRE(scene.lights.size() == 50);
    const glm::vec3 after = demo::total_strength(scene);
    for (int channel = 0; channel < 3; ++channel) {
        CHECK(after[channel] == doctest::Approx(before[channel]).epsilon(1e-4));
    }
    demo::Scene again = demo::make_spheres();
    demo::spread_lights(again, 50);
    CHECK(fingerprint(again) == fingerprint(scene));

    demo::Scene fewer = demo::make_spheres();
    demo::spread_lights(fewer, 20);
    for (std::size_t i = 0; i < 20; ++i) {
        CHECK(position_of(fewer.lights[i]) == position_of(scene.lights[i]));
    }
}

TEST_CASE("spread lights cover the scene evenly, above its ground") {
    demo::Scene scene = demo::make_rooms();
    const demo::Bounds bounds = demo::bounds_of(scene);
    demo::spread_lights(scene, 400);
    int quarter[2][2] = {};
    for (const demo::SceneLight& light : scene.lights) {
        const glm::vec3 p = position_of(light);
        ++quarter[p.x > demo::centre_of(bounds).x ? 1 : 0][p.y > demo::centre_of(bounds).y ? 1 : 0];
        CHECK(p.z > 0.0f);
        CHECK(p.z < bounds.high.z + 0.05f * demo::diagonal_of(bounds));
    }
    for (const auto& row : quarter) {
        for (const int count : row) {
            CHECK(count >= 95);
            CHECK(count <= 105);
        }
    }
}

TEST_CASE("spread lights stay out of solids and under roofs") {
    demo::Scene scene;  // a floor, a roof, and a closed block that fills the left half up to height 3
    scene.positions = {{0, 0, 0},    {20, 0, 0},  {20, 10, 0},  {0, 10, 0},    {0, 0, 10},     {20, 0, 10},
                       {20, 10, 10}, {0, 10, 10}, {0, 0, 0.1f}, {10, 0, 0.1f}, {10, 10, 0.1f}, {0, 10, 0.1f},
                       {0, 0, 3},    {10, 0, 3},  {10, 10, 3},  {0, 10, 3}};
    scene.materials.resize(1);
    const auto facing_up = [&](std::uint32_t a) {
        scene.triangles.push_back({{a, a + 1, a + 2}, 0});
        scene.triangles.push_back({{a, a + 2, a + 3}, 0});
    };
    const auto facing_down = [&](std::uint32_t a) {
        scene.triangles.push_back({{a, a + 2, a + 1}, 0});
        scene.triangles.push_back({{a, a + 3, a + 2}, 0});
    };
    facing_up(0);
    facing_down(4);
    facing_down(8);
    facing_up(12);
    scene.lights.push_back({lightmesh::DirectionalLight{}, glm::vec3{1.0f}});
    demo::spread_lights(scene, 64);
    for (const demo::SceneLight& light : scene.lights) {
        const glm::vec3 p = position_of(light);
        CHECK(p.z > (p.x < 10.0f ? 3.0f : 0.0f));
        CHECK(p.z < 10.0f);
    }
}

TEST_CASE("lights cannot be spread over nothing, nor none of them") {
    demo::Scene empty;
    CHECK_THROWS_AS(demo::spread_lights(empty, 4), std::invalid_argument);
    demo::Scene scene = demo::make_spheres();
    CHECK_THROWS_AS(demo::spread_lights(scene, 0), std::invalid_argument);
    CHECK(scene.lights.size() == 8);
}

TEST_CASE("a name that is neither a scene nor a file is named in the error") {
    CHECK_THROWS_WITH_AS(demo::load_scene("garden"),
                         "garden: no such file, and no built-in scene of that name", std::runtime_error);
}

}  // namespace scene_test
