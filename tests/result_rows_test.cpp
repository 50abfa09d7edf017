// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/query/query_point.hpp>
#include <lightmesh/query/result_rows.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace result_rows_test {

namespace {

using namespace lightmesh;

constexpr float without_end = std::numeric_limits<float>::infinity();

/// With a finite range lights are sorted by their places.
detail::LightTable table_of(std::size_t count, const Grid& grid, float range) {
    test::Random random(3);
    std::vector<Light> lights;
    for (std::size_t i = 0; i < count; ++i)
        lights.push_back(PointLight{.position = glm::vec3(random.in_box(test::Vec(-50.0), test::Vec(50.0))),
                                    .range = range});
    return {lights, grid};
}

}  // namespace

TEST_CASE("values of a tile come to the lights that stand in its slots, and to one row only") {
    const Grid grid(Settings{.radius = 1.0f});
    struct Case {
        std::size_t count;
        float range;
    };
    for (const Case& of : {Case{5, 2.0f}, Case{64, 2.0f}, Case{150, 2.0f}, Case{5, without_end},
                           Case{64, without_end}, Case{150, without_end}}) {
        const std::size_t count = of.count;
        const float range = of.range;
        CAPTURE(count);
        CAPTURE(range);
        const detail::LightTable table = table_of(count, grid, range);
        REQUIRE(table.order().is_given() == (range == without_end));
        std::vector<float> all(3 * count, -1.0f);
        const detail::ResultRows rows(table, all);
        detail::QueryPoint point({0, 0, 0}, {0, 0, 1});
        point.row = 1;
        if (rows.begins_with_zeros(point))
            rows.fill(point, 0.0f);
        CHECK(rows.begins_with_zeros(point) == (range != without_end));
        for (std::size_t t = 0; t < table.tile_count(); ++t) {
            std::vector<float> values(detail::lights_per_tile);
            for (std::size_t l = 0; l < values.size(); ++l)
                values[l] = static_cast<float>(t * detail::lights_per_tile + l);
            // No light of the second tile is seen.
            rows.give(point, t, t == 1 ? nullptr : values.data());
        }
        for (std::size_t slot = 0; slot < count; ++slot) {
            const bool is_dark = slot / detail::lights_per_tile == 1;
            CHECK(all[count + table.order().light_at(slot)] == (is_dark ? 0.0f : static_cast<float>(slot)));
        }
        CHECK(std::ranges::count(all, -1.0f) == static_cast<std::ptrdiff_t>(2 * count));
    }
}

TEST_CASE("a share of a row is blended with what is there, zeros too") {
    const Grid grid(Settings{.radius = 1.0f});
    const detail::LightTable table = table_of(70, grid, 2.0f);
    std::vector<float> all(70, 1.0f);
    const detail::ResultRows rows(table, all);
    detail::QueryPoint point({0, 0, 0}, {0, 0, 1});
    point.share = 0.25f;
    CHECK_FALSE(rows.begins_with_zeros(point));
    CHECK(rows.whole_tile_of(point, 0) == nullptr);
    const std::vector<float> values(detail::lights_per_tile, 0.6f);
    rows.give(point, 0, values.data());
    rows.give(point, 1, nullptr);
    for (std::size_t slot = 0; slot < 70; ++slot)
        CHECK(all[table.order().light_at(slot)] == doctest::Approx(slot < 64 ? 0.9f : 0.75f));
}

TEST_CASE("a whole tile of a row is where its values stand side by side") {
    const Grid grid(Settings{.radius = 1.0f});
    std::vector<float> all(2 * 64);
    detail::QueryPoint point({0, 0, 0}, {0, 0, 1});
    point.row = 1;
    const detail::LightTable whole = table_of(64, grid, without_end);
    CHECK(detail::ResultRows(whole, all).whole_tile_of(point, 0) == &all[64]);
    for (const detail::LightTable& other : {table_of(63, grid, without_end), table_of(64, grid, 2.0f)})
        CHECK(detail::ResultRows(other, all).whole_tile_of(point, 0) == nullptr);
}

}  // namespace result_rows_test
