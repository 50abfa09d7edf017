// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/light_mesh.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

// What must hold for every light mesh, whatever its numbers.

namespace properties_test {

namespace {

using lightmesh::Light;
using lightmesh::ShortTest;
using test::Triangle;
using test::Vec;

lightmesh::Settings settings_of(float radius, float quality, ShortTest short_test) {
    lightmesh::Settings settings;
    settings.radius = radius;
    settings.adaptive_long_tests = false;
    settings.quality = quality;
    settings.short_test = short_test;
    return settings;
}

glm::vec3 unit_along(int axis, float sign) {
    glm::vec3 v(0.0f);
    v[axis] = sign;
    return v;
}

/// A square of +-40 across `axis` through `middle`.
std::vector<Triangle> wall_across(int axis, const Vec& middle) {
    Vec u(0.0);
    Vec v(0.0);
    u[(axis + 1) % 3] = 80.0;
    v[(axis + 2) % 3] = 80.0;
    std::vector<Triangle> scene;
    test::add_quad(scene, middle - 0.5 * (u + v), u, v);
    return scene;
}

}  // namespace

TEST_CASE("a point in the open is fully lit") {
    std::vector<Triangle> scene;
    test::add_quad(scene, {-20, -20, 0}, {40, 0, 0}, {0, 40, 0});
    const std::vector<Light> lights{lightmesh::PointLight{{3, 4, 15}},
                                    lightmesh::DirectionalLight{{1, 0.2f, -1}},
                                    lightmesh::SpotLight{{0, 0, 12}, {0, 0, -1}, 1.4f}};
    test::Random random(1);
    for (const ShortTest short_test : test::all_short_tests) {
        const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights,
                                        settings_of(1.5f, 4.0f, short_test)};
        std::vector<float> all(lights.size());
        for (int i = 0; i < 50; ++i) {
            const glm::vec3 p(random.in_box({-9, -9, 0}, {9, 9, 0}));
            mesh.visibility(p, {0, 0, 1}, std::span<float>{all});
            for (const float s : all)
                CHECK(s == 1.0f);
        }
    }
}

TEST_CASE("a point far inside a shadow is dark") {
    std::vector<Triangle> scene;
    test::add_quad(scene, {-20, -20, 0}, {40, 0, 0}, {0, 40, 0});
    test::add_quad(scene, {-15, -15, 3}, {30, 0, 0}, {0, 30, 0});
    const std::vector<Light> lights{lightmesh::PointLight{{1, 2, 15}},
                                    lightmesh::DirectionalLight{{0.1f, 0.2f, -1}}};
    test::Random random(2);
    for (const ShortTest short_test : test::all_short_tests) {
        const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights,
                                        settings_of(1.5f, 4.0f, short_test)};
        for (int i = 0; i < 50; ++i) {
            const glm::vec3 p(random.in_box({-9, -9, 0}, {9, 9, 0}));
            for (std::size_t light = 0; light < lights.size(); ++light)
                CHECK(mesh.visibility(p, {0, 0, 1}, light) == 0.0f);
        }
    }
}

TEST_CASE("values grow steadily from shadow to light") {
    std::vector<Triangle> scene;
    test::add_quad(scene, {-20, -20, 0}, {40, 0, 0}, {0, 40, 0});
    test::add_quad(scene, {-20, -20, 5}, {20, 0, 0}, {0, 40, 0});
    const std::vector<Light> lights{lightmesh::DirectionalLight{{0, 0, -1}}};
    const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights,
                                    settings_of(2.0f, 6.0f, ShortTest::exact)};
    float before = 0.0f;
    int between = 0;
    for (int i = 0; i <= 60; ++i) {
        const float s = mesh.visibility({-3.0f + 0.1f * static_cast<float>(i), 0.3f, 0.0f}, {0, 0, 1}, 0);
        CHECK(s > before - 0.08f);  // The grid's own grain: a layer of light points enters or leaves at once.
        between += s > 0.0f && s < 1.0f;
        before = s;
    }
    CHECK(mesh.visibility({-2.01f, 0.3f, 0.0f}, {0, 0, 1}, 0) == 0.0f);
    CHECK(mesh.visibility({2.01f, 0.3f, 0.0f}, {0, 0, 1}, 0) == 1.0f);
    CHECK(mesh.visibility({0.0f, 0.3f, 0.0f}, {0, 0, 1}, 0) == doctest::Approx(0.5).epsilon(0.2));
    CHECK(between > 30);
}

