// SPDX-License-Identifier: MIT

// The C interface of the Blender add-on's core, without Blender.

#include "blender/core/light_mesh_core.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace blender_core_test {

namespace {

struct Free {
    void operator()(LmSession* session) const { lm_free(session); }
};
using Session = std::unique_ptr<LmSession, Free>;

/// A square in the plane z = 0, or what is made of it.
struct Square {
    std::vector<float> positions;
    std::vector<std::int32_t> corners{0, 1, 2, 0, 2, 3};
    std::vector<std::int32_t> slots{0, 0};
    std::vector<float> uvs{0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1};

    explicit Square(float half) : positions{-half, -half, 0, half, -half, 0, half, half, 0, -half, half, 0} {}

    LmMesh mesh() const {
        LmMesh made{};
        made.name = "square";
        made.positions = positions.data();
        made.corners = corners.data();
        made.slots = slots.data();
        made.uvs = uvs.data();
        made.vertex_count = 4;
        made.triangle_count = 2;
        return made;
    }
    std::uint64_t hash() const { return lm_hash(1, positions.data(), positions.size() * sizeof(float)); }
};

constexpr std::array<double, 12> at(double x, double y, double z, double scale = 1.0) {
    return {scale, 0, 0, x, 0, scale, 0, y, 0, 0, scale, z};
}

LmMaterial matt(float albedo) {
    LmMaterial material{};
    for (float& channel : material.base)
        channel = albedo;
    material.alpha = material.refraction_index = 1.0f;
    material.base_image = -1;
    material.is_matt = 1;
    return material;
}

LmLight lamp(float x, float y, float z, float strength, LmShadow shadow = LM_HARD_RAYS) {
    LmLight light{};
    light.name = "lamp";
    light.kind = LM_POINT;
    light.shadow = shadow;
    light.position[0] = x;
    light.position[1] = y;
    light.position[2] = z;
    light.axis[2] = -1.0f;
    for (float& channel : light.strength)
        channel = strength;
    light.spacing = 0.25f;
    light.detail = 3;
    light.radius = 0.5f;
    light.quality = 4.0f;
    light.map_size = 256;
    return light;
}

/// From above, orthographic, of 4 x 4 metres: +x to the right, +y up.
LmView from_above(int width, int height) {
    LmView view{};
    view.eye[2] = 10.0f;
    view.ahead[2] = -1.0f;
    view.up[1] = 1.0f;
    const std::array<float, 4> edges{-2, 2, -2, 2};
    std::copy(edges.begin(), edges.end(), view.edges);
    view.z_far = 100.0f;
    view.is_orthographic = 1;
    view.width = width;
    view.height = height;
    view.samples = 1;
    view.ambient_distance = 100.0f;
    return view;
}

/// A floor, and a plate above it where there is one.
void tell(LmSession* session, const std::vector<LmLight>& lights, const double* plate = nullptr) {
    REQUIRE(lm_begin(session) == 0);
    const LmMaterial grey = matt(0.5f);
    const std::int32_t material = lm_add_material(session, &grey);
    REQUIRE(material == 0);
    const Square floor(10.0f);
    const LmMesh mesh = floor.mesh();
    std::int32_t number = lm_find_mesh(session, floor.hash());
    if (number < 0)
        number = lm_add_mesh(session, floor.hash(), &mesh);
    REQUIRE(number == 0);
    const auto origin = at(0, 0, 0);
    REQUIRE(lm_add_object(session, number, origin.data(), &material, 1) == 0);
    if (plate != nullptr)
        REQUIRE(lm_add_object(session, number, plate, &material, 1) == 0);
    for (const LmLight& light : lights)
        REQUIRE(lm_add_light(session, &light) == 0);
    REQUIRE_MESSAGE(lm_commit(session) == 0, lm_error());
}

std::vector<float> picture(LmSession* session, const LmView& view) {
    REQUIRE_MESSAGE(lm_render(session, &view) == 0, lm_error());
    int state = LM_RUNNING;
    float progress = 0.0f;
    while (state == LM_RUNNING)
        state = lm_poll(session, 0.1, &progress);
    REQUIRE_MESSAGE(state == LM_FINISHED, lm_error());
    CHECK(progress == 1.0f);
    std::vector<float> pixels(4 * static_cast<std::size_t>(view.width * view.height));
    REQUIRE(lm_read(session, pixels.data(), pixels.size()) == 0);
    return pixels;
}

bool fails(int result, const std::string& with) {
    return result == -1 && std::string(lm_error()).find(with) != std::string::npos;
}

}  // namespace

TEST_CASE("blender core: inverse squares, and rows from the bottom up") {
    CHECK(lm_abi() == LM_ABI);
    const Session session(lm_new(0));
    tell(session.get(), {lamp(1, -1, 2, 8.0f)});
    const std::vector<float> pixels = picture(session.get(), from_above(4, 4));
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column) {
            const double x = -1.5 + column - 1.0;
            const double y = -1.5 + row + 1.0;
            const double squared = x * x + y * y + 4.0;
            const float* pixel = &pixels[static_cast<std::size_t>(4 * (4 * row + column))];
            CHECK(pixel[0] == doctest::Approx(0.5 * 8.0 / squared * 2.0 / std::sqrt(squared)).epsilon(1e-4));
            CHECK(pixel[3] == 1.0f);
        }
}

TEST_CASE("blender core: a rectangle lights a point as all of its pieces do") {
    const Session session(lm_new(0));
    LmLight area = lamp(0, 0, 1, 1.0f);
    area.kind = LM_AREA;
    area.half_u[0] = 1.0f;
    area.half_v[1] = -0.5f;  // it shines down
    tell(session.get(), {area});
    LmView view = from_above(1, 1);
    view.eye[0] = 0.4f;
    double sum = 0.0;
    constexpr int steps = 200;
    for (int i = 0; i < steps; ++i)
        for (int k = 0; k < steps; ++k) {
            const double x = -1.0 + 2.0 * (i + 0.5) / steps - 0.4;
            const double y = -0.5 + (k + 0.5) / steps;
            const double squared = x * x + y * y + 1.0;
            sum += 1.0 / (squared * squared) / (steps * steps);
        }
    CHECK(picture(session.get(), view)[0] == doctest::Approx(0.5 * sum).epsilon(1e-3));
}

TEST_CASE("blender core: each kind of shadow is dark below a plate, and without shadow there is none") {
    const auto plate = at(0, 0, 1, 0.1);
    for (const LmShadow shadow : {LM_REAL_LAMP, LM_MESH, LM_MESH_ATK, LM_HARD_RAYS, LM_NO_SHADOW}) {
        const Session session(lm_new(0));
        LmLight light = lamp(0, 0, 6, 40.0f, shadow);
        light.size = 0.2f;
        tell(session.get(), {light}, plate.data());
        // From below the plate.
        LmView view = from_above(1, 1);
        view.eye[2] = 0.5f;
        view.edges[0] = view.edges[2] = -0.01f;
        view.edges[1] = view.edges[3] = 0.01f;
        const float dark = picture(session.get(), view)[0];
        CAPTURE(static_cast<int>(shadow));
        if (shadow == LM_NO_SHADOW)
            CHECK(dark > 0.5f);
        else
            CHECK(dark == 0.0f);
        LmStatistics statistics{};
        REQUIRE(lm_statistics(session.get(), &statistics) == 0);
        CHECK(statistics.groups == (shadow == LM_NO_SHADOW ? 0 : 1));
        CHECK(statistics.triangles == 4);
    }
}

