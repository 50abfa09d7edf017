// SPDX-License-Identifier: MIT

// What glTF files say, extension by extension; field_test.cpp has whole files.

#include "../examples/render/files.hpp"
#include "../examples/render/view.hpp"
#include "../examples/scene/boxes.hpp"
#include "../examples/scene/scene.hpp"
#include "../examples/scene/surface.hpp"
#include "gltf_writer.hpp"
#include "temporary_folder.hpp"

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <stdexcept>
#include <string>

namespace gltf_test {

namespace {

using test::GltfFile;

const std::filesystem::path field = LIGHTMESH_FIELD;

bool has_remark(const demo::Scene& scene, const std::string& text) {
    return std::ranges::any_of(
        scene.remarks, [&](const std::string& remark) { return remark.find(text) != std::string::npos; });
}

const std::string triangle = R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])";

/// The triangle with a material.
demo::Scene with_material(const std::string& material, const std::string& more = "") {
    const test::TemporaryFolder folder;
    folder.write("a.ktx2", "\xabKTX 20\xbb\r\n\x1a\n and more than that");
    return demo::import_scene(GltfFile().write(
        folder,
        R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
           "materials":[)" +
            material + "]" + more));
}

/// The animation's channel as it moves node 0, at a time.
demo::Scene at_time(double time, const std::string& interpolation, const std::string& path,
                    const std::string& type, std::initializer_list<float> values,
                    const std::string& mesh = triangle) {
    const test::TemporaryFolder folder;
    GltfFile file;
    const int lifted = file.add("VEC3", {0, 0, 5, 0, 0, 5, 0, 0, 5});  // a morph target, if the mesh has it
    REQUIRE(lifted == 1);
    const int keys = file.add("SCALAR", {1, 3});
    const int outputs = file.add(type, values);
    demo::ImportOptions options;
    options.time = time;
    return demo::import_scene(
        file.write(
            folder,
            R"("nodes":[{"mesh":0}],)" + mesh +
                R"(,"animations":[{"name":"move","channels":[{"sampler":0,"target":{"node":0,"path":")" +
                path + R"("}}],"samplers":[{"input":)" + std::to_string(keys) + R"(,"output":)" +
                std::to_string(outputs) + R"(,"interpolation":")" + interpolation + R"("}]}])"),
        options);
}

/// The triangle's first corner.
glm::dvec3 corner(const demo::Scene& scene, std::size_t i = 0) {
    return glm::dvec3(scene.positions[i]) + scene.origin;
}

}  // namespace

TEST_CASE("glTF: nodes move between the keys of an animation, and stand still outside of them") {
    const auto x = [](double time, const std::string& interpolation) {
        return corner(at_time(time, interpolation, "translation", "VEC3", {10, 0, 0, 20, 0, 0})).x;
    };
    CHECK(x(0.0, "LINEAR") == doctest::Approx(10));
    CHECK(x(1.5, "LINEAR") == doctest::Approx(12.5));
    CHECK(x(9.0, "LINEAR") == doctest::Approx(20));
    CHECK(x(2.9, "STEP") == doctest::Approx(10));
    CHECK(x(3.0, "STEP") == doctest::Approx(20));
    // Cubic: p(t) = (2t^3 - 3t^2 + 1) p0 + d (t^3 - 2t^2 + t) m0 + (3t^2 - 2t^3) p1 + d (t^3 - t^2) m1.
    const auto cubic = [](double time) {
        return corner(at_time(time, "CUBICSPLINE", "translation", "VEC3",
                              {0, 0, 0, 10, 0, 0, 4, 0, 0, 8, 0, 0, 20, 0, 0, 0, 0, 0}))
            .x;
    };
    CHECK(cubic(1.0) == doctest::Approx(10));
    CHECK(cubic(2.0) == doctest::Approx(0.5 * 10 + 2 * 0.125 * 4 + 0.5 * 20 - 2 * 0.125 * 8));
    CHECK(cubic(3.0) == doctest::Approx(20));
}

TEST_CASE("glTF: rotations turn along the shorter arc, scales and weights change") {
    // From 0 to 90 degrees about z, the second one with its sign turned.
    const demo::Scene turned =
        at_time(2.0, "LINEAR", "rotation", "VEC4", {0, 0, 0, 1, 0, 0, -0.70710678f, -0.70710678f});
    CHECK(corner(turned, 1).x == doctest::Approx(std::sqrt(0.5)));
    CHECK(corner(turned, 1).y == doctest::Approx(std::sqrt(0.5)));
    CHECK(corner(at_time(2.0, "LINEAR", "scale", "VEC3", {1, 1, 1, 3, 1, 1}), 1).x == doctest::Approx(2));
    const demo::Scene lifted =
        at_time(1.5, "LINEAR", "weights", "SCALAR", {0, 1},
                R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":1}]}]}])");
    CHECK(corner(lifted).z == doctest::Approx(1.25));
}

