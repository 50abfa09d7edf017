// SPDX-License-Identifier: MIT

// lightmesh-render film as its users run it.

#include "film_frames.hpp"
#include "gltf_writer.hpp"
#include "image/image.hpp"
#include "render/files.hpp"
#include "run_command.hpp"
#include "temporary_folder.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>

namespace film_program_test {

namespace {

using test::check_frames;
using test::Finished;
using test::frame;
using test::in_seconds;
using test::TemporaryFolder;

/// Four frames a second: frame 3 is at 0.5 s.
const std::string tiny = " --fps 4 --width 48 --height 36 --depth embree --map-size 64 --detail 1 ";

Finished film(const TemporaryFolder& folder, const std::string& arguments) {
    return test::run(folder, LIGHTMESH_RENDER " film " + arguments);
}

void check_refused(const std::string& arguments, const std::string& part, int lines = 1) {
    CAPTURE(arguments);
    const TemporaryFolder folder;
    const Finished ran =
        test::run(folder, "cd " + (folder / "").string() + " && " LIGHTMESH_RENDER " film " + arguments);
    CHECK(ran.status > 0);
    CHECK(std::ranges::count(ran.errors, '\n') == lines);
    CHECK_MESSAGE(ran.errors.find(part) != std::string::npos, ran.errors);
    CHECK(folder.file_count() == 2);  // what was printed
}

/// The last frame of a film with so many is the one of a film that begins there at 1 s, and the one before it
/// is not. `command`: ends with -o, of EXR frames.
void check_last_frame(const TemporaryFolder& folder, const std::string& command, int frames) {
    const Finished all =
        film(folder, command + (folder / "all").string() + " --frames " + std::to_string(frames));
    REQUIRE_MESSAGE(all.status == 0, all.errors);
    const Finished late = film(folder, command + (folder / "late").string() + " --from 1 --frames 1");
    REQUIRE_MESSAGE(late.status == 0, late.errors);
    CHECK(demo::read_file(frame(folder, "all", frames, ".exr")) ==
          demo::read_file(frame(folder, "late", 1, ".exr")));
    CHECK(demo::read_file(frame(folder, "all", frames - 1, ".exr")) !=
          demo::read_file(frame(folder, "late", 1, ".exr")));
}

}  // namespace

TEST_CASE("lightmesh-render film: frames are the same by any number of threads, and from anywhere") {
    const TemporaryFolder folder;
    const std::string spheres = "spheres" + tiny;
    const Finished ran = film(folder, spheres + "--frames 4 --threads 2 -o " + (folder / "a/of/it").string());
    REQUIRE_MESSAGE(ran.status == 0, ran.errors);
    CHECK(ran.errors.empty());
    for (const char* row :
         {"algorithm", "cache", "radius r", "quality q", "spacing g", "lamp radius", "frames rendered", "4",
          "seconds: first frame", "seconds: each frame after it", "frames: "})
        CHECK_MESSAGE(ran.output.find(row) != std::string::npos, row);
    CHECK(std::filesystem::exists(folder / "a/of/it/film.txt"));
    CHECK_FALSE(std::filesystem::exists(frame(folder, "a/of/it", 5)));
    const Finished one =
        film(folder, spheres + "--from 0.5 --frames 2 --threads 1 -o " + (folder / "b").string());
    REQUIRE_MESSAGE(one.status == 0, one.errors);
    CHECK(demo::read_file(frame(folder, "b", 1)) == demo::read_file(frame(folder, "a/of/it", 3)));
    CHECK(demo::read_file(frame(folder, "b", 2)) == demo::read_file(frame(folder, "a/of/it", 4)));
    CHECK(demo::read_file(frame(folder, "b", 1)) != demo::read_file(frame(folder, "b", 2)));
    CHECK_FALSE(folder.has_part_files());
}

TEST_CASE("lightmesh-render film: each scene, by other algorithms too, with linear values") {
    const TemporaryFolder folder;
    for (const std::string scene : {"park -a linked", "rooms -a cache", "spheres -a area"}) {
        CAPTURE(scene);
        const std::string name = scene.substr(0, scene.find(' '));
        const Finished ran = film(folder, scene + tiny + "--frames 2 --from 1 --to 3 --format exr -o " +
                                              (folder / name).string());
        REQUIRE_MESSAGE(ran.status == 0, ran.errors);
        const demo::Image first = demo::read_exr(frame(folder, name, 1, ".exr"));
        const demo::Image second = demo::read_exr(frame(folder, name, 2, ".exr"));
        CHECK(first.width == 48);
        const double change = demo::mean_absolute_difference(first, second);
        CHECK(change > 1e-4);
        CHECK(change < 0.1);
    }
}

TEST_CASE("lightmesh-render film: where nothing moves nothing changes from frame to frame") {
    const TemporaryFolder folder;
    const auto changing = [&](const std::string& algorithm) {
        const Finished ran =
            film(folder, "rooms -a " + algorithm + tiny + "--from 0.5 --frames 2 --format exr -o " +
                             (folder / algorithm).string());
        REQUIRE_MESSAGE(ran.status == 0, ran.errors);
        const demo::Image before = demo::read_exr(frame(folder, algorithm, 1, ".exr"));
        const demo::Image after = demo::read_exr(frame(folder, algorithm, 2, ".exr"));
        std::size_t count = 0;
        for (std::size_t i = 0; i < before.pixels.size(); ++i)
            count += before.pixels[i] != after.pixels[i] ? 1 : 0;
        return count;
    };
    // The rays of each point know best what a door and a lamp in two of the rooms reach.
    const std::size_t reached = changing("area");
    CHECK(reached > 100);
    CHECK(reached < 48 * 36 / 4);
    CHECK(changing("cache") < reached + reached / 2);
}

TEST_CASE("lightmesh-render film: as many frames as there is time, or spread over it") {
    const TemporaryFolder folder;
    const std::string rooms = "rooms -a whitted --fps 4 --width 16 --height 12 --format exr -o ";
    struct Film {
        const char* name;
        const char* options;
        int frames;
    };
    // The animation ends at 8 s.
    for (const Film& which :
         {Film{"to", "--to 0.75", 3}, Film{"between", "--from 0.5 --to 1", 2}, Film{"end", "--from 7.25", 3},
          Film{"spread", "--from 0.5 --to 1 --frames 4", 4}, Film{"beyond", "--from 7.75 --frames 2", 2}}) {
        CAPTURE(which.options);
        const Finished ran = film(folder, rooms + (folder / which.name).string() + " " + which.options);
        REQUIRE_MESSAGE(ran.status == 0, ran.errors);
        CHECK(std::filesystem::exists(frame(folder, which.name, which.frames, ".exr")));
        CHECK_FALSE(std::filesystem::exists(frame(folder, which.name, which.frames + 1, ".exr")));
    }
    const auto file = [&](const std::string& name, int number) {
        return demo::read_file(frame(folder, name, number, ".exr"));
    };
    CHECK(file("to", 3) == file("between", 1));
    CHECK(file("spread", 1) == file("between", 1));
    CHECK(file("spread", 3) == file("between", 2));
    CHECK(file("beyond", 1) == file("end", 3));
}

TEST_CASE("lightmesh-render film: a terminal shows which frame it is, and the time that is left") {
    const TemporaryFolder folder;
    // `script` runs a command in a terminal of its own.
    const auto shown = [&](const std::string& frames) {
        const std::string command = LIGHTMESH_RENDER " film spheres -a whitted" + tiny + "-o " +
                                    (folder / "film").string() + " --frames " + frames;
        const Finished ran = test::run(folder, "script -qec '" + command + "' /dev/null");
        REQUIRE_MESSAGE(ran.status == 0, ran.output);
        return ran.output;
    };
    const std::string all = shown("3");
    for (const char* part : {"frame 1 of 3", " 33 % frame 2 of 3, ", " 66 % frame 3 of 3, ", " s left"})
        CHECK_MESSAGE(all.find(part) != std::string::npos, all);
    // Frames that are there count, but take no time.
    const std::string others = shown("5");
    for (const char* part : {"frame 4 of 5", " 50 % frame 5 of 5, "})
        CHECK_MESSAGE(others.find(part) != std::string::npos, others);
    CHECK(others.find("frame 1 of 5") == std::string::npos);
}

TEST_CASE("lightmesh-render film: a second start goes on, and never with frames of another film") {
    const TemporaryFolder folder;
    const std::string out = (folder / "film").string();
    const std::string spheres = "spheres -a whitted" + tiny + "-o " + out;
    REQUIRE(film(folder, spheres + " --frames 2").status == 0);
    const auto written = std::filesystem::last_write_time(frame(folder, "film", 1));
    const std::string third = demo::read_file(frame(folder, "film", 2));
    const Finished longer = film(folder, spheres + " --frames 4 --threads 1");
    REQUIRE_MESSAGE(longer.status == 0, longer.errors);
    CHECK(longer.output.find("2 of 4 frames are there already and stay") != std::string::npos);
    CHECK(std::filesystem::last_write_time(frame(folder, "film", 1)) == written);

    // Half a frame is none, and one of another size neither.
    const std::string whole = demo::read_file(frame(folder, "film", 3));
    folder.write("film/frame-0003.png", whole.substr(0, whole.size() / 2));
    folder.write("film/frame-0003.png.part2147483000", "of a program that was killed");
    const Finished mended = film(folder, spheres + " --frames 4");
    CHECK(mended.output.find("3 of 4 frames are there already and stay") != std::string::npos);
    CHECK(demo::read_file(frame(folder, "film", 3)) == whole);
    CHECK_FALSE(folder.has_part_files());

    const Finished other = film(folder, spheres + " --frames 4 --samples 2 --from 1");
    CHECK(other.status == 1);
    CHECK_MESSAGE(other.errors.find(out +
                                    " holds frames of another film: from is 0 there and 1 here, samples "
                                    "is 1 there and 2 here; --overwrite removes them") != std::string::npos,
                  other.errors);
    CHECK(std::filesystem::last_write_time(frame(folder, "film", 1)) == written);
    std::filesystem::remove(folder / "film/film.txt");
    CHECK(film(folder, spheres + " --frames 4").errors.find("there is no film.txt") != std::string::npos);

    const Finished anew = film(folder, spheres + " --frames 3 --samples 2 --overwrite");
    REQUIRE_MESSAGE(anew.status == 0, anew.errors);
    CHECK(anew.output.find("stay") == std::string::npos);
    CHECK(demo::read_file(frame(folder, "film", 3)) != whole);
    CHECK_FALSE(std::filesystem::exists(frame(folder, "film", 4)));
}

TEST_CASE("lightmesh-render film: Ctrl-C keeps whole frames, and the same command goes on") {
    const TemporaryFolder folder;
    const std::string out = (folder / "film").string();
    const std::string command = LIGHTMESH_RENDER " film spheres" + tiny + "--frames 12 --threads 1 -o " + out;
    const Finished stopped = test::run(folder, command + " & p=$!; while kill -0 $p && [ ! -s " + out +
                                                   "/frame-0002.png ]; do sleep 0.01; done; kill -INT $p; "
                                                   "wait $p");
    CHECK(stopped.status == 130);
    CHECK(stopped.errors.find("interrupted: whole frames stay") != std::string::npos);
    CHECK_FALSE(folder.has_part_files());
    CHECK_FALSE(std::filesystem::exists(folder / "film/frame-0012.png"));
    const Finished on = test::run(folder, command);
    REQUIRE_MESSAGE(on.status == 0, on.errors);
    CHECK(on.output.find("of 12 frames are there already and stay") != std::string::npos);
    const Finished alone =
        film(folder, "spheres" + tiny + "--frames 1 --from 2.75 -o " + (folder / "last").string());
    REQUIRE_MESSAGE(alone.status == 0, alone.errors);
    CHECK(demo::read_file(frame(folder, "last", 1)) == demo::read_file(folder / "film/frame-0012.png"));
}

TEST_CASE(
    "lightmesh-render film: killed at any moment, it leaves whole frames, and the same command goes on") {
    const TemporaryFolder folder;
    const std::string spheres = "spheres" + tiny + "--frames 8 --threads 1 -o ";
    REQUIRE(film(folder, spheres + (folder / "whole").string()).status == 0);
    // So many milliseconds after a file is there: within the work on a frame, and between two.
    int killed = 0;
    int unfinished = 0;
    for (const auto& moment : {std::pair("film.txt", 0),
                               {"frame-0001.png", 0},
                               {"frame-0001.png", 7},
                               {"frame-0002.png", 15},
                               {"frame-0003.png", 24},
                               {"frame-0004.png", 38},
                               {"frame-0005.png", 1}}) {
        const std::string file = moment.first;
        const int milliseconds = moment.second;
        CAPTURE(file);
        const std::string name = "killed" + std::to_string(killed++);
        const std::string out = (folder / name).string();
        const std::string command = LIGHTMESH_RENDER " film " + spheres + out;
        test::run(folder, command + " & p=$!; while kill -0 $p && [ ! -e " + out + "/" + file +
                              " ]; do :; done; sleep " + in_seconds(milliseconds) +
                              "; kill -KILL $p; wait $p");
        // On a fast machine the film may be done before some of the later moments.
        unfinished += check_frames(folder, name, "whole", 8) < 8 ? 1 : 0;
        const Finished on = test::run(folder, command);
        REQUIRE_MESSAGE(on.status == 0, on.errors);
        CHECK(check_frames(folder, name, "whole", 8) == 8);
        CHECK_FALSE(folder.has_part_files());
    }
    CHECK(unfinished > 0);
}

TEST_CASE("lightmesh-render film --memory: what goes unused is forgotten, and the pictures are the same") {
    const TemporaryFolder folder;
    for (const std::string algorithm : {"cache --memory 0.9", "linked --memory 0.4"}) {
        CAPTURE(algorithm);
        const std::string name = algorithm.substr(0, algorithm.find(' '));
        const std::string park = "park --moving camera --lights 6 -r 3 --fps 1 --frames 6 --width 48 "
                                 "--height 36 --detail 1 --threads 1 -o ";
        const Finished all = film(folder, park + (folder / (name + "-all")).string() + " -a " + name);
        REQUIRE_MESSAGE(all.status == 0, all.errors);
        CHECK(all.output.find("memory of the") != std::string::npos);
        CHECK(all.output.find("forgotten for memory") == std::string::npos);
        const Finished some = film(folder, park + (folder / name).string() + " -a " + algorithm);
        REQUIRE_MESSAGE(some.status == 0, some.errors);
        const std::string row = "forgotten for memory";
        const std::size_t at = some.output.find(row);
        REQUIRE_MESSAGE(at != std::string::npos, some.output);
        CHECK(std::stoi(some.output.substr(at + row.size())) > 0);
        for (int number = 1; number <= 6; ++number)
            CHECK(demo::read_file(frame(folder, name, number)) ==
                  demo::read_file(frame(folder, name + "-all", number)));
    }
}

TEST_CASE("lightmesh-render film --on gpu: the pictures of picture --on gpu, from anywhere, and it goes on") {
    const TemporaryFolder folder;
    const std::string out = (folder / "film").string();
    const std::string spheres = "spheres -a whitted --on gpu" + tiny + "-o " + out;
    const Finished begun = film(folder, spheres + " --frames 2");
    REQUIRE_MESSAGE(begun.status == 0, begun.errors);
    for (const char* row :
         {"device", "seconds: in shaders, each frame", "frames rendered", "rays for shadows"})
        CHECK_MESSAGE(begun.output.find(row) != std::string::npos, row);
    const Finished on = film(folder, spheres + " --frames 4");
    REQUIRE_MESSAGE(on.status == 0, on.errors);
    CHECK(on.output.find("2 of 4 frames are there already and stay") != std::string::npos);
    const Finished late = film(folder, "spheres -a whitted --on gpu --from 0.75 --frames 1" + tiny + "-o " +
                                           (folder / "late").string());
    REQUIRE_MESSAGE(late.status == 0, late.errors);
    CHECK(demo::read_file(frame(folder, "late", 1)) == demo::read_file(frame(folder, "film", 4)));
    const Finished picture =
        test::run(folder, LIGHTMESH_RENDER " picture spheres -a whitted --on gpu --width 48 --height 36 -o " +
                              (folder / "still.png").string());
    REQUIRE_MESSAGE(picture.status == 0, picture.errors);
    for (const char* row : {"radius r", "quality q", "spacing g", "lamp radius"}) {
        CHECK_MESSAGE(begun.output.find(row) != std::string::npos, row);
        CHECK_MESSAGE(picture.output.find(row) != std::string::npos, row);
    }
    CHECK(demo::read_file(folder / "still.png") == demo::read_file(frame(folder, "film", 1)));
    const Finished by_cpu = film(folder, "spheres -a whitted --frames 4" + tiny + "-o " + out);
    CHECK(by_cpu.status == 1);
    CHECK_MESSAGE(by_cpu.errors.find("there and the CPU here; --overwrite removes them") != std::string::npos,
                  by_cpu.errors);
}

TEST_CASE(
    "lightmesh-render film --on gpu: frames are the same from anywhere, by light through many panes too") {
    const TemporaryFolder folder;
    test::GltfFile file;
    file.add("SCALAR", {0, 1});
    // Apart from each other, then above each other: trees that are built then have other shapes.
    file.add("VEC3", {-3, -3, 2, -1.5f, -1.5f, 0.5f});
    file.add("VEC3", {2, 1, 0.5f, -1.4f, -1.5f, 1.25f});
    file.add("VEC3", {-3, 1, 1, -1.3f, -1.5f, 0.75f});
    file.add("VEC3", {1, -3, 1.5f, -1.2f, -1.5f, 1.5f});
    file.add("VEC3", {-1, 2, 0.75f, -1.1f, -1.5f, 1});
    std::string nodes =
        R"({"children":[1,2,3,4,5,6,7,8]},{"mesh":0,"translation":[-4,-4,0],"scale":[12,12,12]},
        {"camera":0,"translation":[0,0,7]},
        {"translation":[0.3,0.2,4],"extensions":{"KHR_lights_punctual":{"light":0}}})";
    std::string meshes = R"({"primitives":[{"attributes":{"POSITION":0},"material":0}]})";
    std::string materials = R"({"pbrMetallicRoughness":{"metallicFactor":0}})";
    std::string samplers;
    std::string channels;
    for (int pane = 0; pane < 5; ++pane) {
        const std::string number = std::to_string(pane);
        const std::string next = std::to_string(pane + 1);
        nodes += R"(,{"scale":[4,4,4],"mesh":)" + next + "}";
        meshes += R"(,{"primitives":[{"attributes":{"POSITION":0},"material":)" + next + "}]}";
        materials +=
            R"(,{"alphaMode":"BLEND","pbrMetallicRoughness":{"metallicFactor":0,"baseColorFactor":[1,1,1,)" +
            std::to_string(0.1 + 0.07 * pane) + "]}}";
        samplers += (pane == 0 ? "" : ",") + (R"({"input":1,"output":)" + std::to_string(pane + 2) + "}");
        channels += (pane == 0 ? "" : ",") + (R"({"sampler":)" + number) +
                    R"(,"target":{"path":"translation","node":)" + std::to_string(pane + 4) + "}}";
    }
    const std::string scene =
        file.write(folder, R"("cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}}],
                "extensionsUsed":["KHR_lights_punctual"],
                "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":300}]}},
                "nodes":[)" + nodes +
                               R"(],"meshes":[)" + meshes + R"(],"materials":[)" + materials +
                               R"(],"animations":[{"samplers":[)" + samplers + R"(],"channels":[)" +
                               channels + "]}]")
            .string();
    const std::string command =
        scene + " --on gpu -a whitted --fps 1 --width 48 --height 36 --samples 1 --format exr -o ";
    check_last_frame(folder, command, 2);
}

