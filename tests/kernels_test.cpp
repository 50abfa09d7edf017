// SPDX-License-Identifier: MIT
#include "kernels_that_run.hpp"
#include "random_scene.hpp"

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/reaching.hpp>

#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

// Every kernel that this processor can run against the plainest loops.

namespace kernels_test {

namespace {

using lightmesh::detail::Kernels;
using Counts = std::array<std::uint16_t, 64>;

Counts random_counts(test::Random& random) {
    Counts counts;
    for (std::uint16_t& count : counts)
        count = static_cast<std::uint16_t>(random.below(5000));
    return counts;
}

void add_plainly(Counts& counts, std::size_t light, std::uint32_t lit, bool subtract) {
    const int bits = std::popcount(lit);
    counts[light] = static_cast<std::uint16_t>(subtract ? counts[light] - bits : counts[light] + bits);
}

}  // namespace

TEST_CASE("the fastest kernels are among those that run") {
    bool found = false;
    for (const Kernels* kernels : test::kernels_that_run())
        found |= kernels == &lightmesh::detail::kernels();
    CHECK(found);
    CHECK(&lightmesh::detail::kernels() == test::kernels_that_run().back());
}

TEST_CASE("kernels find the masks of plain loops over the same integers") {
    test::Random random(61);
    for (const Kernels* kernels : test::kernels_that_run()) {
        CAPTURE(kernels->name);
        for (const float quality : {1.0f, 1.5f, 3.0f, 4.0f, 8.0f, 8.5f, 16.0f}) {
            const lightmesh::Grid grid(lightmesh::Settings{.radius = 1.0f, .quality = quality});
            for (int round = 0; round < (quality < 8.0f ? 40 : 4); ++round) {
                const glm::vec3 point(random.in_box(test::Vec(-5.0), test::Vec(5.0)));
                const lightmesh::detail::Hemisphere h(grid, grid.locate(point), point,
                                                      glm::vec3(random.direction()));
                std::vector<lightmesh::detail::BrickMask> masks(
                    lightmesh::detail::Hemisphere::largest_box(quality) + 1);
                const std::size_t size = kernels->find_masks(h, masks.data());
                std::size_t next = 0;
                for (int z = 0; z < h.bricks.z; ++z)
                    for (int y = 0; y < h.bricks.y; ++y)
                        for (int x = 0; x < h.bricks.x; ++x) {
                            std::uint64_t expected = 0;
                            for (int bit = 0; bit < 64; ++bit) {
                                const glm::ivec3 at =
                                    lightmesh::detail::grid_pos_of({x, y, z}, bit) * (1 << h.fraction_bits) -
                                    h.position;
                                const bool inside =
                                    at.x * at.x + at.y * at.y + at.z * at.z < h.radius_squared &&
                                    at.x * h.slope.x + at.y * h.slope.y + at.z * h.slope.z > h.lowest_height;
                                expected |= static_cast<std::uint64_t>(inside) << bit;
                            }
                            if (expected == 0)
                                continue;
                            REQUIRE(next < size);
                            CHECK(masks[next].x == x);
                            CHECK(masks[next].y == y);
                            CHECK(masks[next].z == z);
                            CHECK(masks[next].points == expected);
                            ++next;
                        }
                CHECK(next == size);
            }
        }
    }
}

TEST_CASE("kernels count and subtract the rows of cells as plain loops do") {
    test::Random random(62);
    std::vector<lightmesh::detail::CellRow> store(1000);
    for (auto& row : store)
        for (std::uint8_t& byte : row.bytes)
            byte = static_cast<std::uint8_t>(random.below(8) == 0 ? 0xff : random.next());
    for (const Kernels* kernels : test::kernels_that_run()) {
        CAPTURE(kernels->name);
        for (const std::size_t row_count : {0u, 1u, 2u, 30u, 31u, 32u, 61u, 62u, 63u, 100u, 264u, 1000u}) {
            for (const bool subtract : {false, true}) {
                std::vector<lightmesh::detail::RowPoints> rows;
                for (std::size_t r = 0; r < row_count; ++r) {
                    const auto points =
                        static_cast<std::uint8_t>(random.below(4) == 0 ? 0xff : random.next());
                    rows.push_back({store[random.below(1000)].bytes.data(), points});
                }
                Counts counts = random_counts(random);
                Counts expected = counts;
                for (const auto& row : rows)
                    for (std::size_t l = 0; l < 64; ++l)
                        add_plainly(expected, l, row.row[l] & row.points, subtract);
                kernels->add_rows(rows.data(), rows.size(), subtract, counts.data());
                CHECK(counts == expected);
            }
        }
    }
}

TEST_CASE("kernels count and subtract cells in words, and uniform bricks, as plain loops do") {
    test::Random random(63);
    for (const Kernels* kernels : test::kernels_that_run()) {
        CAPTURE(kernels->name);
        for (const std::size_t cell_count : {0u, 1u, 2u, 31u, 32u, 62u, 63u, 200u}) {
            for (const bool subtract : {false, true}) {
                std::vector<std::array<std::uint64_t, 3>> words(cell_count);
                std::vector<std::array<std::uint8_t, 64>> plain(cell_count);
                std::vector<lightmesh::detail::WordPoints> cells;
                for (std::size_t c = 0; c < cell_count; ++c) {
                    words[c] = {random.next(), 0, 0};
                    for (std::uint64_t i = random.below(9); i > 0; --i)
                        words[c][1] |= std::uint64_t{1} << random.below(64);
                    words[c][0] &= ~words[c][1];
                    int rank = 0;
                    for (std::size_t l = 0; l < 64; ++l) {
                        const auto byte = static_cast<std::uint8_t>(1 + random.below(254));
                        plain[c][l] = (words[c][0] >> l & 1) != 0 ? 0xff : 0;
                        if ((words[c][1] >> l & 1) != 0) {
                            plain[c][l] = byte;
                            words[c][2] |= static_cast<std::uint64_t>(byte) << (8 * rank++);
                        }
                    }
                    const auto points = static_cast<std::uint8_t>(random.next());
                    cells.push_back({words[c][0], words[c][1] != 0 ? &words[c][1] : nullptr, points,
                                     static_cast<std::uint8_t>(std::popcount(points))});
                }
                Counts counts = random_counts(random);
                Counts expected = counts;
                for (std::size_t c = 0; c < cell_count; ++c)
                    for (std::size_t l = 0; l < 64; ++l)
                        add_plainly(expected, l, plain[c][l] & cells[c].points, subtract);
                for (std::size_t bricks = random.below(20); bricks > 0; --bricks) {
                    const std::uint64_t lit = random.next();
                    const auto count = static_cast<std::uint8_t>(random.below(65));
                    cells.push_back({lit, nullptr, 0, count});
                    for (std::size_t l = 0; l < 64; ++l)
                        for (int i = 0; i < count; ++i)
                            add_plainly(expected, l, static_cast<std::uint32_t>(lit >> l & 1), subtract);
                }
                kernels->add_words(cells.data(), cells.size(), subtract, counts.data());
                CHECK(counts == expected);
            }
        }
    }
}

TEST_CASE("kernels divide alike, and know whether all light points agree") {
    test::Random random(64);
    for (const Kernels* kernels : test::kernels_that_run()) {
        CAPTURE(kernels->name);
        for (int round = 0; round < 500; ++round) {
            const int count = static_cast<int>(1 + random.below(round % 2 == 0 ? 4 : 9000));
            Counts counts;
            for (std::uint16_t& lit : counts)
                lit = static_cast<std::uint16_t>(random.below(2) == 0 ? 0 : count);
            if (round % 3 != 0)
                counts[random.below(64)] =
                    static_cast<std::uint16_t>(random.below(static_cast<std::uint64_t>(count) + 1));
            const std::uint64_t reaching = round % 5 == 0 ? 0 : random.next() | random.next();
            bool agree = true;
            std::array<float, 64> expected;
            for (std::size_t l = 0; l < 64; ++l) {
                const bool reaches = (reaching >> l & 1) != 0;
                agree &= !reaches || counts[l] == 0 || counts[l] == count;
                expected[l] = reaches ? static_cast<float>(counts[l]) / static_cast<float>(count) : 0.0f;
            }
            std::array<float, 64> values;
            CHECK(kernels->divide(counts.data(), count, reaching, values.data()) == agree);
            CHECK(values == expected);
        }
    }
}

TEST_CASE("kernels find the lights that a point faces, also where rounding decides") {
    test::Random random(65);
    std::vector<lightmesh::Light> lights;
    for (int i = 0; i < 61; ++i) {
        const glm::vec3 at(glm::round(random.in_box(test::Vec(-4.0), test::Vec(4.0))));
        if (i % 7 == 0)
            lights.push_back(lightmesh::DirectionalLight{at + glm::vec3(0, 0, 0.5f)});
        else if (i % 7 == 1)
            lights.push_back(lightmesh::PointLight{.position = at, .range = 3.0f});
        else
            lights.push_back(lightmesh::PointLight{.position = at});
    }
    for (const bool with_ranges : {false, true}) {
        if (!with_ranges)
            std::erase_if(lights, [](const lightmesh::Light& light) {
                const auto* point = std::get_if<lightmesh::PointLight>(&light);
                return point != nullptr && std::isfinite(point->range);
            });
        const lightmesh::detail::LightTable table(lights, lightmesh::Grid(lightmesh::Settings{}));
        for (int round = 0; round < 2000; ++round) {
            // On a lattice many lights lie exactly on the tangent plane, or at their range.
            const glm::vec3 point(glm::round(random.in_box(test::Vec(-4.0), test::Vec(4.0))));
            glm::vec3 normal(glm::round(random.in_box(test::Vec(-1.4), test::Vec(1.4))));
            normal = lightmesh::detail::unit_or_zero(normal);
            std::uint64_t expected = 0;
            for (std::size_t l = 0; l < lights.size(); ++l)
                expected |= static_cast<std::uint64_t>(table.tile(0).faces_in_range(l, point, normal)) << l;
            for (const Kernels* kernels : test::kernels_that_run()) {
                CAPTURE(kernels->name);
                CHECK(kernels->find_facing(table.tile(0), point, normal) == expected);
                CHECK(lightmesh::detail::find_reaching(table, *kernels, 0, point, normal) == expected);
            }
        }
    }
}

}  // namespace kernels_test
