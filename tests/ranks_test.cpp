// SPDX-License-Identifier: MIT

// lightmesh-render by several ranks of MPI, all on this machine.

#include "film_frames.hpp"
#include "gltf_writer.hpp"
#include "render/files.hpp"
#include "render/ranks.hpp"
#include "render/runs.hpp"
#include "render/share_out.hpp"
#include "run_command.hpp"
#include "temporary_folder.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace ranks_test {

namespace {

using test::check_frames;
using test::Finished;
using test::frame;
using test::in_seconds;
using test::TemporaryFolder;

/// More ranks than cores, as any user: the message about a status that is not 0 goes.
const std::string mpirun_that_tells = LIGHTMESH_MPIRUN
    " --allow-run-as-root --oversubscribe --bind-to none --mca btl_vader_single_copy_mechanism none ";
const std::string mpirun = mpirun_that_tells + "--quiet ";
const std::string tiny = " --fps 4 --width 80 --height 60 --detail 1 --threads 1 ";

Finished by_ranks(const TemporaryFolder& folder, int ranks, const std::string& arguments) {
    return test::run(folder, mpirun + "-n " + std::to_string(ranks) + " " LIGHTMESH_RENDER " " + arguments);
}

/// A rank writes down the number of its process, then becomes the program.
std::string with_pid(const TemporaryFolder& folder, const std::string& arguments) {
    return "sh -c 'echo $$ >" + (folder / "pid-").string() +
           "$OMPI_COMM_WORLD_RANK; exec " LIGHTMESH_RENDER " " + arguments + "'";
}

/// Runs a film by two ranks and sends a signal to the second one when two frames are there.
Finished stopped_by(const TemporaryFolder& folder, const std::string& signal, const std::string& film) {
    return test::run(folder, mpirun_that_tells + "-n 2 " + with_pid(folder, film) +
                                 " & p=$!; while kill -0 $p && [ ! -s " + frame(folder, "film", 2) +
                                 " ]; do sleep 0.01; done; kill -" + signal + " $(cat " +
                                 (folder / "pid-1").string() + "); wait $p");
}

}  // namespace

TEST_CASE("things are shared out in runs of neighbours, each once, whoever asks") {
    demo::Runs runs(10, 2);
    CHECK(runs.next(0) == 0);
    CHECK(runs.next(1) == 5);
    for (const std::size_t mine : {1, 2, 3, 4})
        CHECK(runs.next(0) == mine);
    CHECK(runs.next(0) == 8);  // the back half of what rank 1 has left
    CHECK(runs.next(1) == 6);
    CHECK(runs.next(0) == 9);
    CHECK(runs.next(0) == 7);
    CHECK_FALSE(runs.next(0));
    CHECK_FALSE(runs.next(1));
    CHECK_FALSE(demo::Runs(0, 3).next(2));

    for (const int ranks : {1, 3, 8}) {
        demo::Runs more(7, ranks);
        std::vector<int> taken(7);
        int rank = 0;
        while (const std::optional<std::size_t> next = more.next(rank = (5 * rank + 2) % ranks))
            ++taken[*next];
        CHECK(taken == std::vector<int>(7, 1));
    }
}

