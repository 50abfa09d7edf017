// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/query/query_point.hpp>
#include <lightmesh/query/result_rows.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace result_rows_test {

namespace {

using namespace lightmesh;

/// Lights of small ranges, far apart.
detail::LightTable table_of(std::size_t count, const Grid& grid) {
    test::Random random(3);
    std::vector<Light> lights;
    for (std::size_t i = 0; i < count; ++i)
        lights.push_back(PointLight{.position = glm::vec3(random.in_box(test::Vec(-50.0), test::Vec(50.0))),
                                    .range = 2.0f});
    return {lights, grid};
}

}  // namespace

TEST_CASE("values of a tile come to the lights that stand in its slots, and to one row only") {
    const Grid grid(Settings{.radius = 1.0f});
    for (const std::size_t count : {5u, 64u, 150u}) {
        CAPTURE(count);
        const detail::LightTable table = table_of(count, grid);
        std::vector<float> all(3 * count, -1.0f);
        const detail::ResultRows rows(table, all);
        detail::QueryPoint point({0, 0, 0}, {0, 0, 1});
        point.row = 1;
        if (rows.begins_with_zeros(point))
            rows.fill(point, 0.0f);
        CHECK(rows.begins_with_zeros(point) == !table.order().is_given());
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
    const detail::LightTable table = table_of(70, grid);
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
    const detail::LightTable whole = table_of(64, grid);
    std::vector<float> all(2 * 64);
    detail::QueryPoint point({0, 0, 0}, {0, 0, 1});
    point.row = 1;
    CHECK(detail::ResultRows(whole, all).whole_tile_of(point, 0) ==
          (whole.order().is_given() ? &all[64] : nullptr));
    const detail::LightTable part = table_of(63, grid);
    CHECK(detail::ResultRows(part, all).whole_tile_of(point, 0) == nullptr);
}

}  // namespace result_rows_test