TEST_CASE("lightmesh-render film --on gpu: things move among many lights of small ranges, by a light mesh") {
    const TemporaryFolder folder;
    test::GltfFile file;
    file.add("SCALAR", {0, 1});
    file.add("VEC3", {-2, -2, 0, 1.5f, 0.3f, 0});
    const std::string standing = R"(,{"mesh":0,"scale":[1.2,1.2,1.2],"rotation":[0.70710678,0,0,0.70710678])";
    std::string nodes = R"({"mesh":0,"translation":[-4,-4,0],"scale":[12,12,12]},
        {"camera":0,"translation":[0,0,7]})" +
                        standing + "}";  // this one moves
    for (const char* place : {"[1,0,0]", "[-1,1.5,0]", "[2,-2,0]"})
        nodes += standing + R"(,"translation":)" + place + "}";
    for (int light = 0; light < 16; ++light)
        nodes += R"(,{"extensions":{"KHR_lights_punctual":{"light":0}},"translation":[)" +
                 std::to_string(1.5 * (light % 4) - 2.25) + "," + std::to_string(1.5 * (light / 4) - 2.25) +
                 ",0.9]}";
    std::string children = "1";
    for (int node = 2; node <= 22; ++node)
        children += "," + std::to_string(node);
    const std::string scene =
        file.write(folder, R"("cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}}],
                "extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":
                [{"type":"point","intensity":30,"range":1.7}]}},"materials":[{"doubleSided":true}],
                "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
                "animations":[{"samplers":[{"input":1,"output":2}],
                "channels":[{"sampler":0,"target":{"path":"translation","node":3}}]}],
                "nodes":[{"children":[)" +
                               children + "]}," + nodes + "]")
            .string();
    const std::string command = scene + " --on gpu -a linked --radius 0.8 --fps 2 --width 32 --height 24"
                                        " --samples 1 --format exr -o ";
    check_last_frame(folder, command, 3);
}