TEST_CASE("blender core: each distinct setting is one mesh, and keeps its own lights") {
    const Session session(lm_new(0));
    std::vector<LmLight> lights{lamp(-1, 0, 3, 1.0f, LM_MESH), lamp(0, 0, 3, 1.0f),
                                lamp(1, 0, 3, 1.0f, LM_MESH), lamp(0, 1, 3, 1.0f, LM_MESH)};
    lights[3].radius = 1.0f;
    tell(session.get(), lights);
    LmStatistics statistics{};
    REQUIRE(lm_statistics(session.get(), &statistics) == 0);
    CHECK(statistics.groups == 3);  // two radii, and hard rays
    const std::vector<float> apart = picture(session.get(), from_above(8, 8));
    for (LmLight& light : lights)
        light.shadow = LM_NO_SHADOW;
    tell(session.get(), lights);
    const std::vector<float> open = picture(session.get(), from_above(8, 8));
    for (std::size_t i = 0; i < open.size(); ++i)
        CHECK(apart[i] == doctest::Approx(open[i]).epsilon(1e-4));
}

TEST_CASE("blender core: a film's frames are those of new sessions, and what is the same is kept") {
    const Session film(lm_new(0));
    for (int frame = 0; frame < 4; ++frame) {
        // A plate that moves, then a light, then nothing.
        const auto plate = at(frame == 0 ? -0.5 : 0.5, 0, 1, 0.05);
        LmLight light = lamp(frame < 2 ? 0.0f : 0.7f, 0, 4, 20.0f, LM_REAL_LAMP);
        light.size = 0.3f;
        const std::vector<LmLight> lights{light, lamp(1, 1, 4, 5.0f, LM_MESH)};
        tell(film.get(), lights, plate.data());
        LmStatistics statistics{};
        REQUIRE(lm_statistics(film.get(), &statistics) == 0);
        CHECK(statistics.is_new_scene == (frame == 0 ? 1 : 0));
        CHECK(statistics.groups_kept == (frame == 0 ? 0 : 2));
        CHECK((statistics.moved_boxes > 0) == (frame == 1));
        const std::vector<float> ours = picture(film.get(), from_above(24, 24));
        const Session fresh(lm_new(0));
        tell(fresh.get(), lights, plate.data());
        CHECK(picture(fresh.get(), from_above(24, 24)) == ours);
    }
}

TEST_CASE("blender core: the background may be left out, also behind what lets light through") {
    const Session session(lm_new(0));
    REQUIRE(lm_begin(session.get()) == 0);
    LmMaterial half = matt(0.5f);
    half.alpha = 0.25f;
    const std::int32_t material = lm_add_material(session.get(), &half);
    const Square square(1.0f);
    const LmMesh mesh = square.mesh();
    const std::int32_t number = lm_add_mesh(session.get(), square.hash(), &mesh);
    const auto origin = at(0, 0, 0);
    REQUIRE(lm_add_object(session.get(), number, origin.data(), &material, 1) == 0);
    REQUIRE_MESSAGE(lm_commit(session.get()) == 0, lm_error());
    LmView view = from_above(2, 1);
    view.edges[0] = -1.0f;
    view.edges[1] = 3.0f;  // the left pixel on the square, the right one beside it
    view.bounces = 2;
    view.background[0] = 2.0f;
    const std::vector<float> before = picture(session.get(), view);
    CHECK(before[0] == doctest::Approx(1.5));
    CHECK(before[4] == 2.0f);
    view.is_transparent = 1;
    const std::vector<float> after = picture(session.get(), view);
    CHECK(after[0] == 0.0f);
    CHECK(after[3] == doctest::Approx(0.25));
    CHECK(after[7] == 0.0f);
}

TEST_CASE("blender core: pictures are blended as they are stored, rows from the bottom up") {
    const Session session(lm_new(0));
    REQUIRE(lm_begin(session.get()) == 0);
    const std::array<std::uint8_t, 8> texels{0, 0, 0, 255, 255, 255, 255, 255};  // dark below, light above
    REQUIRE(lm_add_image(session.get(), 1, 1, 2, texels.data(), LM_IMAGE_CLAMP) == 0);
    LmMaterial textured = matt(1.0f);
    textured.base_image = 0;
    const std::int32_t material = lm_add_material(session.get(), &textured);
    const Square square(2.0f);
    const LmMesh mesh = square.mesh();
    const std::int32_t number = lm_add_mesh(session.get(), square.hash(), &mesh);
    const auto origin = at(0, 0, 0);
    REQUIRE(lm_add_object(session.get(), number, origin.data(), &material, 1) == 0);
    REQUIRE_MESSAGE(lm_commit(session.get()) == 0, lm_error());
    LmView view = from_above(1, 5);
    for (float& channel : view.ambient)
        channel = 1.0f;
    const std::vector<float> pixels = picture(session.get(), view);
    CHECK(pixels[0] == 0.0f);
    CHECK(pixels[16] == 1.0f);
    const double half = std::pow((0.5 + 0.055) / 1.055, 2.4);
    CHECK(pixels[8] == doctest::Approx(half).epsilon(1e-3));
}

TEST_CASE("blender core: an image is told once as long as frames have it") {
    const Session session(lm_new(0));
    const Square square(2.0f);
    const LmMesh mesh = square.mesh();
    const auto origin = at(0, 0, 0);
    LmView view = from_above(4, 4);
    view.ambient[0] = 1.0f;
    // With images of these keys, the last of which is seen: its colour.
    const auto seen = [&](const std::vector<std::uint64_t>& keys, bool are_known) {
        REQUIRE(lm_begin(session.get()) == 0);
        LmMaterial textured = matt(1.0f);
        for (const std::uint64_t key : keys) {
            textured.base_image = lm_find_image(session.get(), key);
            CHECK((textured.base_image >= 0) == are_known);
            const std::array<std::uint8_t, 4> texel{static_cast<std::uint8_t>(key), 0, 0, 255};
            if (textured.base_image < 0)
                textured.base_image = lm_add_image(session.get(), key, 1, 1, texel.data(), LM_IMAGE_LINEAR);
            CHECK(lm_find_image(session.get(), key) == textured.base_image);
        }
        const std::int32_t material = lm_add_material(session.get(), &textured);
        REQUIRE_MESSAGE(material >= 0, lm_error());
        const std::int32_t number = lm_add_mesh(session.get(), square.hash(), &mesh);
        REQUIRE(lm_add_object(session.get(), number, origin.data(), &material, 1) == 0);
        REQUIRE_MESSAGE(lm_commit(session.get()) == 0, lm_error());
        return 255.0f * picture(session.get(), view)[0];
    };
    CHECK(seen({51, 102}, false) == doctest::Approx(102));
    CHECK(seen({51, 102}, true) == doctest::Approx(102));
    CHECK(seen({102, 51}, true) == doctest::Approx(51));
    REQUIRE(lm_begin(session.get()) == 0);  // a frame that is given up
    CHECK(lm_find_image(session.get(), 102) == 0);
    CHECK(seen({102}, true) == doctest::Approx(102));
    CHECK(seen({51}, false) == doctest::Approx(51));
}

