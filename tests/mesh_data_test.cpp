// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/links.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/mesh/pool.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <tuple>
#include <vector>

namespace mesh_data_test {

// The inside of a mesh: pools, bricks, tiles, links, floods.

using lightmesh::detail::Brick;
using lightmesh::detail::BrickWords;
using lightmesh::detail::MeshData;

namespace {

MeshData make_data(int light_count) {
    std::vector<lightmesh::Light> lights(static_cast<std::size_t>(light_count), lightmesh::PointLight{});
    return MeshData(lights, lightmesh::Settings{});
}

}  // namespace

TEST_CASE("chunks of a pool follow each other without gaps") {
    using Chunks = lightmesh::detail::PoolChunks<std::uint64_t>;
    CHECK(Chunks::first_index(0) == 0);
    for (std::size_t chunk = 0; chunk + 1 < Chunks::count; ++chunk)
        CHECK(Chunks::first_index(chunk) + Chunks::size(chunk) == Chunks::first_index(chunk + 1));
    for (std::uint64_t index = 0; index < 0xffffffffu; index = index * 3 / 2 + 1) {
        const auto i = static_cast<std::uint32_t>(index);
        const std::size_t chunk = Chunks::chunk_of(i);
        CHECK(Chunks::first_index(chunk) + Chunks::offset_in_chunk(i) == index);
        CHECK(Chunks::offset_in_chunk(i) < Chunks::size(chunk));
    }
}

TEST_CASE("a pool's elements are zero, stay where they are, and lie side by side when asked for together") {
    lightmesh::detail::Pool<std::uint64_t> pool;
    test::Random random(31);
    std::map<std::uint32_t, std::uint64_t> expected;
    std::map<std::uint32_t, const std::uint64_t*> addresses;
    for (int i = 0; i < 3000; ++i) {
        const std::size_t count = random.below(10) == 0 ? 1 + random.below(1000) : 1;
        const std::uint32_t first = pool.allocate(count);
        for (std::size_t k = 0; k < count; ++k) {
            const auto index = static_cast<std::uint32_t>(first + k);
            CHECK(expected.count(index) == 0);
            CHECK(pool[index] == 0);
            CHECK(&pool[index] == &pool[first] + k);
            pool[index] = random.next();
            expected[index] = pool[index];
            addresses[index] = &pool[index];
        }
    }
    for (const auto& [index, value] : expected) {
        CHECK(pool[index] == value);
        CHECK(&pool[index] == addresses[index]);
    }
    CHECK(pool.bytes() >= 8 * expected.size());
    CHECK(pool.bytes() < 10 * expected.size());
}

TEST_CASE("a pool that was given its first elements hands out zeroed ones after them") {
    for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{5000}}) {
        lightmesh::detail::Pool<std::uint64_t> pool;
        std::vector<std::uint64_t> given(count);
        for (std::size_t i = 0; i < count; ++i)
            given[i] = 3 * i + 1;
        pool.reserve_first(2 * count);  // as if what came after it had failed
        pool.reserve_first(count);
        CHECK(pool.size() == 0);
        pool.allocate_first(given);
        CHECK(pool.size() == count);
        for (int i = 0; i < 3000; ++i) {
            const std::uint32_t index = pool.allocate(2);
            CHECK(index >= count);
            CHECK((pool[index] | pool[index + 1]) == 0);
            CHECK(&pool[index + 1] == &pool[index] + 1);
            pool[index] = pool[index + 1] = ~std::uint64_t{0};
        }
        for (std::size_t i = 0; i < count; ++i) {
            CHECK(pool[static_cast<std::uint32_t>(i)] == given[i]);
            CHECK(&pool[static_cast<std::uint32_t>(i)] == &pool[0] + i);
        }
        CHECK(pool.bytes() < 10 * (count + 6000));
    }
}

TEST_CASE("bricks are found by their coordinates, wherever they lie") {
    MeshData data = make_data(3);
    test::Random random(32);
    std::map<std::tuple<int, int, int>, const Brick*> made;
    for (int i = 0; i < 3000; ++i) {
        const int far_away = i % 3 == 0 ? 4000000 : 40;
        const glm::ivec3 coord(random.in_box(test::Vec(-far_away), test::Vec(far_away)));
        const Brick& brick = data.find_or_make_brick(coord);
        CHECK(brick.position() == coord);
        const auto [known, is_new] = made.emplace(std::tuple(coord.x, coord.y, coord.z), &brick);
        CHECK(known->second == &brick);
        CHECK(data.view().find_brick(coord) == &brick);
    }
    CHECK(data.view().find_brick({5000000, 0, 0}) == nullptr);
    std::size_t visited = 0;
    data.for_each_brick([&](const Brick&) { ++visited; });
    CHECK(visited == made.size());
}