TEST_CASE("lightmesh-render film --on gpu --memory: meshes forget between frames, and the pictures stay") {
    const TemporaryFolder folder;
    const std::string command = "spheres -a express --on gpu --fps 2 --frames 3 --width 24 --height 18 -o ";
    const Finished all = film(folder, command + (folder / "all").string());
    REQUIRE_MESSAGE(all.status == 0, all.errors);
    CHECK(all.output.find("memory of the mesh") != std::string::npos);
    CHECK(all.output.find("bricks forgotten for memory") == std::string::npos);
    const Finished few = film(folder, command + (folder / "few").string() + " --memory 0.1");
    REQUIRE_MESSAGE(few.status == 0, few.errors);
    const std::size_t row = few.output.find("bricks forgotten for memory");
    REQUIRE(row != std::string::npos);
    CHECK(std::stoi(few.output.substr(few.output.find_first_of("0123456789", row))) > 0);
    for (int number = 1; number <= 3; ++number)
        CHECK(demo::read_file(frame(folder, "all", number)) == demo::read_file(frame(folder, "few", number)));
}

TEST_CASE("lightmesh-render film --on gpu: Ctrl-C keeps whole frames, and the same command goes on") {
    const TemporaryFolder folder;
    const std::string out = (folder / "film").string();
    const std::string command =
        LIGHTMESH_RENDER " film spheres --on gpu -a cache --no-shaft-rows" + tiny + "--frames 3 -o " + out;
    const Finished stopped = test::run(folder, command + " & p=$!; while kill -0 $p && [ ! -s " + out +
                                                   "/frame-0001.png ]; do sleep 0.01; done; kill -INT $p; "
                                                   "wait $p");
    CHECK(stopped.status == 130);
    CHECK(stopped.errors.find("interrupted: whole frames stay") != std::string::npos);
    CHECK_FALSE(folder.has_part_files());
    CHECK_FALSE(std::filesystem::exists(folder / "film/frame-0003.png"));
    const Finished on = test::run(folder, command);
    REQUIRE_MESSAGE(on.status == 0, on.errors);
    CHECK(on.output.find("of 3 frames are there already and stay") != std::string::npos);
}