TEST_CASE("blender core: a rough surface reflects as its facets do") {
    const Session session(lm_new(0));
    REQUIRE(lm_begin(session.get()) == 0);
    LmMaterial metal = matt(0.9f);
    metal.is_matt = 0;
    metal.metallic = 1.0f;
    metal.roughness = 0.5f;
    const std::int32_t material = lm_add_material(session.get(), &metal);
    const Square square(2.0f);
    const LmMesh mesh = square.mesh();
    const std::int32_t number = lm_add_mesh(session.get(), square.hash(), &mesh);
    const auto origin = at(0, 0, 0);
    REQUIRE(lm_add_object(session.get(), number, origin.data(), &material, 1) == 0);
    const LmLight light = lamp(0, 0, 2, 4.0f);
    REQUIRE(lm_add_light(session.get(), &light) == 0);
    REQUIRE_MESSAGE(lm_commit(session.get()) == 0, lm_error());
    // Head-on, D is 1 / (pi a^2), masking 1 and the reflectance the colour: D / 4 times pi.
    LmView view = from_above(1, 1);
    view.edges[0] = view.edges[2] = -1e-3f;
    view.edges[1] = view.edges[3] = 1e-3f;
    const double width = 0.25;
    CHECK(picture(session.get(), view)[0] == doctest::Approx(0.9 / (4.0 * width * width)).epsilon(1e-3));
}

TEST_CASE("blender core: ambient light is less where things are near") {
    const Session session(lm_new(0));
    const auto plate = at(0, 0, 0.05, 0.05);
    tell(session.get(), {}, plate.data());
    LmView view = from_above(1, 1);
    for (float& channel : view.ambient)
        channel = 1.0f;
    view.ambient_rays = 64;
    view.edges[0] = view.edges[2] = -1e-3f;
    view.edges[1] = view.edges[3] = 1e-3f;
    CHECK(picture(session.get(), view)[0] == doctest::Approx(0.5));  // on the plate
    view.eye[2] = 0.04f;
    // Under it, only what comes in flatter than from its edge: nothing to a hundredth.
    CHECK(picture(session.get(), view)[0] < 0.05f);
}

TEST_CASE("blender core: what is baked is what a matt picture shows") {
    const Session session(lm_new(0));
    const auto plate = at(0, 0, 1, 0.1);
    const std::vector<LmLight> lights{lamp(0, 0, 4, 8.0f), lamp(6, 0, 4, 2.0f)};
    tell(session.get(), lights, plate.data());
    const std::array<float, 9> places{0, 0, 0, 2, 1, 0, -3, 0, 0};
    const std::array<float, 9> normals{0, 0, 1, 0, 0, 1, 0, 0, 1};
    std::array<float, 6> visible{};
    std::array<float, 9> colours{};
    LmPoints points{places.data(), normals.data(), nullptr, 3};
    REQUIRE(lm_bake(session.get(), &points, visible.data(), colours.data()) == 0);
    // The plate hides the first lamp from below it, and the second one from the far side.
    CHECK(visible == std::array<float, 6>{0, 1, 1, 1, 1, 0});
    for (std::size_t i = 0; i < 3; ++i) {
        double expected = 0.0;
        for (std::size_t l = 0; l < 2; ++l) {
            const double x = lights[l].position[0] - places[3 * i];
            const double y = lights[l].position[1] - places[3 * i + 1];
            const double squared = x * x + y * y + 16.0;
            expected += visible[2 * i + l] * lights[l].strength[0] / squared * 4.0 / std::sqrt(squared);
        }
        CHECK(colours[3 * i] == doctest::Approx(expected).epsilon(1e-4));
    }
    CHECK(lm_bake(session.get(), &points, nullptr, nullptr) == 0);
    // The normal of smooth shading is the one that is lit.
    const std::array<float, 9> turned{0, 0.6f, 0.8f, 0, 0.6f, 0.8f, 0, 0.6f, 0.8f};
    points.shading_normals = turned.data();
    std::array<float, 9> smooth{};
    REQUIRE(lm_bake(session.get(), &points, nullptr, smooth.data()) == 0);
    const double squared = 36.0 + 16.0;  // the plate hides the other lamp
    CHECK(smooth[0] == doctest::Approx(2.0 / squared * 0.8 * 4.0 / std::sqrt(squared)).epsilon(1e-4));
    points.positions = nullptr;
    CHECK(fails(lm_bake(session.get(), &points, nullptr, nullptr), "positions"));
    CHECK(fails(lm_bake(session.get(), nullptr, nullptr, nullptr), "points is NULL"));
    const Session empty(lm_new(0));
    points.count = 0;
    CHECK(fails(lm_bake(empty.get(), &points, nullptr, nullptr), "no scene to bake"));
}