TEST_CASE("a tile gives back the units that were published, few or many lights mixed") {
    test::Random random(33);
    for (const int light_count : {1, 8, 20, 64, 200}) {
        MeshData data = make_data(light_count);
        const std::size_t tile_count = data.lights().tile_count();
        for (int round = 0; round < 60; ++round) {
            const Brick& brick = data.find_or_make_brick({round, 0, -round});
            const std::size_t t = random.below(tile_count);
            BrickWords lit;
            for (std::uint64_t& word : lit) {
                const auto bits = std::uint64_t{random.next()} << 32 | random.next();
                word = random.below(static_cast<std::size_t>(round % 3 + 1)) == 0 ? bits
                       : random.below(2) == 0                                     ? 0
                                                                                  : ~std::uint64_t{0};
            }
            // In every other brick some groups are sampled, before the first of their units.
            lightmesh::detail::UniformLights samples;
            if (round % 2 == 0)
                for (std::size_t l = 0; l < 64; ++l)
                    if ((lit[l] == 0 || ~lit[l] == 0) && random.below(4) != 0) {
                        samples.uniform |= std::uint64_t{1} << l;
                        samples.lit |= (lit[l] & 1) << l;
                    }
            std::uint64_t known = 0;
            for (int part = 0; part < 4; ++part) {
                const std::uint64_t fresh = std::uint64_t{random.next()} << 32 | random.next();
                for (std::uint32_t group = 0; round % 2 == 0 && group < 8; ++group)
                    if ((fresh & lightmesh::detail::every_byte << group) != 0)
                        samples.sampled |= 1u << group;
                data.publish(brick, t, fresh, lit, samples);
                known |= fresh;
                const std::uint64_t uniform =
                    samples.uniform & lightmesh::detail::lights_of_groups(samples.sampled);
                const auto* tile = data.view().find_tile(brick, t);
                REQUIRE(tile != nullptr);
                CHECK(tile->known == known);
                CHECK(tile->uniform == uniform);
                CHECK(data.view().missing(brick, t, ~std::uint64_t{0}) == ~known);
                for (int cell = 0; cell < 8; ++cell)
                    for (std::size_t l = 0; l < 64; ++l)
                        if ((known >> (8 * cell) >> (l / 8) & 1) != 0)
                            CHECK(data.view().lit_in_cell(*tile, cell, l) ==
                                  static_cast<std::uint8_t>(lit[l] >> (8 * cell)));
            }
        }
    }
}

TEST_CASE("steps along an axis lead from each light point to its neighbour") {
    using lightmesh::detail::bit_of;
    const auto check = [](auto steps, int axis) {
        for (int bit = 0; bit < 64; ++bit) {
            const std::uint64_t point = std::uint64_t{1} << bit;
            glm::ivec3 up = lightmesh::detail::coord_of(bit);
            ++up[axis];
            const std::uint64_t above = std::uint64_t{1} << bit_of(up.x % 4, up.y % 4, up.z % 4);
            CHECK(steps.up(point) == (up[axis] < 4 ? above : 0));
            CHECK(steps.up_from(point) == (up[axis] < 4 ? 0 : above));
            if (up[axis] < 4)
                CHECK(steps.down(above) == point);
            else
                CHECK(steps.down_from(above) == point);
        }
    };
    check(lightmesh::detail::AxisSteps<0>{}, 0);
    check(lightmesh::detail::AxisSteps<1>{}, 1);
    check(lightmesh::detail::AxisSteps<2>{}, 2);
}

TEST_CASE("a flood gives back what was reached, in every slot") {
    test::Random random(34);
    MeshData data = make_data(1);
    const Brick& brick = data.find_or_make_brick({1, 2, 3});
    for (int seed_bit = 0; seed_bit < 64; ++seed_bit) {
        const std::size_t slots = seed_bit % 2 == 0 ? 27 : 1000;
        std::vector<std::uint64_t> asked(slots);
        std::vector<std::uint64_t> reached(slots);
        for (std::size_t slot = 0; slot < slots; ++slot) {
            asked[slot] = std::uint64_t{random.next()} << 32 | random.next();
            const std::size_t kind = random.below(3);
            reached[slot] = kind == 0 ? 0 : kind == 1 ? asked[slot] : asked[slot] & random.next();
        }
        const lightmesh::detail::FloodRecord flood(reached, asked);
        const std::uint32_t index = data.publish_flood(brick, seed_bit, flood);
        CHECK(data.publish_flood(brick, seed_bit, flood) == index);
        CHECK(lightmesh::detail::find_flood(data.view(), brick, seed_bit) == index + 1);
        const lightmesh::detail::FloodView view(&data.view().words[index]);
        CHECK(view.seed_bit() == seed_bit);
        CHECK(view.size(slots) == flood.size());
        CHECK(view.has_slots(slots));
        for (std::size_t slot = 0; slot < slots; ++slot)
            CHECK((view.in_slot(slot, slots) & asked[slot]) == reached[slot]);
    }
    CHECK(lightmesh::detail::find_flood(data.view(), data.find_or_make_brick({0, 0, 0}), 5) == 0);
}

}  // namespace mesh_data_test