TEST_CASE("lightmesh-render film: MP4 by ffmpeg, which is named where it is not there") {
    const TemporaryFolder folder;
    const std::string arguments =
        "spheres -a whitted" + tiny + "--frames 2 -o " + (folder / "out/ball.mp4").string();
    const Finished without = test::run(folder, "PATH=/nowhere " LIGHTMESH_RENDER " film " + arguments);
    CHECK(without.status == 1);
    CHECK_MESSAGE(without.errors.find("made by ffmpeg, which is not installed") != std::string::npos,
                  without.errors);
    CHECK_FALSE(std::filesystem::exists(folder / "out"));

    // One that writes down what it is asked for.
    const auto script = folder.write("ffmpeg", "#!/bin/sh\nfor file; do :; done\necho \"$@\" >\"$file\"\n");
    std::filesystem::permissions(script, std::filesystem::perms::owner_all);
    const std::string in_path = "PATH=" + (folder / "").string() + ":$PATH " LIGHTMESH_RENDER " film ";
    const Finished made = test::run(folder, in_path + arguments);
    REQUIRE_MESSAGE(made.status == 0, made.errors);
    CHECK(made.output.find("film: " + (folder / "out/ball.mp4").string()) != std::string::npos);
    CHECK(std::filesystem::exists(frame(folder, "out/ball-frames", 2)));
    const std::string asked = demo::read_file(folder / "out/ball.mp4");
    for (const std::string& part :
         {std::string("-framerate 4 "), (folder / "out/ball-frames/frame-%04d.png").string(),
          std::string("-frames:v 2 ")})
        CHECK_MESSAGE(asked.find(part) != std::string::npos, asked);

    folder.write("ffmpeg", "#!/bin/sh\nexit 3\n");
    const Finished failed = test::run(folder, in_path + arguments);
    CHECK(failed.status == 1);
    CHECK_MESSAGE(failed.errors.find("ended with status 3; the frames are there") != std::string::npos,
                  failed.errors);
    CHECK(demo::read_file(folder / "out/ball.mp4") == asked);
    CHECK_FALSE(folder.has_part_files());
}