TEST_CASE("exact and linked short tests let no light through a thin wall, Express does") {
    std::vector<Triangle> scene;
    test::add_quad(scene, {-20, -20, 0}, {40, 0, 0}, {0, 40, 0});
    test::add_quad(scene, {0, -20, -1}, {0, 40, 0}, {0, 0, 40});
    const std::vector<Light> lights{lightmesh::PointLight{{4, 1, 5}}};
    const lightmesh::LightMesh exact{test::PlainTracer{&scene}, lights,
                                     settings_of(1.0f, 4.0f, ShortTest::exact)};
    const lightmesh::LightMesh linked{test::PlainTracer{&scene}, lights,
                                      settings_of(1.0f, 4.0f, ShortTest::linked)};
    const lightmesh::LightMesh express{test::PlainTracer{&scene}, lights,
                                       settings_of(1.0f, 4.0f, ShortTest::none)};
    test::Random random(3);
    double leak = 0.0;
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 dark(random.in_box({-0.9, -3, 0}, {-0.01, 3, 0}));
        const glm::vec3 lit(random.in_box({0.01, -3, 0}, {0.9, 3, 0}));
        CHECK(exact.visibility(dark, {0, 0, 1}, 0) == 0.0f);
        CHECK(exact.visibility(lit, {0, 0, 1}, 0) == 1.0f);
        CHECK(linked.visibility(dark, {0, 0, 1}, 0) == 0.0f);
        CHECK(linked.visibility(lit, {0, 0, 1}, 0) == 1.0f);
        leak += static_cast<double>(express.visibility(dark, {0, 0, 1}, 0));
    }
    CHECK(leak / 100 > 0.1);
}

TEST_CASE("a closed box stays dark inside under exact and linked short tests") {
    std::vector<Triangle> scene;
    test::add_box(scene, {-2, -2, -2}, {2, 2, 2});
    const std::vector<Light> lights{lightmesh::PointLight{{5, 1, 4}},
                                    lightmesh::DirectionalLight{{0.5f, -0.3f, -1}}};
    for (const ShortTest short_test : {ShortTest::exact, ShortTest::linked}) {
        const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights,
                                        settings_of(1.0f, 3.0f, short_test)};
        test::Random random(4);
        std::vector<float> all(lights.size());
        for (const test::SurfacePoint& p : test::surface_points(random, scene, 300)) {
            const bool faces_inwards = glm::dot(p.position, p.normal) < 0.0f;
            if (!faces_inwards)
                continue;
            mesh.visibility(p.position, p.normal, std::span<float>{all});
            for (const float s : all)
                CHECK(s == 0.0f);
        }
    }
}

TEST_CASE("walls that lie on grid planes do not speckle") {
    struct Grain {
        float radius, quality;
    };
    for (const Grain& grain : {Grain{3.0f, 4.0f}, Grain{1.0f, 3.0f}, Grain{0.7f, 2.0f}}) {
        const float radius = grain.radius;
        const double step = static_cast<double>(radius) / static_cast<double>(grain.quality);
        for (const double moved : {0.0, 1e4}) {
            for (int axis = 0; axis < 3; ++axis) {
                const double plane = std::round(moved / step) * step + 3.0 * step;
                Vec middle(moved);
                middle[axis] = plane;
                const auto scene = wall_across(axis, middle);
                const glm::vec3 lamp = glm::vec3(middle) + 6.0f * unit_along(axis, 1.0f) + 1.5f;
                const std::vector<Light> lights{lightmesh::PointLight{lamp},
                                                lightmesh::DirectionalLight{lamp - glm::vec3(middle)}};
                for (const ShortTest short_test : test::all_short_tests) {
                    lightmesh::Settings settings = settings_of(radius, grain.quality, short_test);
                    settings.origin = glm::vec3(0.0f);
                    const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights, settings};
                    test::Random random(5);
                    for (int i = 0; i < 24; ++i) {
                        Vec place = middle + random.in_box(Vec(-4.0), Vec(4.0));
                        if (i % 3 == 0)
                            place = glm::round(place / step) * step;  // A light point of the wall.
                        place[axis] = plane;
                        const glm::vec3 p(place);
                        CAPTURE(radius);
                        CAPTURE(moved);
                        CAPTURE(axis);
                        CAPTURE(p.x);
                        CAPTURE(p.y);
                        CAPTURE(p.z);
                        CHECK(mesh.visibility(p, unit_along(axis, 1.0f), 0) == 1.0f);
                        CHECK(mesh.visibility(p, unit_along(axis, -1.0f), 0) == 0.0f);
                        // The sun stands behind the wall.
                        CHECK(mesh.visibility(p, unit_along(axis, 1.0f), 1) == 0.0f);
                        CHECK(mesh.visibility(p, unit_along(axis, -1.0f), 1) == 1.0f);
                    }
                }
            }
        }
    }
}