TEST_CASE("work that never looks is told by a thread that it is in vain, and what fails is thrown") {
    demo::Ranks ranks;
    std::atomic<bool> is_over = false;
    demo::WorkWatch watch(ranks, &is_over);
    bool was_in_vain = true;
    watch.look_during([&] { was_in_vain = watch.is_in_vain(); });
    CHECK_FALSE(was_in_vain);
    CHECK_FALSE(watch.is_in_vain());
    watch.look_during([&] {
        is_over = true;
        const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
        while (!watch.is_in_vain() && std::chrono::steady_clock::now() < end)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
    CHECK(watch.is_in_vain());
    CHECK_THROWS_AS(watch.look_during([] { throw std::length_error("of work"); }), std::length_error);
}

TEST_CASE("key frames halve what lies between those before, until there is one for each rank") {
    using Steps = std::vector<std::vector<std::size_t>>;
    CHECK(demo::key_steps(8, 4) == Steps{{0}, {4}, {2, 6}});
    CHECK(demo::key_steps(8, 1) == Steps{{0}});
    CHECK(demo::key_steps(2, 4) == Steps{{0}, {1}});
    CHECK(demo::key_steps(0, 4).empty());
}

TEST_CASE("lightmesh-render by ranks: films are the same to the bit") {
    const TemporaryFolder folder;
    const std::string spheres = "film spheres" + tiny + "--frames 6 -o ";
    REQUIRE(test::run(folder, LIGHTMESH_RENDER " " + spheres + (folder / "alone").string()).status == 0);
    for (const int ranks : {1, 2, 4}) {
        CAPTURE(ranks);
        const std::string name = "by-" + std::to_string(ranks);
        const Finished ran = by_ranks(folder, ranks, spheres + (folder / name).string());
        REQUIRE_MESSAGE(ran.status == 0, ran.errors);
        for (int number = 1; number <= 6; ++number)
            CHECK(demo::read_file(frame(folder, name, number)) ==
                  demo::read_file(frame(folder, "alone", number)));
        CHECK((ran.output.find("rank 0: frames, and rays for shadows") != std::string::npos) == (ranks > 1));
        CHECK((ran.output.find("rank 3: frames, and rays for shadows") != std::string::npos) == (ranks > 3));
        CHECK(ran.output.find("rank 4") == std::string::npos);
        CHECK_FALSE(folder.has_part_files());
    }
    // A light mesh; what was there stays.
    const std::string rooms = "film rooms -a linked" + tiny + "--format exr -o ";
    REQUIRE(
        test::run(folder, LIGHTMESH_RENDER " " + rooms + (folder / "mesh").string() + " --frames 4").status ==
        0);
    REQUIRE(by_ranks(folder, 2, rooms + (folder / "mesh-by-2").string() + " --frames 3").status == 0);
    const Finished on = by_ranks(folder, 2, rooms + (folder / "mesh-by-2").string() + " --frames 4");
    REQUIRE_MESSAGE(on.status == 0, on.errors);
    CHECK(on.output.find("3 of 4 frames are there already and stay") != std::string::npos);
    for (int number = 1; number <= 4; ++number)
        CHECK(demo::read_file(frame(folder, "mesh-by-2", number, ".exr")) ==
              demo::read_file(frame(folder, "mesh", number, ".exr")));
}

TEST_CASE("lightmesh-render by ranks: a short take between key frames is made together, frame by frame") {
    const TemporaryFolder folder;
    test::GltfFile file;
    file.add("SCALAR", {0, 8, 10});
    file.add("VEC3", {0, 0, 7, 20, 0, 7, 0, 0, 7});
    const std::string standing = R"(,{"mesh":0,"rotation":[0.70710678,0,0,0.70710678],"translation":)";
    const std::string lamp = R"(,{"extensions":{"KHR_lights_punctual":{"light":0}},"translation":)";
    const std::string nodes = R"({"children":[1,2,3,4,5,6]},{"camera":0},
        {"mesh":0,"translation":[-20,-20,0],"scale":[80,80,1]})" +
                              standing + "[0,0,0]}" + standing + "[20,0,0]}" + lamp + "[0.5,1.5,2]}" + lamp +
                              "[20.5,1.5,3]}";
    const std::string scene =
        file.write(folder, R"("cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}}],
                "extensionsUsed":["KHR_lights_punctual"],"extensions":{"KHR_lights_punctual":{"lights":
                [{"type":"point","intensity":300}]}},"materials":[{"doubleSided":true}],
                "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
                "animations":[{"samplers":[{"input":1,"output":2,"interpolation":"STEP"}],
                "channels":[{"sampler":0,"target":{"path":"translation","node":1}}]}],
                "nodes":[)" + nodes +
                               "]")
            .string();
    const std::string film = "film " + scene + " --fps 1 --frames 12 --width 80 --height 60 --threads 1 -o ";
    REQUIRE(test::run(folder, LIGHTMESH_RENDER " " + film + (folder / "alone").string()).status == 0);
    const Finished ran = by_ranks(folder, 2, film + (folder / "by-2").string());
    REQUIRE_MESSAGE(ran.status == 0, ran.errors);
    for (int number = 1; number <= 12; ++number) {
        const std::string name =
            std::string("frame-00") + (number < 10 ? "0" : "") + std::to_string(number) + ".png";
        CHECK(demo::read_file(folder / ("by-2/" + name)) == demo::read_file(folder / ("alone/" + name)));
    }
    // The first one, the seventh, and the two of the take.
    const std::string row = "frames by all ranks together";
    const std::size_t at = ran.output.find(row);
    REQUIRE_MESSAGE(at != std::string::npos, ran.output);
    CHECK_MESSAGE(std::stoi(ran.output.substr(at + row.size())) == 4, ran.output);
}

