// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/lights.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <variant>
#include <vector>

namespace lamp_table_test {

namespace {

using lightmesh::DirectionalLight;
using lightmesh::Light;
using lightmesh::PointLight;
using lightmesh::detail::LampTable;

/// What a table says of all lights at a point.
std::vector<bool> reaching_in(const LampTable& table, const glm::vec3& point, const glm::vec3& normal) {
    std::vector<bool> reaching;
    for (std::size_t tile = 0; tile < table.tile_count(); ++tile) {
        const std::uint64_t mask = table.reaching(tile, point, normal);
        for (std::size_t l = 0; l < table.tile_size(tile); ++l)
            reaching.push_back((mask >> l & 1) != 0);
    }
    return reaching;
}

}  // namespace

TEST_CASE(
    "lamp table: chi and ranges are those of each light alone, at all scales and wherever the lights lie") {
    test::Random random(1);
    for (const double scale : {1e-12, 1.0, 1e9}) {
        CAPTURE(scale);
        // Street by street, so that tiles lie apart; some lights shine everywhere, and some nowhere.
        std::vector<Light> lights;
        for (int i = 0; i < 640; ++i) {
            const double street = i / 64;
            const glm::vec3 at(scale *
                               random.in_box({10.0 * street, 0.0, 1.0}, {10.0 * street + 3.0, 30.0, 3.0}));
            const auto range = static_cast<float>(scale * random.uniform(1.0, 6.0));
            lights.push_back(PointLight{.position = at,
                                        .range = i % 300 == 7    ? std::numeric_limits<float>::infinity()
                                                 : i % 300 == 11 ? 0.0f
                                                                 : range});
        }
        lights.push_back(DirectionalLight{{0.0f, 0.6f, 0.8f}});
        const LampTable table(lights);
        std::size_t reaching_count = 0;
        std::size_t wrong = 0;
        for (int i = 0; i < 400; ++i) {
            const glm::vec3 point(scale * random.in_box({-5.0, -5.0, -1.0}, {105.0, 35.0, 4.0}));
            const glm::vec3 normal(0.0f, 0.28f, 0.96f);
            const std::vector<bool> reaching = reaching_in(table, point, normal);
            REQUIRE(reaching.size() == lights.size());
            for (std::size_t l = 0; l < lights.size(); ++l) {
                const LampTable alone(std::vector<Light>{lights[l]});
                wrong += reaching[l] != reaching_in(alone, point, normal)[0] ? 1u : 0u;
                reaching_count += reaching[l] ? 1u : 0u;
                if (const auto* lamp = std::get_if<PointLight>(&lights[l])) {
                    const glm::dvec3 offset = glm::dvec3(lamp->position) - glm::dvec3(point);
                    const double distance = glm::length(offset);
                    const double height = glm::dot(offset, glm::dvec3(normal));
                    // Nearer to the limits than this, roundings decide.
                    const double slack = 1e-6 * scale;
                    if (std::abs(distance - lamp->range) > slack && std::abs(height) > slack)
                        wrong += reaching[l] != (distance < lamp->range && height > 0.0) ? 1u : 0u;
                }
            }
        }
        CHECK(wrong == 0);
        CHECK(reaching_count > 1000);
        CHECK(reaching_count < 10000);
    }
}

TEST_CASE("lamp table: a point as far from a lamp as its range is reached, and lights that are put in place "
          "of others") {
    std::vector<Light> lights{PointLight{.position = {0.0f, 0.0f, 4.0f}, .range = 5.0f}};
    LampTable table(lights);
    const glm::vec3 up(0.0f, 0.0f, 1.0f);
    CHECK(table.reaching(0, {3.0f, 0.0f, 0.0f}, up) == 1);
    CHECK(table.reaching(0, {3.00001f, 0.0f, 0.0f}, up) == 0);
    CHECK(table.reaching(0, {100.0f, 0.0f, 0.0f}, up) == 0);
    LampTable::Replaced old = table.set(0, PointLight{.position = {100.0f, 0.0f, 4.0f}, .range = 5.0f});
    CHECK(table.reaching(0, {3.0f, 0.0f, 0.0f}, up) == 0);
    CHECK(table.reaching(0, {103.0f, 0.0f, 0.0f}, up) == 1);
    table.add(PointLight{.position = {0.0f, 0.0f, 4.0f}});
    CHECK(table.reaching(0, {3.0f, 0.0f, 0.0f}, up) == 2);
    CHECK(table.reaching(0, {1e6f, 0.0f, 0.0f}, up) == 2);
    table.restore(std::move(old));
    CHECK((table.reaching(0, {3.0f, 0.0f, 0.0f}, up) & 1) == 1);
}

}  // namespace lamp_table_test