TEST_CASE("blender core: each texel shows the triangle of its middle, else the nearest place it touches") {
    constexpr int width = 40;
    constexpr int height = 24;
    constexpr std::size_t texels = width * height;
    // A fan around a corner that is a texel's middle, so that all its edges meet there, a needle beside it
    // that has few middles, and three triangles that show nowhere.
    const float x = 12.5f / width;
    const float y = 10.5f / height;
    const float infinity = std::numeric_limits<float>::infinity();
    const std::vector<float> uvs{x,     y,      0.05f,   0.1f,    0.55f,  0.1f,  x,        y,     0.55f, 0.1f,
                                 0.5f,  0.9f,   x,       y,       0.5f,   0.9f,  0.05f,    0.85f, x,     y,
                                 0.05f, 0.1f,   0.05f,   0.85f,   0.65f,  0.05f, 0.68f,    0.05f, 0.99f, 1.2f,
                                 0.75f, 0.125f, 0.8125f, 0.1875f, 0.875f, 0.25f, 2.0f,     2.0f,  3.0f,  2.0f,
                                 3.0f,  3.0f,   0.9f,    0.1f,    0.95f,  0.1f,  infinity, 0.2f};
    const std::size_t count = uvs.size() / 6;
    const auto corner = [&](std::size_t triangle, std::size_t k) {
        const float* uv = &uvs[6 * triangle + 2 * k];
        return std::array<double, 2>{uv[0] * double{width}, uv[1] * double{height}};
    };
    std::vector<std::int32_t> found(texels);
    std::vector<std::int32_t> others(texels);
    std::vector<float> weights(2 * texels);
    REQUIRE(lm_cover_texels(width, height, static_cast<std::uint32_t>(count), uvs.data(), found.data(),
                            weights.data(), others.data()) == 0);
    CHECK(std::ranges::all_of(others, [](std::int32_t other) { return other == -1; }));
    // Plainly: the least distance of 60 x 60 places on each triangle from each texel's middle.
    for (std::size_t texel = 0; texel < texels; ++texel) {
        CAPTURE(texel);
        const double middle_x = static_cast<double>(texel % width) + 0.5;
        const double middle_y = static_cast<double>(texel / width) + 0.5;
        bool is_touched = false;
        double least = infinity;
        for (std::size_t t = 0; t < 5; ++t)
            for (int i = 0; i <= 60; ++i)
                for (int j = 0; j <= 60 - i; ++j) {
                    double away[2];
                    for (std::size_t axis = 0; axis < 2; ++axis)
                        away[axis] = (60 - i - j) / 60.0 * corner(t, 0)[axis] +
                                     i / 60.0 * corner(t, 1)[axis] + j / 60.0 * corner(t, 2)[axis] -
                                     (axis == 0 ? middle_x : middle_y);
                    least = (std::min)(least, std::hypot(away[0], away[1]));
                    is_touched = is_touched || (std::abs(away[0]) < 0.49 && std::abs(away[1]) < 0.49);
                }
        if (found[texel] < 0) {
            CHECK_FALSE(is_touched);
            continue;
        }
        REQUIRE(found[texel] < 5);
        const auto t = static_cast<std::size_t>(found[texel]);
        const double u = weights[2 * texel];
        const double v = weights[2 * texel + 1];
        CHECK(u >= 0.0);
        CHECK(v >= 0.0);
        CHECK(u + v <= 1.0 + 1e-6);
        const double at_x = (1.0 - u - v) * corner(t, 0)[0] + u * corner(t, 1)[0] + v * corner(t, 2)[0];
        const double at_y = (1.0 - u - v) * corner(t, 0)[1] + u * corner(t, 1)[1] + v * corner(t, 2)[1];
        const double distance = std::hypot(at_x - middle_x, at_y - middle_y);
        CHECK(distance <= (std::min)(least, std::sqrt(0.5)) + 0.25 + 1e-5);
        CHECK(distance >= least - 0.5);  // the plain places lie so far apart
    }
    // Of two triangles with the same middle the first is shown, and the second told.
    const std::array<float, 12> twice{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    std::array<std::int32_t, 4> first{};
    std::array<std::int32_t, 4> second{};
    std::array<float, 8> places{};
    REQUIRE(lm_cover_texels(2, 2, 2, twice.data(), first.data(), places.data(), second.data()) == 0);
    // The diagonal goes through two middles, and belongs to what lies to its right.
    CHECK(first == std::array<std::int32_t, 4>{0, 0, 0, 0});
    CHECK(second == std::array<std::int32_t, 4>{1, -1, -1, -1});
    CHECK(
        fails(lm_cover_texels(0, 2, 0, nullptr, first.data(), places.data(), second.data()), "0 x 2 texels"));
    CHECK(
        fails(lm_cover_texels(2, 2, 1, nullptr, first.data(), places.data(), second.data()), "coordinates"));
}

TEST_CASE("blender core: a margin goes on with what is beside it, as far as it is wide") {
    constexpr int width = 9;
    constexpr int height = 7;
    std::vector<float> values(2 * width * height, 100.0f);
    std::vector<std::uint8_t> filled(width * height);
    const auto texel = [](int column, int row) {
        return static_cast<std::size_t>(width * row + column);
    };
    // Two texels, with a value of the column.
    for (const int column : {2, 3}) {
        filled[texel(column, 3)] = 1;
        values[2 * texel(column, 3)] = static_cast<float>(column);
        values[2 * texel(column, 3) + 1] = 1.0f;
    }
    REQUIRE(lm_fill_margin(width, height, 2, values.data(), filled.data(), 2) == 0);
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            const int steps = (std::max)({2 - column, column - 3, std::abs(row - 3)});
            CAPTURE(row);
            CAPTURE(column);
            CHECK(filled[texel(column, row)] == (steps <= 2 ? 1 : 0));
            CHECK(values[2 * texel(column, row) + 1] == (steps <= 2 ? 1.0f : 100.0f));
        }
    // Above the first one: twice that below, once that across.
    CHECK(values[2 * texel(2, 4)] == doctest::Approx((2.0 * 2.0 + 3.0) / 3.0));
    CHECK(values[2 * texel(1, 4)] == 2.0f);
    CHECK(values[2 * texel(5, 3)] == 3.0f);
    CHECK(fails(lm_fill_margin(width, height, 0, values.data(), filled.data(), 2), "0 channels"));
}

/// A ball of `steps` x `steps` quads with smooth normals.
struct Ball {
    std::vector<float> positions;
    std::vector<std::int32_t> corners;
    std::vector<std::int32_t> slots;
    std::vector<float> normals;
    std::vector<float> uvs;

    explicit Ball(int steps) {
        const double pi = 3.14159265358979;
        for (int row = 0; row <= steps; ++row)
            for (int column = 0; column < steps; ++column) {
                const double polar = pi * row / steps;
                const double around = 2.0 * pi * column / steps;
                for (const double value : {std::sin(polar) * std::cos(around),
                                           std::sin(polar) * std::sin(around), std::cos(polar)})
                    positions.push_back(static_cast<float>(value));
            }
        for (int row = 0; row < steps; ++row)
            for (int column = 0; column < steps; ++column) {
                const int a = row * steps + column;
                const int b = row * steps + (column + 1) % steps;
                for (const auto& triangle :
                     {std::array{a, a + steps, b + steps}, std::array{a, b + steps, b}}) {
                    corners.insert(corners.end(), triangle.begin(), triangle.end());
                    slots.push_back(0);
                    for (const int vertex : triangle) {
                        const auto at = positions.begin() + 3 * vertex;
                        normals.insert(normals.end(), at, at + 3);
                        uvs.push_back(static_cast<float>(column) / static_cast<float>(steps));
                        uvs.push_back(static_cast<float>(row) / static_cast<float>(steps));
                    }
                }
            }
    }

    LmMesh mesh() const {
        LmMesh made{};
        made.name = "ball";
        made.positions = positions.data();
        made.corners = corners.data();
        made.slots = slots.data();
        made.normals = normals.data();
        made.uvs = uvs.data();
        made.vertex_count = static_cast<std::uint32_t>(positions.size() / 3);
        made.triangle_count = static_cast<std::uint32_t>(slots.size());
        return made;
    }
};

TEST_CASE("blender core: normals of vertices are those of all their corners") {
    const Ball ball(24);
    LmMesh mesh = ball.mesh();
    const LmMaterial grey = matt(0.8f);
    const auto origin = at(0, 0, 0);
    const auto drawn = [&] {
        const Session session(lm_new(0));
        REQUIRE(lm_begin(session.get()) == 0);
        const std::int32_t material = lm_add_material(session.get(), &grey);
        const std::int32_t number = lm_add_mesh(session.get(), 1, &mesh);
        REQUIRE(lm_add_object(session.get(), number, origin.data(), &material, 1) == 0);
        const LmLight light = lamp(2, -2, 4, 8.0f, LM_NO_SHADOW);
        REQUIRE(lm_add_light(session.get(), &light) == 0);
        REQUIRE(lm_commit(session.get()) == 0);
        return picture(session.get(), from_above(32, 32));
    };
    const std::vector<float> by_corner = drawn();
    mesh.normals = nullptr;
    const std::vector<float> facets = drawn();
    mesh.vertex_normals = ball.positions.data();  // of a ball of radius 1 around 0
    CHECK(drawn() == by_corner);
    mesh.uvs = nullptr;
    CHECK(drawn() == by_corner);
    CHECK(facets != by_corner);
}