TEST_CASE("lightmesh-render by ranks: killed at any moment, whichever rank, whole frames stay") {
    const TemporaryFolder folder;
    const std::string spheres = "film spheres" + tiny + "--frames 8 -o ";
    REQUIRE(test::run(folder, LIGHTMESH_RENDER " " + spheres + (folder / "whole").string()).status == 0);
    struct Moment {
        const char* file;  ///< that is there
        int milliseconds;  ///< after it
        int rank;
    };
    // In the frame that all make together, after it, while frames are shared out.
    int unfinished = 0;
    int killed = 0;
    for (const Moment& moment :
         {Moment{"film.txt", 0, 1}, Moment{"film.txt", 60, 0}, Moment{"frame-0001.png", 0, 1},
          Moment{"frame-0001.png", 9, 0}, Moment{"frame-0002.png", 3, 1}, Moment{"frame-0003.png", 0, 0}}) {
        CAPTURE(std::string(moment.file));
        CAPTURE(moment.rank);
        const std::string name = "killed" + std::to_string(killed++);
        const std::string out = (folder / name).string();
        const std::string pid = (folder / "pid-").string() + std::to_string(moment.rank);
        std::filesystem::remove(pid);
        const Finished ran = test::run(
            folder, mpirun_that_tells + "-n 2 " + with_pid(folder, spheres + out) +
                        " & p=$!; while kill -0 $p && { [ ! -e " + out + "/" + moment.file + " ] || [ ! -s " +
                        pid + " ]; }; do sleep 0.002; done; sleep " + in_seconds(moment.milliseconds) +
                        "; kill -KILL $(cat " + pid + "); wait $p");
        // On a fast machine the film may be done before some of the later moments.
        if (check_frames(folder, name, "whole", 8) < 8) {
            ++unfinished;
            CHECK(ran.status > 0);
            const std::string said = ran.errors + ran.output;
            CHECK_MESSAGE(said.find("rank " + std::to_string(moment.rank)) != std::string::npos, said);
            CHECK_MESSAGE(said.find("signal 9") != std::string::npos, said);
        }
        const Finished on = by_ranks(folder, 2, spheres + out);
        REQUIRE_MESSAGE(on.status == 0, on.errors);
        CHECK(check_frames(folder, name, "whole", 8) == 8);
        CHECK_FALSE(folder.has_part_files());
    }
    CHECK(unfinished > 0);
}

TEST_CASE("lightmesh-render by ranks: a picture, and all that was found for it, is the same to the bit") {
    const TemporaryFolder folder;
    const auto arguments = [&](const std::string& algorithm, const std::string& name) {
        return "picture rooms --width 100 --height 70 --detail 1 --threads 1 -a " + algorithm + " -o " +
               (folder / (name + ".exr")).string() + " --save-mesh " + (folder / (name + ".mesh")).string();
    };
    for (const std::string algorithm : {"cache", "linked"}) {
        CAPTURE(algorithm);
        REQUIRE(test::run(folder, LIGHTMESH_RENDER " " + arguments(algorithm, "alone")).status == 0);
        const Finished ran = by_ranks(folder, 3, arguments(algorithm, "by-3"));
        REQUIRE_MESSAGE(ran.status == 0, ran.errors);
        for (const char* extension : {".exr", ".mesh"})
            CHECK(demo::read_file(folder / (std::string("by-3") + extension)) ==
                  demo::read_file(folder / (std::string("alone") + extension)));
    }
    const Finished refused = by_ranks(folder, 2, "compare rooms -o " + (folder / "sheet").string());
    CHECK(refused.status == 1);
    CHECK_MESSAGE(refused.errors == "lightmesh-render: compare runs in one process, not in 2; film and "
                                    "picture share their work out\n",
                  refused.errors);
}

TEST_CASE("lightmesh-render by ranks --on gpu: frames and parts of pictures are those of one process") {
    const TemporaryFolder folder;
    const auto run_both = [&](const std::string& arguments, const std::string& extension) {
        CAPTURE(arguments);
        const auto named = [&](const char* name) {
            return arguments + " -o " + (folder / (name + extension)).string();
        };
        const Finished alone = test::run(folder, LIGHTMESH_RENDER " " + named("alone"));
        REQUIRE_MESSAGE(alone.status == 0, alone.errors);
        const Finished ran = by_ranks(folder, 2, named("by-2"));
        REQUIRE_MESSAGE(ran.status == 0, ran.errors);
        return ran.output;
    };
    const std::string small = " --on gpu --width 24 --height 17 --threads 1";
    const std::string found = run_both("film spheres -a express --fps 2 --frames 5 --format exr" + small, "");
    for (int number = 1; number <= 5; ++number) {
        const std::string name = "frame-000" + std::to_string(number) + ".exr";
        CHECK(demo::read_file(folder / "alone" / name) == demo::read_file(folder / "by-2" / name));
    }
    // A frame of each rank, then what is known of both, then the others.
    const std::size_t row = found.find("\nmerges ");
    REQUIRE(row != std::string::npos);
    CHECK(std::stoi(found.substr(found.find_first_of("0123456789", row))) == 1);

    const std::string parts = run_both("picture spheres -a shadow-volume" + small, ".exr");
    CHECK(demo::read_file(folder / "alone.exr") == demo::read_file(folder / "by-2.exr"));
    CHECK(parts.find("ranks, whose points and rays are summed") != std::string::npos);

    const auto with_mesh = [&](const std::string& name) {
        return "picture spheres -a express" + small + " -o " + (folder / (name + ".exr")).string() +
               " --save-mesh " + (folder / (name + ".mesh")).string();
    };
    REQUIRE(test::run(folder, LIGHTMESH_RENDER " " + with_mesh("alone")).status == 0);
    REQUIRE(by_ranks(folder, 2, with_mesh("by-2")).status == 0);
    for (const char* extension : {".exr", ".mesh"})
        CHECK(demo::read_file(folder / (std::string("alone") + extension)) ==
              demo::read_file(folder / (std::string("by-2") + extension)));
}

