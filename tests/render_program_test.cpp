// SPDX-License-Identifier: MIT

// The program lightmesh-render as its users run it.

#include "image/image.hpp"
#include "render/files.hpp"
#include "run_command.hpp"
#include "temporary_folder.hpp"

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

namespace render_program_test {

namespace {

using test::Finished;
using test::TemporaryFolder;

const std::string tiny = " --width 48 --height 36 --depth embree --map-size 64 --threads 2 ";
const std::string tiny_tables = " --width 24 --height 18 --depth embree --threads 2 ";

Finished render(const TemporaryFolder& folder, const std::string& arguments) {
    return test::run(folder, LIGHTMESH_RENDER " " + arguments);
}

/// One line that holds `part`, a status that is not 0, and nothing left in the folder.
void check_refused(const std::string& arguments, const std::string& part) {
    CAPTURE(arguments);
    const TemporaryFolder folder;
    const TemporaryFolder working;
    const Finished ran =
        test::run(folder, "cd " + (working / "").string() + " && " LIGHTMESH_RENDER " " + arguments);
    CHECK(ran.status > 0);
    CHECK(std::ranges::count(ran.errors, '\n') == 1);
    CHECK(ran.errors.starts_with("lightmesh-render: "));
    CHECK_MESSAGE(ran.errors.find(part) != std::string::npos, ran.errors);
    CHECK(working.file_count() == 0);
}

const std::string triangle_obj = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 3\nf 1 2 3\nf 1 2 4\n";

}  // namespace

TEST_CASE("lightmesh-render picture: a picture, its linear values and a table") {
    const TemporaryFolder folder;
    const Finished ran = render(folder, "picture spheres" + tiny + "-o " + (folder / "p.png").string() +
                                            " --exr " + (folder / "p.exr").string());
    REQUIRE_MESSAGE(ran.status == 0, ran.errors);
    CHECK(ran.errors.empty());
    for (const char* row :
         {"algorithm", "cache", "triangles", "2,028", "radius r", "quality q", "spacing g", "lamp radius",
          "surface points", "rays to lamps", "records", "ns per point and light", "seconds: BVH"})
        CHECK_MESSAGE(ran.output.find(row) != std::string::npos, row);
    const demo::Image png = demo::read_png(folder / "p.png");
    const demo::Image exr = demo::read_exr(folder / "p.exr");
    CHECK(png.width == 48);
    CHECK(png.height == 36);
    CHECK(demo::mean_absolute_difference(png, exr) < 0.01);
}

TEST_CASE("lightmesh-render picture: each algorithm there is") {
    const TemporaryFolder folder;
    for (const std::string algorithm :
         {"whitted", "area", "cache", "blur-cache", "shadow-map", "shadow-volume", "lmm", "linked", "express",
          "lmm+map", "linked+map", "express+map", "lmm+volume", "linked+volume", "express+volume"}) {
        CAPTURE(algorithm);
        const Finished ran = render(folder, "picture spheres -a " + algorithm + tiny + "-o " +
                                                (folder / (algorithm + ".png")).string());
        CHECK_MESSAGE(ran.status == 0, ran.errors);
        for (const char* row : {"radius r", "quality q", "spacing g", "lamp radius"})
            CHECK_MESSAGE(ran.output.find(row) != std::string::npos, row);
        if (algorithm.ends_with("cache"))
            for (const char* row : {"rays to lamps", "records", "memory of the cache"})
                CHECK_MESSAGE(ran.output.find(row) != std::string::npos, row);
        if (algorithm == "linked")
            for (const char* row : {"light points", "long rays", "link rays", "memory of the mesh"})
                CHECK_MESSAGE(ran.output.find(row) != std::string::npos, row);
        const demo::Image picture = demo::read_png(folder / (algorithm + ".png"));
        // Pixels this wide are served by wide levels, of which Express leaks more.
        const double limit = algorithm.starts_with("express") ? 0.05 : 0.03;
        CHECK(demo::mean_absolute_difference(picture, demo::read_png(folder / "whitted.png")) < limit);
    }
}

TEST_CASE("lightmesh-render compare: pictures, differences, sheets and a table") {
    const TemporaryFolder folder;
    const std::filesystem::path out = folder / "made/by/it";
    const Finished ran =
        render(folder, "compare rooms --algorithms whitted,lmm,express --reference lmm --exr" + tiny + "-o " +
                           out.string());
    REQUIRE_MESSAGE(ran.status == 0, ran.errors);
    for (const char* file :
         {"whitted.png", "lmm.png", "express.png", "whitted-difference.png", "express-difference.png",
          "sheet.png", "differences.png", "whitted.exr", "table.txt"})
        CHECK_MESSAGE(std::filesystem::exists(out / file), file);
    CHECK_FALSE(std::filesystem::exists(out / "lmm-difference.png"));
    CHECK(demo::read_png(out / "sheet.png").width > 3 * 48);
    const std::string table = demo::read_file(out / "table.txt");
    CHECK(ran.output.find(table) != std::string::npos);
    CHECK(table.find("97,538 triangles, 36 lights") != std::string::npos);
    // Where the difference picture is white, the pictures are equal.
    const demo::Image lmm = demo::read_png(out / "lmm.png");
    const demo::Image express = demo::read_png(out / "express.png");
    const demo::Image difference = demo::read_png(out / "express-difference.png");
    for (std::size_t i = 0; i < lmm.pixels.size(); ++i)
        if (difference.pixels[i] == glm::vec3(1.0f))
            CHECK(glm::all(glm::lessThan(glm::abs(lmm.pixels[i] - express.pixels[i]), glm::vec3(0.02f))));
}

TEST_CASE("lightmesh-render compare: by default the cache beside hard shadows, rays to lamps and a mesh") {
    const TemporaryFolder folder;
    const Finished ran = render(folder, "compare spheres --light-size 6 --area-samples 64 --width 160 "
                                        "--height 120 --threads 2 -o " +
                                            (folder / "out").string());
    REQUIRE_MESSAGE(ran.status == 0, ran.errors);
    const auto made = [&](const std::string& algorithm) {
        return demo::read_png(folder / ("out/" + algorithm + ".png"));
    };
    for (const char* part :
         {"r 4.5, q 6, g 1.125, lamp radius 6,", "differences are to area", "\ncache ", "\nlinked "})
        CHECK_MESSAGE(ran.output.find(part) != std::string::npos, part);
    // Rays that it takes at points themselves, which nothing keeps, and those that it keeps.
    const auto numbers_of = [&](const std::string& algorithm) {
        std::istringstream row(ran.output.substr(ran.output.find("\n" + algorithm + " ") + 1));
        std::vector<std::string> cells;
        for (std::string cell; cells.size() < 6 && row >> cell;)
            cells.push_back(cell);
        return cells;
    };
    CHECK(ran.output.find("rays from points  rays kept") != std::string::npos);
    REQUIRE(numbers_of("cache").size() == 6);
    CHECK(numbers_of("cache")[4] != "0");
    CHECK(numbers_of("cache")[5].size() > 6);
    CHECK(numbers_of("whitted")[5] == "-");
    // The same lamps: what the cache finds is what rays find.
    const double of_cache = demo::mean_absolute_difference(made("cache"), made("area"));
    CHECK(of_cache < 0.002);
    CHECK(of_cache < 0.3 * demo::mean_absolute_difference(made("whitted"), made("area")));
    CHECK(of_cache < 0.3 * demo::mean_absolute_difference(made("linked"), made("area")));
}

TEST_CASE("lightmesh-render tables: a table of the paper") {
    const TemporaryFolder folder;
    const Finished ran = render(folder, "tables spheres --area-samples 2" + tiny_tables);
    REQUIRE_MESSAGE(ran.status == 0, ran.errors);
    for (const char* part :
         {"spheres, q=6", "r=5.5, map 512, g 1.375", "LMM+ATK", "Express LMM+ATK", "LMM+ATO", "Linked LMM",
          "Whitted (hard)", "area lights", "visibility cache", "(42.6)"})
        CHECK_MESSAGE(ran.output.find(part) != std::string::npos, part);
}

TEST_CASE("lightmesh-render: scenes from files, their lights and cameras") {
    const TemporaryFolder folder;
    folder.write("matt.mtl", "newmtl red\nKd 0.8 0.1 0.1\n");
    const auto obj = folder.write("scene.obj", "mtllib matt.mtl\nusemtl red\n" + triangle_obj);
    const auto ply = folder.write("scene.ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                                               "property float y\nproperty float z\nelement face 2\n"
                                               "property list uchar int vertex_indices\nend_header\n"
                                               "0 0 0\n4 0 0\n0 4 0\n0 0 3\n3 0 1 2\n3 0 1 3\n");
    for (const auto& file : {obj, ply}) {
        CAPTURE(file.string());
        const Finished ran =
            render(folder, "picture " + file.string() + tiny + "-o " + (folder / "p.png").string());
        CHECK_MESSAGE(ran.status == 0, ran.errors);
        CHECK(ran.output.find("note: ") != std::string::npos);  // It has no lights and no camera.
    }
    const Finished many =
        render(folder, "picture " + obj.string() + tiny + "--lights 70 -o " + (folder / "m.png").string());
    CHECK_MESSAGE(many.status == 0, many.errors);
    CHECK(many.output.find("70") != std::string::npos);
}

TEST_CASE("lightmesh-render: bad input gets one line, and leaves nothing behind") {
    const TemporaryFolder folder;
    const std::string nan = folder.write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 4 0\nf 1 2 3\n").string();
    const std::string empty = folder.write("empty.obj", "# nothing\n").string();
    const std::string points = folder.write("points.obj", "v 0 0 0\nv 1 0 0\n").string();
    const std::string format = folder.write("scene.xyz", "1 2 3\n").string();
    const std::string file = folder.write("a_file", "").string();
    check_refused("picture", "scene");
    check_refused("picture no_such_scene", "no_such_scene");
    check_refused("picture no_such_file.obj", "no_such_file.obj");
    check_refused("picture " + nan, "nan.obj");
    check_refused("picture " + empty, "empty.obj");
    check_refused("picture " + points, "points.obj");
    check_refused("picture " + format, "scene.xyz");
    check_refused("picture spheres --radius 0", "radius");
    check_refused("picture spheres --radius nan", "radius");
    check_refused("picture spheres --quality 17", "quality");
    check_refused("picture spheres --quality 0.5", "quality");
    check_refused("picture spheres --lights 0", "lights");
    check_refused("picture spheres --lights -3", "lights");
    check_refused("picture spheres --map-size 0", "map-size");
    check_refused("picture spheres --width 0", "width");
    check_refused("picture spheres --samples 0", "samples");
    check_refused("picture spheres --short-test maybe", "short-test");
    check_refused("picture spheres --light-size 0", "light-size");
    check_refused("picture spheres --spacing nan", "spacing");
    check_refused("picture spheres --detail 7", "detail");
    check_refused("picture spheres --lamp-rays 0", "lamp-rays");
    check_refused("picture spheres --algorithm radiosity", "radiosity");
    check_refused("picture spheres --no-such-option", "no-such-option");
    check_refused("picture spheres --time nan", "nan");
    check_refused("picture spheres --time -1", "-1");
    check_refused("picture spheres --tone bright", "bright");
    check_refused("picture spheres" + tiny + "-o picture.bmp", "picture.bmp");
    check_refused("picture spheres" + tiny + "-o " + file + "/p.png", file);
    check_refused("compare spheres" + tiny + "-o " + file + "/out", file);
    check_refused("compare spheres -o out --algorithms whitted,radiosity", "radiosity");
    check_refused("tables --depth nothing", "depth");
    check_refused("", "subcommand");
}

TEST_CASE("lightmesh-render picture: a second start with what was saved traces no ray for it") {
    const TemporaryFolder folder;
    const std::string mesh = (folder / "spheres.mesh").string();
    const std::string picture = "picture spheres" + tiny;
    const auto row = [](const std::string& output, const std::string& name) {
        const std::size_t line = output.find("\n" + name);
        REQUIRE(line != std::string::npos);
        const std::size_t number = output.find_first_not_of(' ', line + 1 + name.size());
        return output.substr(number, output.find('\n', number) - number);
    };
    for (const std::string algorithm : {"lmm", "linked", "express"}) {
        CAPTURE(algorithm);
        const Finished first = render(folder, picture + "-a " + algorithm + " --save-mesh " + mesh + " -o " +
                                                  (folder / "first.png").string());
        REQUIRE_MESSAGE(first.status == 0, first.errors);
        CHECK(first.output.find("saved: " + mesh) != std::string::npos);
        CHECK(row(first.output, "long rays") != "0");
        const Finished second = render(folder, picture + "-a " + algorithm + " --mesh " + mesh + " -o " +
                                                   (folder / "second.png").string());
        REQUIRE_MESSAGE(second.status == 0, second.errors);
        CHECK(row(second.output, "long rays") == "0");
        CHECK(row(second.output, "link rays") == "0");
        CHECK(row(second.output, "light points") == row(first.output, "light points"));
        CHECK(demo::read_file(folder / "first.png") == demo::read_file(folder / "second.png"));
    }
    const Finished first =
        render(folder, picture + "--save-mesh " + mesh + " -o " + (folder / "first.png").string());
    REQUIRE_MESSAGE(first.status == 0, first.errors);
    const Finished second =
        render(folder, picture + "--mesh " + mesh + " -o " + (folder / "second.png").string());
    REQUIRE_MESSAGE(second.status == 0, second.errors);
    // What is left are rays of points on smooth surfaces of facets: they belong to no record.
    const auto rays_of = [&](const Finished& ran) {
        std::string digits = row(ran.output, "rays to lamps");
        std::erase(digits, ',');
        return std::stoul(digits);
    };
    CHECK(rays_of(second) < rays_of(first) / 10);
    CHECK(row(second.output, "records") == row(first.output, "records"));
    CHECK(demo::read_file(folder / "first.png") == demo::read_file(folder / "second.png"));
    check_refused(picture + "--light-size 0.3 --mesh " + mesh, "of size 0.3; give --light-size");
}

TEST_CASE("lightmesh-render picture: a mesh that does not fit gets one line and status 1") {
    const TemporaryFolder folder;
    const std::string mesh = (folder / "spheres.mesh").string();
    const std::string linked = " -a linked" + tiny;
    const Finished saved = render(folder, "picture spheres" + linked + "--save-mesh " + mesh + " -o " +
                                              (folder / "p.png").string());
    REQUIRE_MESSAGE(saved.status == 0, saved.errors);
    CHECK_FALSE(folder.has_part_files());
    std::string bytes = demo::read_file(mesh);
    const std::string cut = folder.write("cut.mesh", bytes.substr(0, bytes.size() / 2)).string();
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    const std::string damaged = folder.write("damaged.mesh", bytes).string();
    const std::string empty = folder.write("empty.mesh", "").string();
    check_refused("picture spheres" + linked + "--mesh no_such.mesh", "no_such.mesh");
    check_refused("picture spheres" + linked + "--mesh " + empty, "empty.mesh");
    check_refused("picture spheres" + linked + "--mesh " + cut, "cut.mesh: --save-mesh has not written it");
    check_refused("picture spheres" + linked + "--mesh " + damaged,
                  "damaged.mesh: lightmesh: not a snapshot");
    check_refused("picture rooms" + linked + "--mesh " + mesh, "spheres.mesh: it is of another scene");
    check_refused("picture spheres --lights 9" + linked + "--mesh " + mesh, "or of other lights");
    check_refused("picture spheres --radius 3" + linked + "--mesh " + mesh, "its radius is");
    check_refused("picture spheres" + tiny + "--mesh " + mesh, "lightmesh: ");
    check_refused("picture spheres -a whitted" + tiny + "--save-mesh a.mesh", "not for whitted");
    check_refused("picture spheres -a linked+map" + tiny + "--mesh " + mesh, "not for linked+map");
}

TEST_CASE("lightmesh-render: a device that is not there is named, and so are those that are") {
    const TemporaryFolder folder;
    const Finished ran = render(folder, "picture spheres -a linked+map --device no_such_device");
    CHECK(ran.status == 1);
    CHECK(
        ran.errors.starts_with("lightmesh-render: Vulkan: no device \"no_such_device\"; there are:\n  0: "));
}

}  // namespace render_program_test