TEST_CASE("blender core: instances are drawn as copies are, and take the place of one") {
    const Ball ball(24);
    const LmMesh mesh = ball.mesh();
    const Square floor(10.0f);
    const LmMesh ground = floor.mesh();
    // Turned, stretched, a mirror image.
    std::array<std::array<double, 12>, 3> places{at(-0.9, 0.8, 0.5, 0.4), at(0.9, 0.2, 0.6, 0.4),
                                                 at(0.0, -0.9, 0.4, 0.3)};
    places[1] = {0.3, -0.2, 0, 0.9, 0.25, 0.35, 0, 0.2, 0, 0.1, 0.5, 0.6};
    places[2][0] = -0.3;
    const std::array<std::uint8_t, 8> checks{255, 200, 120, 255, 120, 200, 255, 0};
    const auto tell_balls = [&](LmSession* session, bool shared, float alpha, bool with_floor = true) {
        REQUIRE(lm_begin(session) == 0);
        const std::int32_t image = lm_add_image(session, 1, 2, 1, checks.data(), 0);
        LmMaterial material = matt(0.8f);
        const std::int32_t grey = lm_add_material(session, &material);
        material.base_image = image;
        material.image_alpha = alpha < 1.0f ? 1 : 0;
        material.alpha = alpha;
        const std::int32_t chequered = lm_add_material(session, &material);
        const std::int32_t ground_mesh = lm_add_mesh(session, 1, &ground);
        const auto origin = at(0, 0, 0);
        if (with_floor)
            REQUIRE(lm_add_object(session, ground_mesh, origin.data(), &grey, 1) == 0);
        for (std::size_t i = 0; i < places.size(); ++i) {
            const std::int32_t number = lm_add_mesh(session, shared ? 2 : 2 + i, &mesh);
            REQUIRE(lm_add_object(session, number, places[i].data(), &chequered, 1) == 0);
        }
        std::vector<LmLight> lights{lamp(1, -1, 4, 8.0f), lamp(-2, 1, 3, 4.0f, LM_REAL_LAMP),
                                    lamp(2, 2, 3, 4.0f, LM_MESH_ATK)};
        lights[1].size = 0.1f;
        for (const LmLight& light : lights)
            REQUIRE(lm_add_light(session, &light) == 0);
        REQUIRE_MESSAGE(lm_commit(session) == 0, lm_error());
    };
    const LmView view = from_above(48, 48);
    const auto differ = [](const std::vector<float>& a, const std::vector<float>& b) {
        // Rays at edges, and those that chance decides on, may go the other way: few.
        double sum = 0.0;
        std::size_t many = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            sum += std::abs(a[i] - b[i]);
            many += std::abs(a[i] - b[i]) > 0.02f ? 1u : 0u;
        }
        CAPTURE(sum);
        CAPTURE(many);
        CHECK(many < a.size() / 50);
        CHECK(sum < 0.002 * static_cast<double>(a.size()));
    };
    for (const float alpha : {1.0f, 0.999f}) {
        CAPTURE(alpha);
        const Session copied(lm_new(0));
        const Session shared(lm_new(0));
        tell_balls(copied.get(), false, alpha);
        tell_balls(shared.get(), true, alpha);
        LmStatistics statistics{};
        REQUIRE(lm_statistics(copied.get(), &statistics) == 0);
        const std::int64_t triangles = static_cast<std::int64_t>(ball.slots.size());
        CHECK(statistics.triangles == 3 * triangles + 2);
        CHECK(statistics.stored_triangles == 3 * triangles + 2);
        REQUIRE(lm_statistics(shared.get(), &statistics) == 0);
        CHECK(statistics.triangles == 3 * triangles + 2);
        CHECK(statistics.stored_triangles == triangles + 2);
        differ(picture(copied.get(), view), picture(shared.get(), view));

        // One moves: its boxes are told, all else is kept, and the picture is a new session's.
        places[0][3] += 0.3;
        tell_balls(shared.get(), true, alpha);
        REQUIRE(lm_statistics(shared.get(), &statistics) == 0);
        CHECK(statistics.is_new_scene == 0);
        CHECK(statistics.moved_boxes >= 1);
        CHECK(statistics.moved_boxes <= 2);
        CHECK(statistics.groups_kept == 3);
        const Session anew(lm_new(0));
        tell_balls(anew.get(), true, alpha);
        CHECK(picture(shared.get(), view) == picture(anew.get(), view));
    }
    // Also where all there is are instances.
    const Session copied(lm_new(0));
    const Session shared(lm_new(0));
    tell_balls(copied.get(), false, 1.0f, false);
    tell_balls(shared.get(), true, 1.0f, false);
    differ(picture(copied.get(), view), picture(shared.get(), view));
}

/// A floor, a strip of flat squares that bends above it, and a plate with holes.
struct Bending {
    float height = 0.0f;  ///< of the strip's middle above its ends
    LmMaterial floor = matt(0.5f);
    LmMaterial plate = matt(0.5f);
    std::array<std::uint8_t, 8> texels{255, 255, 255, 255, 255, 255, 255, 0};
    std::array<float, 12> plate_uvs{0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1};

    Bending() {
        plate.base_image = 0;
        plate.image_alpha = 1;
    }