TEST_CASE("lightmesh-render by ranks: rank 0 says which rank has failed and why, and whole frames stay") {
    const TemporaryFolder folder;
    const std::string film =
        "film spheres --fps 4 --width 80 --height 60 --detail 1 --frames 6 -o " + (folder / "film").string();
    const auto check_fails = [&](const std::string& first, const std::string& second,
                                 const std::string& errors) {
        const Finished ran = test::run(folder, mpirun + "-n 1 " LIGHTMESH_RENDER " " + first +
                                                   " : -n 1 " LIGHTMESH_RENDER " " + second);
        CHECK(ran.status == 1);
        CHECK_MESSAGE(ran.errors == "lightmesh-render: rank 1 of 2" + errors + "\n", ran.errors);
        CHECK_FALSE(folder.has_part_files());
        CHECK_FALSE(std::filesystem::exists(frame(folder, "film", 2)));
    };
    // Before it has begun to render, or in the middle of it.
    check_fails(film, "film nothing.glb", ": nothing.glb: no such file, and no built-in scene of that name");
    check_fails(film, film + " --samples 2", " has another film than rank 0: samples is 2 there and 1 here");
    check_fails(film + " --threads 1", film + " --threads 5000", ": threads must be in [0, 4096], not 5000");
    check_fails("picture spheres -o " + (folder / "film.png").string(),
                "picture rooms -o " + (folder / "film.png").string(), " has another scene than rank 0");
}

TEST_CASE("lightmesh-render by ranks: one that is stopped or killed stops all, and the film can go on") {
    const TemporaryFolder folder;
    const std::string film = "film spheres" + tiny + "--frames 40 --to 5 -o " + (folder / "film").string();
    const Finished stopped = stopped_by(folder, "TERM", film);
    CHECK(stopped.status == 130);
    CHECK_MESSAGE(stopped.errors.find("interrupted: whole frames stay; the same command goes on with the "
                                      "others (rank 1 of 2: ") != std::string::npos,
                  stopped.errors);
    CHECK_FALSE(std::filesystem::exists(folder / "film/frame-0040.png"));
    CHECK_FALSE(folder.has_part_files());

    for (int number = 1; number <= 9; ++number)
        std::filesystem::remove(frame(folder, "film", number));
    const Finished killed = stopped_by(folder, "KILL", film);
    CHECK(killed.status > 0);
    // Rank 0 is told to end, or mpirun ends it and says why.
    const std::string said = killed.errors + killed.output;
    CHECK_MESSAGE((said.find("whole frames stay; the same command goes on with the others (it was told to "
                             "end)") != std::string::npos ||
                   said.find("signal 9") != std::string::npos),
                  said);
    CHECK_FALSE(std::filesystem::exists(folder / "film/frame-0040.png"));
    std::map<std::filesystem::path, std::string> left;
    for (const auto& file : std::filesystem::directory_iterator(folder / "film"))
        if (file.path().extension() == ".png")
            left[file.path()] = demo::read_file(file.path().string());
    CHECK(left.size() > 0);

    const Finished on = by_ranks(folder, 2, film);
    REQUIRE_MESSAGE(on.status == 0, on.errors);
    CHECK(on.output.find(std::to_string(left.size()) + " of 40 frames are there already and stay") !=
          std::string::npos);
    // No half ones are among them, which would have been made again.
    for (const auto& [path, bytes] : left)
        CHECK(demo::read_file(path.string()) == bytes);
    CHECK_FALSE(folder.has_part_files());
    REQUIRE(test::run(folder, LIGHTMESH_RENDER " film spheres" + tiny + "--frames 1 --from 4.875 -o " +
                                  (folder / "last").string())
                .status == 0);
    CHECK(demo::read_file(frame(folder, "last", 1)) == demo::read_file(folder / "film/frame-0040.png"));
}

}  // namespace ranks_test