TEST_CASE("glTF: bones carry a skin to where they are at a time") {
    const test::TemporaryFolder folder;
    GltfFile file;
    file.add("VEC4", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});  // joints
    file.add("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});  // weights
    file.add("SCALAR", {0, 1});
    file.add("VEC3", {0, 0, 0, 0, 8, 0});
    // Joints are integers: the bits of these floats are zeros, too.
    const std::string json =
        R"("nodes":[{"mesh":0,"skin":0,"translation":[100,0,0],"children":[1]},{"name":"bone"}],
        "skins":[{"joints":[1]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":5,"WEIGHTS_0":2}}]}],
        "animations":[{"channels":[{"sampler":0,"target":{"node":1,"path":"translation"}}],
            "samplers":[{"input":3,"output":4}]}])";
    const auto path = file.write(folder, json);
    std::string text = demo::read_file(path);
    text.insert(text.find(R"(],"bufferViews")"),
                R"(,{"componentType":5121,"bufferView":1,"type":"VEC4","count":3})");
    demo::ImportOptions options;
    options.time = 0.25;
    const demo::Scene scene = demo::import_scene(folder.write("b.gltf", text), options);
    CHECK(corner(scene).x == doctest::Approx(100));
    CHECK(corner(scene).y == doctest::Approx(2));
}

TEST_CASE("glTF: animations are chosen by name or number, files without any are the same at all times") {
    const test::TemporaryFolder folder;
    GltfFile file;
    file.add("SCALAR", {0});
    file.add("VEC3", {1, 0, 0});
    file.add("VEC3", {2, 0, 0});
    const auto animation = [](const std::string& name, const std::string& output) {
        return R"({"name":")" + name +
               R"(","channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],
                   "samplers":[{"input":1,"output":)" +
               output + "}]}";
    };
    const auto two = file.write(folder, R"("nodes":[{"mesh":0}],)" + triangle + R"(,"animations":[)" +
                                            animation("walk", "2") + "," + animation("run", "3") + "]");
    demo::ImportOptions options;
    CHECK(corner(demo::import_scene(two, options)).x == 0.0);
    CHECK(has_remark(demo::import_scene(two, options), "--time"));
    options.time = 0.0;
    CHECK(corner(demo::import_scene(two, options)).x == 1.0);
    CHECK(has_remark(demo::import_scene(two, options), "the file has 2"));
    for (const std::string name : {"run", "1"}) {
        options.animation = name;
        CHECK(corner(demo::import_scene(two, options)).x == 2.0);
    }
    options.animation = "swim";
    CHECK_THROWS_WITH(demo::import_scene(two, options),
                      (two.string() + ": there is no animation 'swim'; there are 0 'walk', 1 'run'").c_str());
    options.animation = "";
    const auto none = GltfFile().write(folder, R"("nodes":[{"mesh":0}],)" + triangle);
    CHECK(has_remark(demo::import_scene(none, options), "no animations"));
}

TEST_CASE("glTF: keys out of order and values that do not fit them are refused") {
    CHECK_THROWS_AS(at_time(2.0, "LINEAR", "translation", "VEC3", {0, 0, 0}), std::runtime_error);
    CHECK_THROWS_AS(at_time(2.0, "LINEAR", "rotation", "VEC3", {0, 0, 0, 1, 1, 1}), std::runtime_error);
    CHECK_THROWS_AS(at_time(2.0, "CUBICSPLINE", "translation", "VEC3", {0, 0, 0, 1, 1, 1}),
                    std::runtime_error);
}

TEST_CASE("glTF: an orthographic camera sees its height, with rays side by side") {
    const test::TemporaryFolder folder;
    const demo::Scene scene = demo::import_scene(GltfFile().write(
        folder, R"("nodes":[{"mesh":0,"children":[1]},{"camera":0,"translation":[0,0,5]}],)" + triangle +
                    R"(,"cameras":[{"type":"orthographic",
                       "orthographic":{"xmag":3,"ymag":2,"znear":0.1,"zfar":100}}])"));
    CHECK(scene.has_own_camera);
    CHECK(scene.camera.orthographic_height == 4.0f);
    const demo::View view(scene.camera, 40, 20);
    CHECK(glm::length(view.direction(0, 0) - glm::vec3(0, 0, -1)) < 1e-6f);
    CHECK(glm::length(view.origin(20, 0) - glm::vec3(0, 2, 5)) < 1e-5f);
    CHECK(glm::length(view.origin(40, 10) - glm::vec3(4, 0, 5)) < 1e-5f);
}