    void tell(LmSession* session) const {
        REQUIRE(lm_begin(session) == 0);
        REQUIRE(lm_add_image(session, lm_hash(1, texels.data(), texels.size()), 2, 1, texels.data(), 0) == 0);
        const std::array<std::int32_t, 2> materials{lm_add_material(session, &floor),
                                                    lm_add_material(session, &plate)};
        const auto add = [&](std::uint64_t hash, const LmMesh& mesh, const std::array<double, 12>& place,
                             const std::int32_t& material) {
            const std::int32_t number = lm_add_mesh(session, hash, &mesh);
            REQUIRE_MESSAGE(number >= 0, lm_error());
            REQUIRE(lm_add_object(session, number, place.data(), &material, 1) == 0);
        };
        const Square square(1.0f);
        LmMesh mesh = square.mesh();
        add(1, mesh, at(0, 0, 0, 10), materials[0]);
        mesh.uvs = plate_uvs.data();
        add(lm_hash(2, plate_uvs.data(), sizeof plate_uvs), mesh, at(-1, 0, 1, 0.4), materials[1]);
        constexpr std::size_t steps = 4;
        std::vector<float> positions;
        std::vector<std::int32_t> corners;
        std::vector<float> normals;
        std::vector<std::int32_t> smoothing;
        std::vector<float> uvs;
        for (std::size_t step = 0; step <= steps; ++step)
            for (const float side : {0.0f, 1.0f})
                positions.insert(positions.end(),
                                 {side, 0.25f * static_cast<float>(step), step == 2 ? height : 0.0f});
        for (std::size_t step = 0; step < steps; ++step) {
            const float rise = positions[6 * step + 8] - positions[6 * step + 2];
            const auto first = static_cast<std::int32_t>(2 * step);
            for (const std::int32_t corner : {0, 1, 3, 0, 3, 2}) {
                corners.push_back(first + corner);
                normals.insert(normals.end(), {0.0f, -rise, 0.25f});
                smoothing.push_back(first);
                uvs.insert(uvs.end(),
                           {static_cast<float>(corner % 2), static_cast<float>(first + corner) / 8.0f});
            }
        }
        const std::vector<std::int32_t> slots(2 * steps);
        mesh = {};
        mesh.positions = positions.data();
        mesh.corners = corners.data();
        mesh.slots = slots.data();
        mesh.normals = normals.data();
        mesh.smoothing = smoothing.data();
        mesh.uvs = uvs.data();
        mesh.vertex_count = static_cast<std::uint32_t>(positions.size() / 3);
        mesh.triangle_count = static_cast<std::uint32_t>(slots.size());
        add(lm_hash(3, &height, sizeof height), mesh, at(0.2, -0.5, 1, 0.6), materials[0]);
        LmLight real = lamp(0, 0, 4, 20.0f, LM_REAL_LAMP);
        real.size = 0.2f;
        const LmLight meshed = lamp(1, 1, 4, 5.0f, LM_MESH);
        REQUIRE(lm_add_light(session, &real) == 0);
        REQUIRE(lm_add_light(session, &meshed) == 0);
        REQUIRE_MESSAGE(lm_commit(session) == 0, lm_error());
    }
};

TEST_CASE("blender core: a flat mesh that bends has moved, and what only pictures show keeps all shadows") {
    const Session film(lm_new(0));
    Bending scene;
    LmStatistics found{};
    std::int64_t rays = 0;
    // Draws it, and compares with a new session.
    const auto draw = [&](const std::string& what) {
        CAPTURE(what);
        scene.tell(film.get());
        const std::vector<float> ours = picture(film.get(), from_above(24, 24));
        REQUIRE(lm_statistics(film.get(), &found) == 0);
        const Session fresh(lm_new(0));
        scene.tell(fresh.get());
        CHECK(picture(fresh.get(), from_above(24, 24)) == ours);
        const std::int64_t before = std::exchange(rays, found.kept_rays);
        return std::pair{ours, found.kept_rays - before};
    };
    const auto [first, first_rays] = draw("first");
    CHECK(found.is_new_scene == 1);
    CHECK(first_rays > 1000);

    scene.height = 0.3f;
    const auto [bent, bent_rays] = draw("bent");
    CHECK(bent != first);
    CHECK(found.is_new_scene == 0);
    CHECK(found.groups_kept == 2);
    CHECK(found.moved_boxes > 0);
    CHECK(bent_rays > 0);
    CHECK(bent_rays < first_rays);

    const auto shows_without_rays = [&](const std::string& what, const std::vector<float>& before) {
        CAPTURE(what);
        const auto [drawn, new_rays] = draw(what);
        CHECK(drawn != before);
        CHECK(found.is_new_scene == 0);
        CHECK(found.groups_kept == 2);
        CHECK(found.moved_boxes == 0);
        CHECK(new_rays == 0);
        return drawn;
    };
    scene.floor.base[0] = 0.9f;
    std::vector<float> last = shows_without_rays("a colour beside holes", bent);
    scene.plate.base[1] = 0.1f;
    last = shows_without_rays("the colour of what has holes", last);
    scene.plate.is_matt = 0;
    scene.plate.specular = 0.5f;
    scene.plate.roughness = 0.4f;
    last = shows_without_rays("a highlight", last);
    scene.plate.emission[2] = 0.5f;
    last = shows_without_rays("what it shines", last);
    // At the same time as something moves.
    scene.height = 0.2f;
    scene.floor.base[2] = 0.7f;
    draw("a colour while the strip bends");
    CHECK(found.is_new_scene == 0);
    CHECK(found.groups_kept == 2);
    CHECK(found.moved_boxes > 0);

    const auto is_around_the_plate = [&, most = first_rays](const std::string& what) {
        CAPTURE(what);
        const auto [drawn, new_rays] = draw(what);
        CHECK(drawn != last);
        CHECK(found.is_new_scene == 0);
        CHECK(found.groups_kept == 2);
        CHECK(found.moved_boxes > 0);
        CHECK(new_rays > 0);
        CHECK(new_rays < most);
        last = drawn;
    };
    scene.plate.alpha = 0.5f;
    is_around_the_plate("alpha");
    scene.texels[3] = 100;
    is_around_the_plate("a texel's alpha");
    scene.plate_uvs[0] = 0.4f;
    is_around_the_plate("where the holes are");
    scene.plate.image_alpha = 0;
    scene.plate.alpha = 1.0f;
    is_around_the_plate("no holes");
    scene.texels[7] = 20;
    draw("alpha that nothing asks for");
    CHECK(found.is_new_scene == 0);
    CHECK(found.moved_boxes == 0);
}

/// A floor, and things above it that come and go: `tell` makes one scene of those there are.
struct Changing {
    struct Thing {
        std::uint64_t mesh;  ///< how many squares: one is a plate, more are stairs; 0: a ball
        std::array<double, 12> place;
        float alpha = 1.0f;
        bool has_holes = false;
    };
    std::vector<Thing> things;

    void tell(LmSession* session) const {
        REQUIRE(lm_begin(session) == 0);
        const std::array<std::uint8_t, 8> checks{255, 200, 120, 255, 120, 200, 255, 0};
        const std::int32_t image = lm_add_image(session, 1, 2, 1, checks.data(), 0);
        LmMaterial grey = matt(0.5f);
        const std::int32_t of_floor = lm_add_material(session, &grey);
        const auto add = [&](std::uint64_t hash, const LmMesh& mesh, const std::array<double, 12>& place,
                             std::int32_t material) {
            std::int32_t number = lm_find_mesh(session, hash);
            if (number < 0)
                number = lm_add_mesh(session, hash, &mesh);
            REQUIRE_MESSAGE(number >= 0, lm_error());
            REQUIRE(lm_add_object(session, number, place.data(), &material, 1) == 0);
        };
        const Square square(1.0f);
        add(1, square.mesh(), at(0, 0, 0, 10), of_floor);
        const Ball ball(24);
        for (const Thing& thing : things) {
            LmMaterial material = matt(0.5f);
            material.alpha = thing.alpha;
            material.base_image = thing.has_holes ? image : -1;
            material.image_alpha = 1;
            const std::int32_t number = lm_add_material(session, &material);
            if (thing.mesh == 0) {
                add(2, ball.mesh(), thing.place, number);
                continue;
            }
            std::vector<float> positions;
            std::vector<std::int32_t> corners;
            std::vector<float> uvs;
            for (std::uint64_t step = 0; step < thing.mesh; ++step) {
                for (std::size_t i = 0; i < 12; ++i)
                    positions.push_back(square.positions[i] + (i % 3 == 0 ? 0.0f : static_cast<float>(step)));
                for (const std::int32_t corner : square.corners)
                    corners.push_back(corner + 4 * static_cast<std::int32_t>(step));
                uvs.insert(uvs.end(), square.uvs.begin(), square.uvs.end());
            }
            const std::vector<std::int32_t> slots(2 * thing.mesh);
            LmMesh mesh{};
            mesh.positions = positions.data();
            mesh.corners = corners.data();
            mesh.slots = slots.data();
            mesh.uvs = uvs.data();
            mesh.vertex_count = static_cast<std::uint32_t>(positions.size() / 3);
            mesh.triangle_count = static_cast<std::uint32_t>(slots.size());
            add(2 + thing.mesh, mesh, thing.place, number);
        }
        LmLight real = lamp(0.3f, 0, 4, 20.0f, LM_REAL_LAMP);
        real.size = 0.2f;
        for (const LmLight& light :
             {real, lamp(1, 1, 4, 5.0f, LM_MESH), lamp(-1, 1, 4, 5.0f, LM_MESH_ATK), lamp(0, -1, 4, 5.0f)})
            REQUIRE(lm_add_light(session, &light) == 0);
        REQUIRE_MESSAGE(lm_commit(session) == 0, lm_error());
    }
};

