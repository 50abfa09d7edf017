// SPDX-License-Identifier: MIT
#include "../examples/scene/boxes.hpp"
#include "../examples/scene/scene.hpp"
#include "../examples/scene/surface.hpp"
#include "temporary_folder.hpp"

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <variant>

namespace import_test {

namespace {

const std::string square = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n";

std::string ply(const std::string& vertices, int vertex_count, const std::string& faces, int face_count,
                const std::string& more_properties = "") {
    return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(vertex_count) +
           "\nproperty float x\nproperty float y\nproperty float z\n" + more_properties + "element face " +
           std::to_string(face_count) + "\nproperty list uchar int vertex_indices\nend_header\n" + vertices +
           faces;
}

/// A binary glTF file: header, JSON chunk, binary chunk.
std::string glb(std::string json, std::string binary) {
    const auto number = [](std::size_t value) {
        std::string bytes;
        for (int i = 0; i < 4; ++i) {
            bytes.push_back(static_cast<char>(value >> (8 * i) & 0xFFU));
        }
        return bytes;
    };
    json.resize((json.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    return "glTF" + number(2) + number(12 + 8 + json.size() + 8 + binary.size()) + number(json.size()) +
           "JSON" + json + number(binary.size()) + std::string("BIN\0", 4) + binary;
}

template <typename Value>
std::string bytes_of(std::initializer_list<Value> values) {
    return {reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(Value)};
}

/// A square in two triangles under a node that moves by (10, 0, 0) and doubles; a camera; lights that share
/// names and nodes that share a light.
std::string glb_with_lights(std::uint16_t last_index = 3,
                            const std::string& more_camera = R"(,"aspectRatio":1.5)") {
    const std::string json = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
        "extensionsUsed":["KHR_lights_punctual"],
        "extensions":{"KHR_lights_punctual":{"lights":[
            {"type":"directional","intensity":1},
            {"type":"point","color":[1,0.5,0.25],"intensity":40,"range":70},
            {"type":"spot","intensity":10,"spot":{"innerConeAngle":0.2,"outerConeAngle":0.5}}]}},
        "nodes":[
            {"name":"root","scale":[2,2,2],"translation":[10,0,0],"children":[2,3,4,5,6]},
            {"name":"Camera","camera":0,"translation":[0,0,5],"rotation":[0,0.70710678,0,0.70710678]},
            {"name":"Square","mesh":0},
            {"name":"Lamp","extensions":{"KHR_lights_punctual":{"light":1}},"translation":[1,2,3]},
            {"name":"Lamp","extensions":{"KHR_lights_punctual":{"light":2}},"translation":[0,5,0],
             "rotation":[-0.70710678,0,0,0.70710678]},
            {"extensions":{"KHR_lights_punctual":{"light":1}},"translation":[-1,-2,-3]},
            {"name":"Sun","extensions":{"KHR_lights_punctual":{"light":0}},
             "rotation":[-0.70710678,0,0,0.70710678]}],
        "cameras":[{"type":"perspective","perspective":{"yfov":0.6,"znear":0.1)" +
                             more_camera + R"(}}],
        "materials":[{"name":"paint","pbrMetallicRoughness":{"baseColorFactor":[0.2,0.4,0.6,1],"metallicFactor":0}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
        "accessors":[
            {"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
            {"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],
        "buffers":[{"byteLength":60}]})";
    return glb(json, bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}) +
                         bytes_of<std::uint16_t>({0, 1, 2, 0, 2, last_index}));
}

bool has_remark(const demo::Scene& scene, const std::string& text) {
    return std::any_of(scene.remarks.begin(), scene.remarks.end(),
                       [&](const std::string& remark) { return remark.find(text) != std::string::npos; });
}

const demo::Material& material_of(const demo::Scene& scene, std::size_t triangle) {
    return scene.materials[scene.triangles[triangle].material];
}

void check_near(glm::vec3 a, glm::vec3 b) {
    CAPTURE(a.x);
    CAPTURE(a.y);
    CAPTURE(a.z);
    CHECK(glm::length(a - b) < 1e-4f);
}

/// Importing the content under that name fails; returns what the error says behind the file's name.
std::string problem_of(const std::string& name, const std::string& content) {
    const test::TemporaryFolder folder;
    const auto file = folder.write(name, content);
    try {
        demo::import_scene(file);
    } catch (const std::runtime_error& error) {
        const std::string message = error.what();
        const std::string start = file.string() + ": ";
        return message.compare(0, start.size(), start) == 0 ? message.substr(start.size())
                                                            : "unnamed: " + message;
    }
    return "no error";
}

}  // namespace

TEST_CASE("OBJ: polygons become triangles, MTL becomes Whitted's materials") {
    const test::TemporaryFolder folder;
    folder.write("paint.mtl", "newmtl glass\nKd .1 .2 .3\nKs .5 .5 .5\nNs 77\nd 0.25\nNi 1.33\nillum 7\n"
                              "newmtl mirror\nKd .2 .2 .2\nKs .9 .9 .9\nNs 10\nillum 3\nKe 1 2 3\n"
                              "newmtl matt\nKd .3 .2 .1\n");
    const auto file =
        folder.write("a.obj", "mtllib paint.mtl\n" + square +
                                  "usemtl glass\nf 1 2 3 4\nusemtl mirror\nf 1 2 3\nusemtl matt\nf 1 3 4\n");
    const demo::Scene scene = demo::import_scene(file);
    CHECK(scene.name == "a");
    REQUIRE(scene.triangles.size() == 4);
    CHECK(scene.normals.size() == scene.positions.size());
    check_near(scene.normals[0], {0, 0, 1});
    CHECK(scene.radius == doctest::Approx(0.025 * std::sqrt(8.0)));

    const demo::Material& glass = material_of(scene, 0);
    CHECK(glass.name == "glass");
    check_near(glass.diffuse, {0.1f, 0.2f, 0.3f});
    CHECK(glass.k_t == doctest::Approx(0.75f));
    CHECK(glass.k_s == doctest::Approx(0.25f));
    CHECK(glass.refraction_index == doctest::Approx(1.33f));
    CHECK(glass.shininess == doctest::Approx(77.0f));
    const demo::Material& mirror = material_of(scene, 2);
    CHECK(mirror.k_s == doctest::Approx(0.9f));
    CHECK(mirror.k_t == 0.0f);
    check_near(mirror.emission, {1, 2, 3});
    const demo::Material& matt = material_of(scene, 3);
    CHECK(matt.k_s == 0.0f);
    CHECK(matt.specular == glm::vec3{0.0f});
}

TEST_CASE("a file without lights or camera gets both, and says so") {
    const test::TemporaryFolder folder;
    const demo::Scene scene = demo::import_scene(folder.write("a.obj", square + "f 1 2 3 4\n"));
    CHECK(scene.lights.size() >= 4);
    CHECK(has_remark(scene, "no lights"));
    CHECK(has_remark(scene, "no camera"));
    CHECK(scene.camera.up == glm::vec3{0, 1, 0});
    check_near(scene.camera.target, {1, 1, 0});
    CHECK(glm::length(scene.camera.eye - scene.camera.target) > std::sqrt(2.0f));
    for (const demo::SceneLight& light : scene.lights) {
        CHECK(std::get<lightmesh::PointLight>(light.shape).position.y > 2.0f);
    }
}

TEST_CASE("an MTL file that is missing is named in a remark") {
    const test::TemporaryFolder folder;
    const auto file = folder.write("a.obj", "mtllib gone.mtl\nusemtl red\n" + square + "f 1 2 3\n");
    CHECK(has_remark(demo::import_scene(file), "gone.mtl"));
}

TEST_CASE("triangles without area are left out, with a remark") {
    const test::TemporaryFolder folder;
    const auto file = folder.write("a.obj", square + "f 1 2 3\nf 1 1 2\nf 2 2 2\n");
    const demo::Scene scene = demo::import_scene(file);
    CHECK(scene.triangles.size() == 1);
    CHECK(has_remark(scene, "2 triangles without area"));
}

TEST_CASE("glTF: nodes move meshes, lights and the camera") {
    const test::TemporaryFolder folder;
    const demo::Scene scene = demo::import_scene(folder.write("a.glb", glb_with_lights()));
    CHECK(scene.triangles.size() == 2);
    const demo::Bounds bounds = demo::bounds_of(scene);
    check_near(bounds.low, {10, 0, 0});
    check_near(bounds.high, {12, 2, 0});
    check_near(material_of(scene, 0).diffuse, {0.2f, 0.4f, 0.6f});
    CHECK(scene.remarks.empty());

    check_near(scene.camera.eye, {0, 0, 5});
    check_near(glm::normalize(scene.camera.target - scene.camera.eye), {-1, 0, 0});
    check_near(scene.camera.up, {0, 1, 0});
    CHECK(scene.camera.vertical_field_of_view == doctest::Approx(0.6f));

    REQUIRE(scene.lights.size() == 4);
    const auto& lamp = std::get<lightmesh::PointLight>(scene.lights[0].shape);
    check_near(lamp.position, {12, 4, 6});
    CHECK(lamp.range == 70.0f);
    check_near(scene.lights[0].intensity, {40, 20, 10});
    const auto& spot = std::get<lightmesh::SpotLight>(scene.lights[1].shape);
    check_near(spot.position, {10, 10, 0});
    check_near(spot.axis, {0, -1, 0});
    CHECK(spot.cone == doctest::Approx(0.5f));
    CHECK(std::isinf(spot.range));
    CHECK(scene.lights[1].inner_cone == doctest::Approx(0.2f));
    const auto& twin = std::get<lightmesh::PointLight>(scene.lights[2].shape);
    check_near(twin.position, {8, -4, -6});
    CHECK(twin.range == 70.0f);
    const auto& sun = std::get<lightmesh::DirectionalLight>(scene.lights[3].shape);
    check_near(sun.direction, {0, -1, 0});
    check_near(scene.lights[3].intensity, glm::vec3{1.0f});
}

TEST_CASE("glTF: a camera without an aspect ratio has the same vertical angle") {
    const test::TemporaryFolder folder;
    const demo::Scene scene = demo::import_scene(folder.write("a.glb", glb_with_lights(3, "")));
    CHECK(scene.camera.vertical_field_of_view == doctest::Approx(0.6f));
}

TEST_CASE("PLY: vertex colours are the colours of the surface") {
    const test::TemporaryFolder folder;
    const std::string vertices = "0 0 0 255 0 0\n1 0 0 255 0 0\n1 1 0 255 0 0\n";
    const auto file =
        folder.write("a.ply", ply(vertices, 3, "3 0 1 2\n", 1,
                                  "property uchar red\nproperty uchar green\nproperty uchar blue\n"));
    const demo::Scene scene = demo::import_scene(file);
    REQUIRE(scene.triangles.size() == 1);
    check_near(demo::surface_at(scene, 0, 0.3f, 0.3f).diffuse, {1, 0, 0});
}

TEST_CASE("PLY: coordinates far from the origin keep their detail") {
    const test::TemporaryFolder folder;
    std::string text =
        ply("500000.125 0 5400000.5\n500000.25 0 5400000.5\n500000.125 0.125 5400000.5\n", 3, "3 0 1 2\n", 1);
    for (std::size_t at = text.find("float"); at != std::string::npos; at = text.find("float"))
        text.replace(at, 5, "double");
    const demo::Scene scene = demo::import_scene(folder.write("a.ply", text));
    CHECK(has_remark(scene, "far from the origin"));
    CHECK(scene.origin.x + static_cast<double>(scene.positions[0].x) == 500000.125);
    check_near(scene.positions[1] - scene.positions[0], {0.125f, 0, 0});
    check_near(scene.positions[2] - scene.positions[0], {0, 0.125f, 0});
}

TEST_CASE("PLY: both orders of bytes, all types of numbers, and properties of no use") {
    const auto number = [](auto value, bool is_big) {
        std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
        if (is_big)
            std::reverse(bytes.begin(), bytes.end());
        return bytes;
    };
    for (const bool is_big : {false, true}) {
        CAPTURE(is_big);
        std::string file = std::string("ply\r\nformat binary_") + (is_big ? "big" : "little") +
                           "_endian 1.0\r\nelement vertex 3\r\nproperty int x\r\nproperty double y\r\n"
                           "property list uchar short weights\r\nproperty float z\r\nproperty ushort red\r\n"
                           "property ushort green\r\nproperty ushort blue\r\nelement face 1\r\n"
                           "property uchar flags\r\nproperty list ushort uint vertex_index\r\nend_header\n";
        for (std::int32_t i = 0; i < 3; ++i)
            file += number(i * 3, is_big) + number(0.5 * i * i, is_big) + number(std::uint8_t{2}, is_big) +
                    number(std::int16_t{-7}, is_big) + number(std::int16_t{9}, is_big) +
                    number(-1.5f, is_big) + number(std::uint16_t{65535}, is_big) +
                    number(std::uint16_t{0}, is_big) + number(std::uint16_t{0}, is_big);
        file += number(std::uint8_t{1}, is_big) + number(std::uint16_t{3}, is_big);
        for (std::uint32_t i = 0; i < 3; ++i)
            file += number(i, is_big);
        const test::TemporaryFolder folder;
        const demo::Scene scene = demo::import_scene(folder.write("a.ply", file));
        REQUIRE(scene.triangles.size() == 1);
        check_near(scene.positions[2], {6, 2, -1.5f});
        check_near(demo::surface_at(scene, 0, 0.3f, 0.3f).diffuse, {1, 0, 0});
        CHECK(problem_of("a.ply", file.substr(0, file.size() - 5)).find("cut off") != std::string::npos);
    }
}

TEST_CASE("PLY: polygons with notches, and strips") {
    const test::TemporaryFolder folder;
    const auto area_of = [](const demo::Scene& scene) {
        float sum = 0.0f;
        for (const demo::Triangle& t : scene.triangles) {
            const glm::vec3 a = scene.positions[t.vertex[0]];
            const glm::vec3 twice =
                glm::cross(scene.positions[t.vertex[1]] - a, scene.positions[t.vertex[2]] - a);
            CHECK(twice.z > 0.0f);
            sum += 0.5f * glm::length(twice);
        }
        return sum;
    };
    // An arrow head, and an L that begins at its notch.
    const demo::Scene arrow =
        demo::import_scene(folder.write("a.ply", ply("0 0 0\n2 -2 0\n1 0 0\n2 2 0\n", 4, "4 0 1 2 3\n", 1)));
    CHECK(area_of(arrow) == doctest::Approx(2.0f));
    const demo::Scene corner = demo::import_scene(
        folder.write("b.ply", ply("1 1 0\n1 3 0\n0 3 0\n0 0 0\n3 0 0\n3 1 0\n", 6, "6 0 1 2 3 4 5\n", 1)));
    CHECK(corner.triangles.size() == 4);
    CHECK(area_of(corner) == doctest::Approx(5.0f));

    std::string strips =
        ply("0 0 0\n1 0 0\n0 1 0\n1 1 0\n5 0 0\n6 0 0\n5 1 0\n", 7, "8 0 1 2 3 -1 4 5 6\n", 1);
    strips.replace(strips.find("element face"), 12, "element tristrips");
    const demo::Scene stripped = demo::import_scene(folder.write("c.ply", strips));
    CHECK(stripped.triangles.size() == 3);
    CHECK(area_of(stripped) == doctest::Approx(1.5f));
}

TEST_CASE("PLY: normals are smooth over flat folds, and split on sharp ones") {
    const test::TemporaryFolder folder;
    const auto fold = [&](const std::string& height) {
        return demo::import_scene(
            folder.write("a.ply", ply("0 0 0\n0 1 0\n1 0 0\n1 1 0\n2 0 " + height + "\n2 1 " + height + "\n",
                                      6, "4 0 2 3 1\n4 2 4 5 3\n", 2)));
    };
    const demo::Scene flat = fold("0.3");
    CHECK(flat.positions.size() == 6);
    check_near(flat.normals[2], glm::normalize(glm::vec3(0, 0, 1) + glm::normalize(glm::vec3(-0.3f, 0, 1))));
    const demo::Scene sharp = fold("2");
    CHECK(sharp.positions.size() == 8);
    for (const demo::Triangle& t : sharp.triangles) {
        const bool is_flat = sharp.positions[t.vertex[0]].z + sharp.positions[t.vertex[1]].z +
                                 sharp.positions[t.vertex[2]].z ==
                             0.0f;
        for (const std::uint32_t vertex : t.vertex)
            check_near(sharp.normals[vertex],
                       is_flat ? glm::vec3(0, 0, 1) : glm::normalize(glm::vec3(-2, 0, 1)));
    }
}

TEST_CASE("OBJ: map_d leaves holes, Tf tints, and UTF-16 is refused by name") {
    const test::TemporaryFolder folder;
    std::string tga(18, '\0');  // two texels: white and black
    tga[2] = 2;
    tga[12] = 2;
    tga[14] = 1;
    tga[16] = 24;
    tga += std::string("\xff\xff\xff\x00\x00\x00", 6);
    folder.write("holes.tga", tga);
    folder.write("a.mtl", "newmtl leaf\nKd .2 .8 .2\nmap_d holes.tga\nnewmtl glass\nd 0.5\nTf 1 0.5 0.25\n");
    const demo::Scene scene =
        demo::import_scene(folder.write("a.obj", "mtllib a.mtl\n" + square +
                                                     "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
                                                     "usemtl leaf\nf 1/1 2/2 3/3\nusemtl glass\nf 1 3 4\n"));
    CHECK_FALSE(demo::is_hole(scene, 0, 0.1f, 0.0f));
    CHECK(demo::share_let_through(scene, 0, 0.1f, 0.0f) == 0.0f);
    CHECK(demo::is_hole(scene, 0, 0.9f, 0.0f));
    CHECK(demo::share_let_through(scene, 0, 0.9f, 0.0f) == 1.0f);
    check_near(demo::surface_at(scene, 1, 0.3f, 0.3f).k_t, {0.5f, 0.25f, 0.125f});
    CHECK(problem_of("b.obj", std::string("\xff\xfev\0 \0", 6)).find("UTF-16") != std::string::npos);
}

TEST_CASE("OBJ and PLY: what is up, if it is not y") {
    const test::TemporaryFolder folder;
    const auto file = folder.write("a.obj", square + "f 1 2 3 4\n");
    demo::ImportOptions options;
    CHECK(demo::import_scene(file, options).camera.up == glm::vec3(0, 1, 0));
    options.z_is_up = true;
    const demo::Scene scene = demo::import_scene(file, options);
    CHECK(scene.camera.up == glm::vec3(0, 0, 1));
    CHECK(has_remark(scene, "with +z up"));
    CHECK(scene.camera.eye.y < 0.0f);  // from the front, which is -y
    for (const demo::SceneLight& light : scene.lights)
        CHECK(std::get<lightmesh::PointLight>(light.shape).position.z > 0.0f);
}

TEST_CASE("import errors name the file and what is wrong with it") {
    CHECK_THROWS_WITH_AS(demo::import_scene("none.obj"),
                         "none.obj: no such file, and no built-in scene of that name", std::runtime_error);
    CHECK(problem_of("a.txt", "x") == "unknown format '.txt'; .obj, .gltf, .glb and .ply can be read");
    CHECK(problem_of("a.glb", "junk") == "is damaged, or not what its name says");
    CHECK(problem_of("a.gltf", "{\"asset\":") == "is damaged, or not what its name says");
    CHECK(problem_of("a.obj", "").find("no error") == std::string::npos);
    CHECK(problem_of("a.obj", square) == "has no triangles");
    CHECK(problem_of("a.obj", square + "l 1 2 3\n") == "has no triangles");
    CHECK(problem_of("a.obj", square + "f 1 1 1\n") == "has no triangles");
    CHECK(problem_of("a.ply", ply("0 0 0\n1 0 0\n1 1 0\n", 3, "", 0)) == "has no triangles");

    const test::TemporaryFolder folder;
    CHECK_THROWS_AS(demo::import_scene(folder / ""), std::runtime_error);
}

TEST_CASE("vertices that are not finite are named") {
    CHECK(problem_of("a.obj", "v 0 0 0\nv nan 0 0\nv 1 1 0\nf 1 2 3\n").find("vertex 1 of mesh 0") == 0);
    CHECK(problem_of("a.obj", "v 0 0 0\nv 0 0 inf\nv 1 1 0\nf 1 2 3\n").find("not finite") !=
          std::string::npos);
    const std::string problem = problem_of("a.ply", ply("0 0 0\n1 0 0\n1 nan 0\n", 3, "3 0 1 2\n", 1));
    CHECK(problem.find("vertex 2 is not finite") == 0);
}

TEST_CASE("faces of vertices that are not there are an error") {
    CHECK(problem_of("a.obj", square + "f 1 2 9\n") ==
          "line 5: a face refers to vertex 9, but there are only 4");
    CHECK(problem_of("a.glb", glb_with_lights(9)) ==
          "mesh 0 '' at node 2 'Square': a face refers to vertex 9, but there are only 4");
    CHECK(problem_of("a.ply", ply("0 0 0\n1 0 0\n1 1 0\n", 3, "3 0 1 7\n", 1)) ==
          "face 0 refers to vertex 7, but there are only 3");
}

TEST_CASE("a file that is cut off is an error") {
    CHECK(problem_of("a.ply", ply("0 0 0\n", 3, "", 1)).find("cut off") != std::string::npos);
    const std::string whole = glb_with_lights();
    CHECK(problem_of("a.glb", whole.substr(0, whole.size() / 2)).find("no error") == std::string::npos);
}

}  // namespace import_test
