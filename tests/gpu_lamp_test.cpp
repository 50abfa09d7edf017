// SPDX-License-Identifier: MIT
// The shaders' rays to lamps, compiled as C++, against those of the CPU.

#include "glsl.hpp"

#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/lamp_pattern.hpp>
#include <lightmesh/cache/lamp_words.hpp>
#include <lightmesh/fill/ray_ends.hpp>
#include <lightmesh/lights.hpp>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

namespace gpu_lamp_test {

namespace {

namespace shader {

using namespace test::glsl;

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#define precise
#include <lightmesh/gpu/lamp.glsl>
#undef precise
#pragma GCC diagnostic pop

}  // namespace shader

using lightmesh::detail::Lamp;

/// Lamps and places that look at them.
class Random {
public:
    explicit Random(std::uint64_t seed) : random_(seed) {}

    std::uint64_t bits() { return random_(); }
    float number(float low, float high) {
        return low + (high - low) * static_cast<float>(random_() >> 40) * 0x1p-24f;
    }
    glm::vec3 vector() { return {number(-1.0f, 1.0f), number(-1.0f, 1.0f), number(-1.0f, 1.0f)}; }
    glm::vec3 unit() { return glm::normalize(vector() + glm::vec3(1e-6f)); }
    /// Of a magnitude, or much less in some components, or along an axis.
    glm::vec3 offset(float magnitude) {
        glm::vec3 v = magnitude * vector();
        if (random_() % 4 == 0)
            v[static_cast<int>(random_() % 3)] *= std::exp2(number(-60.0f, 0.0f));
        if (random_() % 16 == 0)
            v[static_cast<int>(random_() % 3)] = 0.0f;
        return v;
    }
    float magnitude(float low, float high) { return std::exp2(number(std::log2(low), std::log2(high))); }

private:
    std::mt19937_64 random_;
};

shader::LightMeshLamp read(const lightmesh::detail::LampWords& words) {
    const auto vector = [&](std::size_t at) {
        return glm::vec3(std::bit_cast<float>(words[at]), std::bit_cast<float>(words[at + 1]),
                         std::bit_cast<float>(words[at + 2]));
    };
    return {vector(0),
            words[3],
            vector(4),
            vector(8),
            {words[7], words[11]},
            {words[12], words[13]},
            {words[14], words[15]}};
}

struct Case {
    lightmesh::Light light;
    glm::vec3 origin;
    glm::vec3 normal;
    double step;
    double reach;
    std::uint32_t turn;
};

/// A lamp of any kind, seen from near and far, in worlds of a size, near the origin of coordinates and not.
Case random_case(Random& random, float size) {
    Case made;
    made.step = static_cast<double>(size * random.magnitude(0.001f, 0.5f));
    made.reach = made.step * (random.bits() % 4 == 0 ? 16.0 : 0x1p24);
    made.turn = static_cast<std::uint32_t>(random.bits());
    const float distance = random.bits() % 8 == 0 ? 1e6f : random.magnitude(0.01f, 100.0f);
    const glm::vec3 middle = random.bits() % 2 == 0 ? glm::vec3(0.0f) : 1e4f * size * random.vector();
    made.origin = middle + random.offset(size);
    made.normal = random.bits() % 9 == 0 ? glm::vec3(0.0f) : random.unit();
    const glm::vec3 at = random.bits() % 64 == 0 ? made.origin : middle + distance * random.offset(size);
    const float radius = random.bits() % 4 == 0 ? 0.0f : size * random.magnitude(1e-3f, 10.0f);
    switch (random.bits() % 4) {
    case 0:
        made.light = lightmesh::PointLight{.position = at, .radius = radius};
        break;
    case 1:
        made.light = lightmesh::SpotLight{.position = at, .axis = random.unit(), .radius = radius};
        break;
    case 2:
        made.light =
            lightmesh::DirectionalLight{random.offset(1.0f) + glm::vec3(0.0f, 0.0f, 1e-3f),
                                        random.bits() % 4 == 0 ? 0.0f : random.magnitude(1e-4f, 1.5f)};
        break;
    default:
        made.light = lightmesh::RectLight{.position = at,
                                          .half_u = size * random.magnitude(0.01f, 10.0f) * random.unit(),
                                          .half_v = size * random.magnitude(0.01f, 10.0f) * random.unit()};
    }
    return made;
}

struct Differences {
    int below = 0;  ///< or are points
    int rays = 0;
    int compared = 0;
    int lamps_below = 0;
};

shader::LightMeshLampTurn turn_by(std::uint32_t bits, const shader::uvec2& radius) {
    const auto words = lightmesh::detail::turn_words(bits & 1023u);
    return shader::lightmesh_lamp_turn({words[0], words[1], words[2], words[3]}, bits, radius);
}

shader::LightMeshLampPlace rim_place(const shader::LightMeshLamp& lamp, std::uint32_t i, std::uint32_t turn) {
    const bool is_square = lamp.kind == shader::lightmesh_lamp_rectangle;
    const auto place = shader::lightmesh_lamp_rim_point(i, is_square);
    return is_square ? place : shader::lightmesh_lamp_turned(place, turn_by(turn, lamp.radius));
}
shader::LightMeshLampPlace place(const shader::LightMeshLamp& lamp, std::uint32_t i, std::uint32_t turn) {
    if (lamp.kind == shader::lightmesh_lamp_rectangle)
        return shader::lightmesh_lamp_square_point(i, turn);
    return shader::lightmesh_lamp_turned(shader::lightmesh_lamp_disc_point(lightmesh::detail::disc_word(i)),
                                         turn_by(turn, lamp.radius));
}

void compare(const Case& at, Random& random, Differences& found) {
    const Lamp lamp(at.light);
    const shader::LightMeshLamp words = read(lightmesh::detail::words_of(lamp, at.reach));
    const bool is_below = lamp.is_below(at.origin, at.normal);
    found.below += shader::lightmesh_lamp_is_below(words, at.origin, at.normal) != is_below ? 1 : 0;
    found.lamps_below += is_below ? 1 : 0;
    found.below += shader::lightmesh_lamp_is_point(words) != lamp.is_point() ? 1 : 0;
    const Lamp::View expected(lamp, at.origin, at.turn, at.step, at.reach);
    const auto view = shader::lightmesh_lamp_view(
        words, at.origin, lightmesh::detail::end_offset(glm::vec3(0.0f), static_cast<float>(at.step)),
        shader::words_of(at.reach));
    const auto check = [&](const lightmesh::Segment& segment, const shader::LightMeshLampPlace& to) {
        found.rays += shader::lightmesh_lamp_target(view, to) == segment.target ? 0 : 1;
        ++found.compared;
    };
    check(expected.middle_ray(), shader::lightmesh_lamp_middle());
    if (lamp.is_point())
        return;
    const auto r = static_cast<std::uint32_t>(random.bits() % 8);
    check(expected.rim_ray(r), rim_place(words, r, at.turn));
    for (int k = 0; k < 3; ++k) {
        const auto i = static_cast<std::uint32_t>(random.bits() % (k == 0 ? 256 : 64));
        check(expected.ray(i), place(words, i, at.turn));
    }
}

}  // namespace

TEST_CASE(
    "gpu lamp: rays end where the CPU ends them to the bit and lamps are below planes where it says so") {
    Random random(20261128);
    for (const float size : {1e-12f, 1e-3f, 1.0f, 30.0f, 1e9f, 1e15f}) {
        CAPTURE(size);
        Differences found;
        for (int i = 0; i < 60'000; ++i)
            compare(random_case(random, size), random, found);
        CHECK(found.below == 0);
        CHECK(found.rays == 0);
        CHECK(found.compared > 200'000);
        CHECK(found.lamps_below > 10'000);
    }
}

TEST_CASE("gpu lamp: all places of the patterns and all turns") {
    const Lamp disc(lightmesh::PointLight{.position = {1.0f, 2.0f, 3.0f}, .radius = 0.75f});
    const Lamp square(lightmesh::RectLight{.position = {1.0f, 2.0f, 3.0f}});
    Differences found;
    Random random(5);
    const glm::vec3 origin(-0.3f, 0.2f, 0.1f);
    const double reach = 1e6;
    for (const Lamp* lamp : {&disc, &square}) {
        const shader::LightMeshLamp words = read(lightmesh::detail::words_of(*lamp, reach));
        const auto view = shader::lightmesh_lamp_view(
            words, origin, lightmesh::detail::end_offset(glm::vec3(0.0f), 0.1f), shader::words_of(reach));
        for (std::uint32_t turn = 0; turn < 4096; ++turn) {
            const std::uint32_t bits = turn | static_cast<std::uint32_t>(random.bits()) << 12;
            const Lamp::View expected(*lamp, origin, bits, static_cast<double>(0.1f), reach);
            for (std::uint32_t i = turn % 8; i < 256; i += 8)
                found.rays +=
                    shader::lightmesh_lamp_target(view, place(words, i, bits)) == expected.ray(i).target ? 0
                                                                                                         : 1;
            for (std::uint32_t i = 0; i < 8; ++i)
                found.rays += shader::lightmesh_lamp_target(view, rim_place(words, i, bits)) ==
                                      expected.rim_ray(i).target
                                  ? 0
                                  : 1;
        }
    }
    CHECK(found.rays == 0);
}

}  // namespace gpu_lamp_test
