// SPDX-License-Identifier: MIT

// examples/minimal/, run as its readers would.

#include "render/files.hpp"
#include "run_command.hpp"

#include <doctest/doctest.h>

#include <cstddef>
#include <string>

namespace minimal_test {

TEST_CASE("the minimal example draws a floor with soft shadows") {
    const test::TemporaryFolder folder;
    const test::Finished ran = test::run(folder, "cd " + (folder / "").string() + " && " LIGHTMESH_MINIMAL);
    REQUIRE(ran.status == 0);
    const std::string picture = demo::read_file(folder / "minimal.ppm");
    const std::string head = "P6\n640 400\n255\n";
    REQUIRE(picture.size() == head.size() + std::size_t{3} * 640 * 400);
    CHECK(picture.starts_with(head));

    // Along a row of the floor, between the balls in front: grey throughout, from light to dark without a
    // jump.
    int lightest = 0;
    int darkest = 255;
    int greatest_jump = 0;
    const auto channel = [&](std::size_t x, std::size_t c) {
        return static_cast<int>(static_cast<unsigned char>(picture[head.size() + 3 * (360 * 640 + x) + c]));
    };
    for (std::size_t x = 0; x < 640; ++x) {
        REQUIRE(channel(x, 0) == channel(x, 1));
        lightest = channel(x, 0) > lightest ? channel(x, 0) : lightest;
        darkest = channel(x, 0) < darkest ? channel(x, 0) : darkest;
        const int jump = x > 0 ? channel(x, 0) - channel(x - 1, 0) : 0;
        greatest_jump = jump * jump > greatest_jump * greatest_jump ? jump : greatest_jump;
    }
    CHECK(lightest > 190);
    CHECK(darkest < 165);
    CHECK(greatest_jump * greatest_jump < 10 * 10);
}

}  // namespace minimal_test
