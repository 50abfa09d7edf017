// SPDX-License-Identifier: MIT
#include "gpu/compute.hpp"
#include "run_command.hpp"
#include "temporary_folder.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace gpu_faults_test {

/// These tests need a Vulkan driver, which vulkan_faults/layer.cpp makes fail: Mesa's lavapipe will do.

namespace {

/// Renders on a device with a fault, as layer.cpp has it.
test::Finished render(const test::TemporaryFolder& folder, const std::string& algorithm,
                      const std::string& fault, const std::string& more = {}) {
    return test::run(folder, "VK_LAYER_PATH=" LIGHTMESH_VULKAN_FAULTS
                             " VK_INSTANCE_LAYERS=VK_LAYER_LIGHTMESH_faults "
                             "LIGHTMESH_VULKAN_FAULT=" +
                                 fault + " " LIGHTMESH_RENDER " picture spheres --width 16 --height 12 -a " +
                                 algorithm + " -o " + (folder / "picture.png").string() + " " + more);
}

/// Of the device that programs take.
std::string name_of_device() {
    static const std::string name = demo::ComputeDevice().name();
    return name;
}

/// Whether a program has ended with one sentence about the device that has these words, and without a
/// picture.
void check_says(const test::TemporaryFolder& folder, const test::Finished& ran, const std::string& words) {
    CAPTURE(words);
    CAPTURE(ran.errors);
    CHECK(ran.status == 1);
    CHECK(ran.errors.starts_with("lightmesh-render: Vulkan: " + name_of_device()));
    CHECK(ran.errors.find(words) != std::string::npos);
    CHECK(std::ranges::count(ran.errors, '\n') == 1);
    CHECK_FALSE(std::filesystem::exists(folder / "picture.png"));
}

}  // namespace

TEST_CASE("gpu faults: devices that are too old or lack a feature are refused by their names") {
    const test::TemporaryFolder folder;
    CHECK(render(folder, "whitted", "none", "--on gpu").status == 0);
    std::filesystem::remove(folder / "picture.png");
    check_says(folder, render(folder, "whitted", "old", "--on gpu"), " is older than Vulkan 1.1");
    check_says(folder, render(folder, "whitted", "feature", "--on gpu"),
               " lacks a feature, when it was opened");
}

TEST_CASE("gpu faults: memory that is exhausted is one sentence, wherever it happens") {
    const test::TemporaryFolder folder;
    struct Case {
        const char* algorithm;
        const char* allocation;
    };
    for (const Case& c : {Case{"whitted", "1"}, Case{"whitted", "9"}, Case{"cache", "2"}, Case{"cache", "19"},
                          Case{"linked", "25"}, Case{"linked+map", "25"}}) {
        CAPTURE(c.algorithm);
        CAPTURE(c.allocation);
        check_says(folder, render(folder, c.algorithm, std::string("memory:") + c.allocation, "--on gpu"),
                   " has no memory left, ");
    }
    check_says(folder, render(folder, "linked+map", "memory:1"), " has no memory left, while triangles");
}

TEST_CASE("gpu faults: a device that is lost is one sentence, wherever it happens") {
    const test::TemporaryFolder folder;
    for (const char* submission : {"1", "30", "60"})
        for (const char* algorithm : {"cache", "linked", "linked+map"}) {
            CAPTURE(submission);
            CAPTURE(algorithm);
            check_says(folder, render(folder, algorithm, std::string("lost:") + submission, "--on gpu"),
                       " was lost (its driver gave up, or stopped work that took too long), while ");
        }
    // Of the host's depth pictures.
    for (const char* submission : {"1", "3"}) {
        CAPTURE(submission);
        check_says(folder, render(folder, "linked+map", std::string("lost:") + submission), " was lost (");
    }
}

TEST_CASE("gpu faults: a snapshot that is corrupt reaches no device") {
    const test::TemporaryFolder folder;
    const std::string mesh = (folder / "mesh").string();
    for (const char* algorithm : {"cache", "express"}) {
        CAPTURE(algorithm);
        REQUIRE(render(folder, algorithm, "none", "--on cpu --save-mesh " + mesh).status == 0);
        std::filesystem::remove(folder / "picture.png");
        std::vector<char> bytes;
        {
            std::ifstream file(mesh, std::ios::binary);
            bytes.assign(std::istreambuf_iterator<char>(file), {});
        }
        bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
        std::ofstream(mesh, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        // From the first submission on the device would be lost: nothing is submitted.
        const test::Finished ran = render(folder, algorithm, "lost:1", "--on gpu --mesh " + mesh);
        CHECK(ran.status == 1);
        CHECK(ran.errors.find("lost") == std::string::npos);
        CHECK(ran.errors.find("checksum") != std::string::npos);
        CHECK_FALSE(std::filesystem::exists(folder / "picture.png"));
    }
}

}  // namespace gpu_faults_test