TEST_CASE("tilted walls do not speckle, near to the origin and far from it") {
    test::Random random(6);
    for (int i = 0; i < 12; ++i) {
        const Vec normal = random.direction();
        const Vec middle = (i % 2 == 0 ? 0.0 : 1e4) + random.in_box(Vec(-1.0), Vec(1.0));
        const Vec u = 60.0 * glm::normalize(glm::cross(normal, random.direction()));
        const Vec v = glm::cross(normal, u);
        std::vector<Triangle> scene;
        test::add_quad(scene, middle - 0.5 * (u + v), u, v);
        const std::vector<Light> lights{lightmesh::PointLight{glm::vec3(middle + 8.0 * normal)}};
        const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights,
                                        settings_of(3.0f, 4.0f, ShortTest::exact)};
        for (int k = 0; k < 20; ++k) {
            const Vec along = random.in_box(Vec(-0.1), Vec(0.1));
            const glm::vec3 p(middle + along.x * u + along.y * v);
            CHECK(mesh.visibility(p, glm::vec3(normal), 0) == 1.0f);
            CHECK(mesh.visibility(p, glm::vec3(-normal), 0) == 0.0f);
        }
    }
}

namespace {

/// Mean absolute difference to the exact short test.
struct ErrorInRooms {
    double linked = 0.0;
    double express = 0.0;
};

/// Over the floors and walls of rooms, for lights that face them.
ErrorInRooms error_in_rooms(float radius) {
    ErrorInRooms sum;
    int count = 0;
    for (std::uint64_t seed = 90; seed < 93; ++seed) {
        test::Random random(seed);
        const auto scene = test::thin_walls(random);
        std::vector<Light> lights;
        for (int i = 0; i < 12; ++i)
            lights.push_back(
                lightmesh::PointLight{glm::vec3(random.in_box({-4.5, -4.5, 0.5}, {4.5, 4.5, 1.9}))});
        const lightmesh::LightMesh exact{test::PlainTracer{&scene}, lights,
                                         settings_of(radius, 4.0f, ShortTest::exact)};
        const lightmesh::LightMesh linked{test::PlainTracer{&scene}, lights,
                                          settings_of(radius, 4.0f, ShortTest::linked)};
        const lightmesh::LightMesh express{test::PlainTracer{&scene}, lights,
                                           settings_of(radius, 4.0f, ShortTest::none)};
        std::vector<float> expected(lights.size());
        std::vector<float> by_links(lights.size());
        std::vector<float> without(lights.size());
        for (const test::SurfacePoint& p : test::surface_points(random, scene, 250)) {
            if (std::abs(p.position.z) == 2.0f && p.position.z * p.normal.z > 0.0f)
                continue;  // Outside.
            exact.visibility(p.position, p.normal, std::span<float>{expected});
            linked.visibility(p.position, p.normal, std::span<float>{by_links});
            express.visibility(p.position, p.normal, std::span<float>{without});
            for (std::size_t i = 0; i < expected.size(); ++i) {
                const glm::vec3 to_light = std::get<lightmesh::PointLight>(lights[i]).position - p.position;
                if (glm::dot(to_light, p.normal) < 0.0f)
                    continue;
                const auto right = static_cast<double>(expected[i]);
                sum.linked += std::abs(static_cast<double>(by_links[i]) - right);
                sum.express += std::abs(static_cast<double>(without[i]) - right);
                ++count;
            }
        }
    }
    return {sum.linked / count, sum.express / count};
}

}  // namespace

TEST_CASE("linked short tests leave a small part of Express's leaks") {
    for (const float radius : {0.5f, 1.0f}) {
        const ErrorInRooms error = error_in_rooms(radius);
        CAPTURE(radius);
        CHECK(error.express > 0.002);
        CHECK(error.linked < 0.1 * error.express);
        MESSAGE("radius " << radius << ": " << error.linked << " of " << error.express);
    }
}

namespace {

/// One scene, scaled and moved, and the values of its points.
struct Placed {
    double scale;
    Vec move;

    glm::vec3 operator()(const glm::vec3& v) const { return glm::vec3(scale * Vec(v) + move); }

    std::vector<float> values(bool grid_moves_along) const {
        test::Random random(8);
        std::vector<Triangle> scene = test::boxes_on_floor(random, 4);
        const auto points = test::surface_points(random, scene, 600);
        std::vector<Light> lights = test::random_lights(random, 6);
        for (Triangle& t : scene)
            t = {Vec((*this)(glm::vec3(t.a))), Vec((*this)(glm::vec3(t.b))), Vec((*this)(glm::vec3(t.c)))};
        for (Light& light : lights)
            std::visit([this](auto& l) { place(l); }, light);
        lightmesh::Settings settings = settings_of(static_cast<float>(scale), 4.0f, ShortTest::exact);
        if (grid_moves_along)
            settings.origin = (*this)(glm::vec3(0.125f, 0.0625f, 0.1875f));
        const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights, settings};
        std::vector<float> values;
        std::vector<float> all(lights.size());
        for (const test::SurfacePoint& p : points) {
            mesh.visibility((*this)(p.position), p.normal, std::span<float>{all});
            values.insert(values.end(), all.begin(), all.end());
        }
        return values;
    }

private:
    void place(lightmesh::DirectionalLight&) const {}
    template <class L>
    void place(L& light) const {
        light.position = (*this)(light.position);
        light.range *= static_cast<float>(scale);
    }
};

