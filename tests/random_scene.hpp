// SPDX-License-Identifier: MIT
#pragma once

#include "plain.hpp"

#include <lightmesh/lights.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

/// Scenes, surface points and lights that are random, and the same on every machine.

namespace test {

/// PCG32 (O'Neill 2014): the standard library's engines are portable, its distributions are not.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u + 0x853c49e6748fea9bu) { next(); }

    std::uint32_t next() {
        const std::uint64_t old = state_;
        state_ = old * 6364136223846793005u + 1442695040888963407u;
        const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
        const auto turn = static_cast<std::uint32_t>(old >> 59);
        return (shifted >> turn) | (shifted << ((32 - turn) & 31));
    }
    /// In [low, high).
    double uniform(double low, double high) { return low + (high - low) * (next() * 0x1p-32); }
    std::size_t below(std::size_t count) { return next() % count; }
    Vec in_box(const Vec& low, const Vec& high) {
        const double x = uniform(low.x, high.x);
        const double y = uniform(low.y, high.y);
        const double z = uniform(low.z, high.z);
        return {x, y, z};
    }
    Vec direction() {
        for (;;) {
            const Vec v = in_box(Vec(-1.0), Vec(1.0));
            const double length = glm::length(v);
            if (length > 0.1 && length < 1.0)
                return v / length;
        }
    }
    template <class T>
    void shuffle(std::vector<T>& values) {
        for (std::size_t i = values.size(); i > 1; --i)
            std::swap(values[i - 1], values[below(i)]);
    }

private:
    std::uint64_t state_;
};

/// A point of a surface, as a renderer would hand it to the mesh.
struct SurfacePoint {
    glm::vec3 position;
    glm::vec3 normal;
};

/// Corners are rounded to float, so that points of a triangle lie on it as well as floats can.
inline Triangle rounded(const Vec& a, const Vec& b, const Vec& c) {
    return {Vec(glm::vec3(a)), Vec(glm::vec3(b)), Vec(glm::vec3(c))};
}

/// A parallelogram with the corners corner, corner + u, corner + v, corner + u + v.
inline void add_quad(std::vector<Triangle>& scene, const Vec& corner, const Vec& u, const Vec& v) {
    scene.push_back(rounded(corner, corner + u, corner + u + v));
    scene.push_back(rounded(corner, corner + u + v, corner + v));
}

inline void add_box(std::vector<Triangle>& scene, const Vec& low, const Vec& high) {
    const Vec x(high.x - low.x, 0.0, 0.0);
    const Vec y(0.0, high.y - low.y, 0.0);
    const Vec z(0.0, 0.0, high.z - low.z);
    add_quad(scene, low, x, y);
    add_quad(scene, low + z, x, y);
    add_quad(scene, low, x, z);
    add_quad(scene, low + y, x, z);
    add_quad(scene, low, y, z);
    add_quad(scene, low + x, y, z);
}

/// All scenes fit into a cube of +-`scene_size`.
constexpr double scene_size = 5.0;

/// Loose triangles in all directions, like leaves.
inline std::vector<Triangle> triangle_soup(Random& random, int count) {
    std::vector<Triangle> scene;
    for (int i = 0; i < count; ++i) {
        const Vec middle = random.in_box(Vec(-4.0), Vec(4.0));
        const double size = random.uniform(0.5, 2.0);
        const Vec a = middle + size * random.direction();
        const Vec b = middle + size * random.direction();
        const Vec c = middle + size * random.direction();
        if (glm::length(glm::cross(b - a, c - a)) > 0.05)
            scene.push_back(rounded(a, b, c));
    }
    return scene;
}

/// Boxes that stand on a floor.
inline std::vector<Triangle> boxes_on_floor(Random& random, int count) {
    std::vector<Triangle> scene;
    add_quad(scene, {-scene_size, -scene_size, -3.0}, {2.0 * scene_size, 0.0, 0.0},
             {0.0, 2.0 * scene_size, 0.0});
    for (int i = 0; i < count; ++i) {
        const Vec low = random.in_box({-4.0, -4.0, -3.0}, {3.0, 3.0, -3.0});
        add_box(scene, low, low + random.in_box({0.3, 0.3, 0.5}, {1.5, 1.5, 4.0}));
    }
    return scene;
}

/// Rooms between walls without thickness, each wall with a gap.
inline std::vector<Triangle> thin_walls(Random& random) {
    std::vector<Triangle> scene;
    const double side = 2.0 * scene_size;
    add_quad(scene, {-scene_size, -scene_size, -2.0}, {side, 0.0, 0.0}, {0.0, side, 0.0});
    add_quad(scene, {-scene_size, -scene_size, 2.0}, {side, 0.0, 0.0}, {0.0, side, 0.0});
    for (int i = 0; i < 3; ++i) {
        const double at = -3.0 + 3.0 * i + random.uniform(-0.5, 0.5);
        const double gap = random.uniform(-3.0, 2.0);
        add_quad(scene, {at, -scene_size, -2.0}, {0.0, gap + scene_size, 0.0}, {0.0, 0.0, 4.0});
        add_quad(scene, {at, gap + 1.0, -2.0}, {0.0, scene_size - gap - 1.0, 0.0}, {0.0, 0.0, 4.0});
        const double across = -3.0 + 3.0 * i + random.uniform(-0.5, 0.5);
        add_quad(scene, {-scene_size, across, -2.0}, {gap + scene_size, 0.0, 0.0}, {0.0, 0.0, 4.0});
        add_quad(scene, {gap + 1.0, across, -2.0}, {scene_size - gap - 1.0, 0.0, 0.0}, {0.0, 0.0, 4.0});
    }
    return scene;
}

/// Points on either side of random triangles, with their geometric normals.
inline std::vector<SurfacePoint> surface_points(Random& random, const std::vector<Triangle>& scene,
                                                int count) {
    std::vector<SurfacePoint> points;
    for (int i = 0; i < count; ++i) {
        const Triangle& t = scene[random.below(scene.size())];
        double u = random.uniform(0.0, 1.0);
        double v = random.uniform(0.0, 1.0);
        if (u + v > 1.0) {
            u = 1.0 - u;
            v = 1.0 - v;
        }
        const Vec normal = glm::normalize(glm::cross(t.b - t.a, t.c - t.a));
        const double side = random.below(2) == 0 ? 1.0 : -1.0;
        points.push_back({glm::vec3(t.a + u * (t.b - t.a) + v * (t.c - t.a)), glm::vec3(side * normal)});
    }
    return points;
}

/// Lights of all types in turn, half of the point and spot lights with a range.
inline std::vector<lightmesh::Light> random_lights(Random& random, int count) {
    std::vector<lightmesh::Light> lights;
    for (int i = 0; i < count; ++i) {
        const glm::vec3 position(random.in_box(Vec(-scene_size), Vec(scene_size)));
        const double length = random.uniform(0.5, 2.0);
        const glm::vec3 direction(length * random.direction());
        const float range = static_cast<float>(random.uniform(4.0, 12.0));
        const float cone = static_cast<float>(random.uniform(0.6, 3.0));
        lightmesh::PointLight lamp{position};
        lightmesh::SpotLight spot{position, direction, cone};
        if (random.below(2) == 0)
            lamp.range = spot.range = range;
        if (i % 3 == 0)
            lights.push_back(lamp);
        if (i % 3 == 1)
            lights.push_back(lightmesh::DirectionalLight{direction});
        if (i % 3 == 2)
            lights.push_back(spot);
    }
    return lights;
}

}  // namespace test