TEST_CASE("blender core: what comes or goes or has other triangles is found anew where it is") {
    const Session film(lm_new(0));
    const LmView view = from_above(32, 32);
    Changing scene;
    const Changing::Thing plate{1, at(-1.2, 1.2, 0.5, 0.2)};
    const Changing::Thing glass{1, at(1.2, 1.2, 0.5, 0.2), 0.6f};
    const Changing::Thing leaf{1, at(-1.2, -1.2, 0.5, 0.2), 0.9f, true};
    const Changing::Thing stairs{3, at(1.2, -1.5, 0.3, 0.1)};
    const Changing::Thing ball{0, at(0, 0.2, 0.4, 0.3)};
    Changing::Thing other_ball = ball;
    other_ball.place = at(1.0, 0.2, 0.4, 0.25);
    Changing::Thing longer_stairs = stairs;
    longer_stairs.mesh = 5;
    Changing::Thing clear_ball = ball;
    clear_ball.alpha = 0.5f;
    Changing::Thing other_clear_ball = other_ball;
    other_clear_ball.alpha = 0.5f;
    using Things = std::vector<Changing::Thing>;
    struct Step {
        std::string what;
        Things things;
        bool is_small = true;  ///< whether less than half is found anew
    };
    const std::vector<Step> steps{
        {"first", {plate, stairs}, false},
        {"the same", {plate, stairs}},
        {"another order", {stairs, plate}},
        {"a ball comes, first", {ball, stairs, plate}},
        {"stairs grow", {ball, longer_stairs, plate}},
        {"the first glass", {ball, glass, longer_stairs, plate}},
        {"an instance of the ball", {ball, glass, longer_stairs, other_ball, plate}},
        {"the balls in another order", {other_ball, glass, longer_stairs, ball, plate}},
        {"a leaf, before the glass", {leaf, ball, glass, longer_stairs, other_ball, plate}},
        {"the plate goes", {leaf, ball, glass, longer_stairs, other_ball}},
        {"the glass goes", {leaf, ball, longer_stairs, other_ball}},
        {"one ball again", {leaf, other_ball, longer_stairs}},
        {"balls become clear", {leaf, clear_ball, other_clear_ball, longer_stairs}},
        {"the leaf goes", {clear_ball, other_clear_ball, longer_stairs}},
        {"a clear ball goes", {other_clear_ball, longer_stairs}},
        {"all is opaque", {ball, stairs}},
        {"nothing is left", {}},
        {"all comes back", {plate, glass, leaf, stairs, ball, other_ball}, false},
    };
    std::int64_t rays = 0;
    std::vector<float> last;
    for (const Step& step : steps) {
        CAPTURE(step.what);
        scene.things = step.things;
        scene.tell(film.get());
        const std::vector<float> ours = picture(film.get(), view);
        LmStatistics found{};
        REQUIRE(lm_statistics(film.get(), &found) == 0);
        const bool is_first = last.empty();
        CHECK(found.is_new_scene == (is_first ? 1 : 0));
        CHECK(found.groups_kept == (is_first ? 0 : 4));
        const Session fresh(lm_new(0));
        scene.tell(fresh.get());
        CHECK(picture(fresh.get(), view) == ours);
        LmStatistics of_fresh{};
        REQUIRE(lm_statistics(fresh.get(), &of_fresh) == 0);
        const std::int64_t new_rays = found.kept_rays - std::exchange(rays, found.kept_rays);
        if (step.is_small)
            CHECK(new_rays < of_fresh.kept_rays / 2);
        last = ours;
    }
}

TEST_CASE("blender core: lights that come, go or get other settings cost what is theirs") {
    for (const LmShadow shadow : {LM_REAL_LAMP, LM_MESH, LM_MESH_ATK, LM_HARD_RAYS}) {
        CAPTURE(static_cast<int>(shadow));
        const bool keeps = shadow != LM_HARD_RAYS;
        const auto plate = at(0, 0, 1, 0.05);
        std::vector<LmLight> lights;
        for (int i = 0; i < 6; ++i) {
            lights.push_back(lamp(0.4f * static_cast<float>(i) - 1.0f, 0.5f, 4, 4.0f, shadow));
            lights.back().id = static_cast<std::uint64_t>(10 + i);
            lights.back().size = 0.3f;
        }
        const Session film(lm_new(0));
        LmStatistics found{};
        std::int64_t rays = 0;
        // Draws the lights, compares with a new session, and gives the rays that were traced for it.
        const auto draw = [&](const std::string& what) {
            CAPTURE(what);
            tell(film.get(), lights, plate.data());
            const std::vector<float> ours = picture(film.get(), from_above(24, 24));
            REQUIRE(lm_statistics(film.get(), &found) == 0);
            const Session fresh(lm_new(0));
            tell(fresh.get(), lights, plate.data());
            CHECK(picture(fresh.get(), from_above(24, 24)) == ours);
            return found.kept_rays - std::exchange(rays, found.kept_rays);
        };
        const std::int64_t all = draw("first");
        CHECK((all > 0) == keeps);
        const auto costs = [&](const std::string& what, std::int64_t lights_worth, int groups, int kept) {
            CAPTURE(what);
            const std::int64_t cost = draw(what);
            CHECK(found.is_new_scene == 0);
            CHECK(found.groups == groups);
            if (keeps)
                CHECK(found.groups_kept == kept);
            CAPTURE(all);
            CAPTURE(cost);
            CHECK(cost <= lights_worth * all / 5);
        };
        const LmLight first = lights.front();
        lights.erase(lights.begin());
        costs("one went", 0, 1, 1);
        lights.push_back(first);
        costs("it came back, as the last", 2, 1, 1);
        std::swap(lights[1], lights[3]);
        costs("in another order", 0, 1, 1);
        lights.insert(lights.begin() + 2, lamp(1.5f, -1, 3, 4.0f, shadow));
        lights[2].id = 99;
        lights[2].size = 0.3f;
        if (shadow != LM_MESH)  // copied by groups of eight, of which others may be found again
            costs("another one came", 2, 1, 1);
        else
            draw("another one came");
        if (shadow == LM_HARD_RAYS)
            continue;
        lights[4].spacing = 0.3f;
        lights[4].radius = 0.4f;
        costs("other settings of one", 10, 2, 1);  // links of a mesh of its own
        const std::vector<LmLight> some(lights.begin() + 4, lights.end());
        lights = some;
        costs("most went", 0, 2, 2);
        // All have the same number, as if nothing told them apart.
        for (LmLight& light : lights)
            light.id = 0;
        draw("all alike");
        lights.erase(lights.begin() + 1);
        draw("one of them went");
    }
}

