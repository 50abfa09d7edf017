// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/neighbours.hpp>
#include <lightmesh/query/short_test.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace short_test_test {

using lightmesh::detail::BrickWindow;
using lightmesh::detail::FloodBox;
using lightmesh::detail::FloodRecord;
using lightmesh::detail::FloodView;

TEST_CASE("a flood unpacked for a window is the flood in each brick of the window") {
    test::Random random(91);
    for (const float quality : {1.0f, 4.0f, 5.5f, 16.0f}) {
        CAPTURE(quality);
        const lightmesh::Grid grid(lightmesh::Settings{.radius = 1.0f, .quality = quality});
        const std::size_t slots = FloodBox::slots(quality);
        lightmesh::detail::WindowFlood flood;
        CHECK_FALSE(flood.is_of(glm::ivec3(0), 0));
        for (int round = 0; round < 10; ++round) {
            const glm::ivec3 seed(random.in_box(test::Vec(-20.0), test::Vec(20.0)));
            std::vector<std::uint64_t> reached(slots);
            const std::vector<std::uint64_t> asked(slots, ~std::uint64_t{0});
            for (std::uint64_t& points : reached)
                points = random.below(3) == 0 ? 0 : random.below(2) == 0 ? ~std::uint64_t{0} : random.next();
            const FloodRecord record(reached, asked);
            std::vector<std::uint64_t> words(record.size());
            record.write(words.data(), 0, 0);

            // The window holds some of the flood's bricks, and others.
            BrickWindow window(grid);
            const int side = lightmesh::detail::Hemisphere::largest_side(quality);
            const glm::ivec3 first = lightmesh::detail::brick_of(seed) - side / 2 +
                                     glm::ivec3(random.in_box(test::Vec(-2.0), test::Vec(2.0)));
            CHECK_FALSE(window.cover(first, glm::ivec3(side)));
            flood.unpack(FloodView(words.data()), seed, quality, window, 7);
            CHECK(flood.is_of(seed, 7));
            CHECK_FALSE(flood.is_of(seed, 8));
            CHECK_FALSE(flood.is_of(seed + 1, 7));
            const FloodBox box(seed, quality);
            for (int z = 0; z < side; ++z)
                for (int y = 0; y < side; ++y)
                    for (int x = 0; x < side; ++x) {
                        const glm::ivec3 coord = first + glm::ivec3(x, y, z);
                        REQUIRE(window.contains(coord));
                        const std::uint64_t expected = box.contains(coord) ? reached[box.slot(coord)] : 0;
                        CHECK(flood.in_slot(window.slot_of(coord)) == expected);
                    }
        }
    }
}

}  // namespace short_test_test