TEST_CASE("glTF: unlit surfaces are as their colour says, and light nothing") {
    const demo::Scene scene = with_material(
        R"({"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.25,0,1]},"extensions":{"KHR_materials_unlit":{}}})",
        R"(,"extensionsUsed":["KHR_materials_unlit"])");
    CHECK(glm::length(demo::surface_at(scene, 0, 0.3f, 0.3f).emission - glm::vec3(0.5f, 0.25f, 0)) < 1e-6f);
    CHECK(demo::surface_at(scene, 0, 0.3f, 0.3f).diffuse == glm::vec3(0));
    CHECK(has_remark(scene, "the file has no lights"));
}

TEST_CASE("glTF: KHR_materials_emissive_strength multiplies, and the lamp has the surface's power") {
    const demo::Scene scene = with_material(
        R"({"emissiveFactor":[1,0.5,0],"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":8}}})",
        R"(,"extensionsUsed":["KHR_materials_emissive_strength"])");
    CHECK(scene.materials[0].emission == glm::vec3(8, 4, 0));
    float sum = 0.0f;
    for (const demo::SceneLight& light : scene.lights)
        sum += light.intensity.r;
    CHECK(sum == doctest::Approx(8.0f * 0.5f / 3.14159265f));
}

TEST_CASE("glTF: glass tints what is seen through it") {
    const demo::Scene scene = with_material(
        R"({"pbrMetallicRoughness":{"baseColorFactor":[0.5,1,0.2,1],"metallicFactor":0},
            "extensions":{"KHR_materials_transmission":{"transmissionFactor":1},
                "KHR_materials_volume":{"thicknessFactor":2,"attenuationDistance":1,"attenuationColor":[1,0.5,1]}}})",
        R"(,"extensionsUsed":["KHR_materials_transmission","KHR_materials_volume"])");
    const glm::vec3 through = demo::surface_at(scene, 0, 0.3f, 0.3f).k_t / scene.materials[0].k_t;
    CHECK(glm::length(through - glm::vec3(0.5f, 0.25f, 0.2f)) < 1e-5f);
    const float grey = 0.2126f * 0.5f + 0.7152f * 0.25f + 0.0722f * 0.2f;
    CHECK(demo::share_let_through(scene, 0, 0.3f, 0.3f) == doctest::Approx(scene.materials[0].k_t * grey));
}

TEST_CASE("glTF: compressed meshes are as those they were made of") {
    for (const std::string file : {"draco", "meshopt"}) {
        CAPTURE(file);
        const demo::Scene scene = demo::import_scene(field / "compressed" / (file + ".gltf"));
        CHECK(scene.triangles.size() == 4);
        const demo::Bounds bounds = demo::bounds_of(scene);
        CHECK(glm::length(bounds.low) < 1e-3f);
        CHECK(glm::length(bounds.high - glm::vec3(2, 1, 2)) < 1e-3f);
        // The roof's front slope looks to -z and up.
        const demo::Triangle& first = scene.triangles[0];
        const glm::vec3 a = scene.positions[first.vertex[0]];
        const glm::vec3 normal = glm::normalize(
            glm::cross(scene.positions[first.vertex[1]] - a, scene.positions[first.vertex[2]] - a));
        CHECK(std::abs(normal.x) < 1e-3f);
        CHECK(std::abs(normal.y) == doctest::Approx(std::sqrt(0.5)).epsilon(1e-3));
    }
    const demo::Scene scene = demo::import_scene(field / "compressed/meshopt.gltf");
    CHECK(std::ranges::any_of(scene.normals, [](const glm::vec3& normal) {
        return glm::length(normal - glm::vec3(0, std::sqrt(0.5f), -std::sqrt(0.5f))) < 0.02f;
    }));
}

TEST_CASE("glTF: a texture in KTX2 is named as what it is") {
    const std::string images = R"(,"images":[{"name":"bark","uri":"a.ktx2"}])";
    const std::string material = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";
    const demo::Scene used = with_material(material, images + R"(,"extensionsUsed":["KHR_texture_basisu"],
            "textures":[{"extensions":{"KHR_texture_basisu":{"source":0}}}])");
    CHECK(has_remark(used, "texture 'bark' is left out: it is KTX2, which cannot be read"));
    CHECK(has_remark(used, "KHR_texture_basisu (textures in KTX2)"));
    CHECK_THROWS_WITH_AS(with_material(material, images + R"(,"extensionsRequired":["KHR_texture_basisu"],
            "textures":[{"extensions":{"KHR_texture_basisu":{"source":0}}}])"),
                         doctest::Contains("requires what is not supported: KHR_texture_basisu"),
                         std::runtime_error);
}

TEST_CASE("glTF: what a file makes of nothing has bounds") {
    // 2^24 - 1 vertices without a byte of them.
    const test::TemporaryFolder folder;
    const auto file =
        folder.write("a.gltf",
                     R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":0}}]}],
            "accessors":[{"componentType":5126,"type":"VEC3","count":16777215}]})");
    CHECK_THROWS_WITH_AS(demo::import_scene(file),
                         doctest::Contains("would take more than 64 MB of memory to read"),
                         std::runtime_error);
}

}  // namespace gltf_test