TEST_CASE("blender core: caches and meshes keep to their memory from frame to frame, and draw the same") {
    constexpr std::uint64_t budget = 1 << 18;
    for (const LmShadow shadow : {LM_REAL_LAMP, LM_MESH}) {
        CAPTURE(static_cast<int>(shadow));
        const Session tight(lm_new(budget));
        const Session loose(lm_new(0));
        std::vector<LmLight> lights;
        for (int i = 0; i < 8; ++i) {
            lights.push_back(lamp(0.3f * static_cast<float>(i) - 1.2f, 0, 4, 20.0f, shadow));
            lights.back().size = 0.5f;
            lights.back().radius = 0.05f;
            lights.back().spacing = 0.05f;
        }
        const auto plate = at(0, 0, 1, 0.15);
        tell(tight.get(), lights, plate.data());
        tell(loose.get(), lights, plate.data());
        std::int64_t most = 0;
        for (int frame = 0; frame < 6; ++frame) {
            LmView view = from_above(128, 128);
            view.eye[0] = static_cast<float>(frame) - 2.5f;
            CHECK(picture(tight.get(), view) == picture(loose.get(), view));
            LmStatistics found{};
            REQUIRE(lm_statistics(tight.get(), &found) == 0);
            most = (std::max)(most, found.bytes);
        }
        LmStatistics all{};
        REQUIRE(lm_statistics(loose.get(), &all) == 0);
        CAPTURE(most);
        CAPTURE(all.bytes);
        CHECK(3 * all.bytes > 4 * most);
    }
}

TEST_CASE("blender core: a picture that is cancelled ends soon, and another one may follow") {
    const Session session(lm_new(0));
    tell(session.get(), {lamp(0, 0, 3, 1.0f)});
    LmView view = from_above(4096, 4096);
    view.samples = 1024;
    REQUIRE(lm_render(session.get(), &view) == 0);
    float progress = 1.0f;
    CHECK(lm_poll(session.get(), 0.01, &progress) == LM_RUNNING);
    CHECK(progress < 1.0f);
    lm_cancel(session.get());
    int state = LM_RUNNING;
    while (state == LM_RUNNING)
        state = lm_poll(session.get(), 1.0, nullptr);
    CHECK(state == LM_CANCELLED);
    picture(session.get(), from_above(4, 4));
    // A session may also go while it renders.
    REQUIRE(lm_render(session.get(), &view) == 0);
}

TEST_CASE("blender core: errors are texts that name the thing") {
    const Session session(lm_new(0));
    LmView view = from_above(4, 4);
    CHECK(fails(lm_render(session.get(), &view), "no scene"));
    CHECK(fails(lm_begin(nullptr), "NULL"));
    REQUIRE(lm_begin(session.get()) == 0);
    const LmMaterial grey = matt(0.5f);
    const std::int32_t material = lm_add_material(session.get(), &grey);

    Square square(1.0f);
    square.positions[4] = std::numeric_limits<float>::quiet_NaN();
    LmMesh mesh = square.mesh();
    CHECK(fails(lm_add_mesh(session.get(), 1, &mesh), "vertex 1 of mesh 'square' is not finite"));
    square = Square(1.0f);
    square.corners[3] = 4;
    mesh = square.mesh();
    CHECK(fails(lm_add_mesh(session.get(), 1, &mesh), "has vertex 4 of 4"));
    square = Square(1.0f);
    square.slots[1] = 1;
    mesh = square.mesh();
    const std::int32_t number = lm_add_mesh(session.get(), 1, &mesh);
    REQUIRE(number == 0);
    auto place = at(0, 0, 0);
    CHECK(fails(lm_add_object(session.get(), number, place.data(), &material, 1),
                "1 materials, and its mesh 2"));
    const std::array<std::int32_t, 2> materials{0, 7};
    CHECK(fails(lm_add_object(session.get(), number, place.data(), materials.data(), 2), "material 7 of 1"));
    place[3] = std::numeric_limits<double>::infinity();
    CHECK(fails(lm_add_object(session.get(), number, place.data(), materials.data(), 2), "not finite"));
    CHECK(fails(lm_add_object(session.get(), 3, place.data(), materials.data(), 2), "mesh 3 of 1"));
    CHECK(lm_find_mesh(session.get(), 99) == -1);

    LmLight light = lamp(0, 0, 3, std::numeric_limits<float>::quiet_NaN());
    CHECK(fails(lm_add_light(session.get(), &light), "strength of light 'lamp' is not finite"));
    light = lamp(0, 0, 3, 1.0f);
    light.kind = 9;
    CHECK(fails(lm_add_light(session.get(), &light), "'lamp' is of kind 9"));
    // The library says what is wrong with a setting, when the mesh is made.
    light = lamp(0, 0, 3, 1.0f, LM_MESH);
    light.quality = 99.0f;
    REQUIRE(lm_add_light(session.get(), &light) == 0);
    CHECK(fails(lm_commit(session.get()), "quality"));

    tell(session.get(), {});
    view.width = 0;
    CHECK(fails(lm_render(session.get(), &view), "0 x 4"));
    view.width = 4;
    view.samples = 0;
    REQUIRE(lm_render(session.get(), &view) == 0);
    int state = LM_RUNNING;
    while (state == LM_RUNNING)
        state = lm_poll(session.get(), 1.0, nullptr);
    CHECK(fails(state, "samples"));
    float few = 0.0f;
    CHECK(fails(lm_read(session.get(), &few, 1), "a buffer of 1 values"));
}

TEST_CASE("blender core: a scene without surfaces is its background") {
    const Session session(lm_new(0));
    REQUIRE(lm_begin(session.get()) == 0);
    const LmLight light = lamp(0, 0, 3, 1.0f, LM_REAL_LAMP);
    REQUIRE(lm_add_light(session.get(), &light) == 0);
    REQUIRE_MESSAGE(lm_commit(session.get()) == 0, lm_error());
    LmView view = from_above(2, 2);
    view.background[1] = 0.5f;
    const std::vector<float> pixels = picture(session.get(), view);
    CHECK(pixels[1] == 0.5f);
    CHECK(pixels[3] == 1.0f);
}

}  // namespace blender_core_test