struct Difference {
    double mean = 0.0;
    double changed = 0.0;
};

Difference difference(const std::vector<float>& a, const std::vector<float>& b) {
    REQUIRE(a.size() == b.size());
    Difference result;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double d = std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i]));
        result.mean += d / static_cast<double>(a.size());
        result.changed += (d > 1e-6 ? 1.0 : 0.0) / static_cast<double>(a.size());
    }
    return result;
}

}  // namespace

TEST_CASE("a scaled or moved scene has the same values") {
    const Placed still{1.0, Vec(0.0)};
    for (const bool grid_moves_along : {true, false}) {
        const std::vector<float> expected = still.values(grid_moves_along);
        int between = 0;
        for (const float s : expected)
            between += s > 0.0f && s < 1.0f;
        CHECK(between > 30);
        for (const double scale : {1e-3, 1e3}) {
            CAPTURE(scale);
            // Only what lies within float rounding of an edge may change: about 1 value in 50, by one light
            // point.
            const Difference d = difference(expected, Placed{scale, Vec(0.0)}.values(grid_moves_along));
            CHECK(d.mean < 2e-4);
            CHECK(d.changed < 0.02);
        }
        // At 1e4 a float is a thousandth of a unit, 1/250 of the step; a grid that stays behind is another
        // grid.
        const Difference d = difference(expected, Placed{1.0, Vec(1e4, -1e4, 1e4)}.values(grid_moves_along));
        CHECK(d.mean < (grid_moves_along ? 2e-3 : 2e-2));
        CHECK(d.changed < (grid_moves_along ? 0.15 : 0.6));
    }
}

namespace {

/// As little as an adapter may have.
class OpaqueTracer {
public:
    static OpaqueTracer of(const std::vector<Triangle>& triangles) { return OpaqueTracer(&triangles); }
    OpaqueTracer() = delete;
    OpaqueTracer(const OpaqueTracer&) = default;
    OpaqueTracer& operator=(const OpaqueTracer&) = delete;
    void operator&() const = delete;
    template <class T>
    void operator,(const T&) const = delete;
    bool operator==(const OpaqueTracer&) const = delete;
    void* operator new(std::size_t) = delete;

    bool occluded(const lightmesh::Segment& segment) const {
        return test::PlainTracer{triangles_}.occluded(segment);
    }

private:
    explicit OpaqueTracer(const std::vector<Triangle>* triangles) : triangles_(triangles) {}
    const std::vector<Triangle>* triangles_;
};

struct BatchTracer {
    const std::vector<Triangle>* triangles;

    bool occluded(const lightmesh::Segment& segment) const {
        return test::PlainTracer{triangles}.occluded(segment);
    }
    void occluded(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) const {
        CHECK(segments.size() == hit.size());
        CHECK(!segments.empty());
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = occluded(segments[i]) ? 1 : 0;
    }
};

template <class Mesh>
std::vector<float> values_of(const Mesh& mesh, const std::vector<test::SurfacePoint>& points) {
    std::vector<float> values;
    std::vector<float> all(mesh.light_count());
    for (const test::SurfacePoint& p : points) {
        mesh.visibility(p.position, p.normal, std::span<float>{all});
        values.insert(values.end(), all.begin(), all.end());
    }
    return values;
}

}  // namespace

TEST_CASE("an opaque adapter with one member and an adapter with batches give the same values") {
    test::Random random(9);
    const auto scene = test::thin_walls(random);
    const auto points = test::surface_points(random, scene, 60);
    const auto lights = test::random_lights(random, 70);
    for (const ShortTest short_test : test::all_short_tests) {
        const auto settings = settings_of(0.8f, 2.0f, short_test);
        const lightmesh::LightMesh plain{test::PlainTracer{&scene}, lights, settings};
        const lightmesh::LightMesh opaque{OpaqueTracer::of(scene), lights, settings};
        const lightmesh::LightMesh batch{BatchTracer{&scene}, lights, settings};
        const std::vector<float> expected = values_of(plain, points);
        CHECK(values_of(opaque, points) == expected);
        CHECK(values_of(batch, points) == expected);
    }
}

}  // namespace properties_test