TEST_CASE("lightmesh-render film: what ffmpeg makes has all frames, at their size and rate") {
    const TemporaryFolder folder;
    if (test::run(folder, "command -v ffmpeg && command -v ffprobe").status != 0) {
        MESSAGE("there is no ffmpeg: no film is made by it");
        return;
    }
    const std::string movie = "'" + (folder / "ball 100%.mp4").string() + "'";
    // H.264 has even sides only.
    const Finished made =
        film(folder, "spheres -a whitted --fps 4 --width 47 --height 36 --frames 3 -o " + movie);
    REQUIRE_MESSAGE(made.status == 0, made.errors);
    const Finished looked =
        test::run(folder, "ffprobe -v error -count_frames -show_entries stream=codec_name,"
                          "width,height,r_frame_rate,pix_fmt,nb_read_frames -of default=nw=1 " +
                              movie);
    REQUIRE_MESSAGE(looked.status == 0, looked.errors);
    for (const char* part : {"codec_name=h264", "width=48", "height=36", "pix_fmt=yuv420p",
                             "r_frame_rate=4/1", "nb_read_frames=3"})
        CHECK_MESSAGE(looked.output.find(part) != std::string::npos, looked.output);
    CHECK_FALSE(folder.has_part_files());
}

TEST_CASE("lightmesh-render film: bad input gets one line, and leaves nothing behind") {
    check_refused("", "scene");
    check_refused("street" + tiny, "street stands still");
    check_refused("no_such_file.glb" + tiny, "no_such_file.glb");
    check_refused("spheres --frames 0", "frames");
    check_refused("spheres --fps 0", "fps");
    check_refused("spheres --fps nan", "fps");
    check_refused("spheres --from -1", "from");
    check_refused("spheres --from 3 --to 2", "--from 3 is not before --to 2");
    check_refused("spheres --from 7", "--from 7 is not before the end of the animation, 6");
    check_refused("spheres --memory 0", "0 is not a finite number above 0");
    check_refused("spheres --memory nan", "nan is not a finite number above 0");
    check_refused("spheres --time 1", "--time is of still pictures");
    check_refused("spheres --moving walls", "walls");
    check_refused("spheres -o film.png", "a film goes into a folder");
    check_refused("spheres --format exr -o film.mp4", "made of PNG files");
    check_refused("spheres --format bmp", "bmp");
    check_refused("spheres --on gpu --device none-such", "no device \"none-such\"", 2);
    check_refused("spheres --on fpga", "fpga");
}

}  // namespace film_program_test
