// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/query/kernels/kernels.hpp>
#include <lightmesh/query/point_block.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <vector>

namespace point_block_test {

namespace {

using namespace lightmesh;
using detail::Brick;
using detail::PointBlock;
using detail::QueryPoint;

/// Bricks that are made when they are asked for.
class Bricks {
public:
    const Brick* operator()(const glm::ivec3& coord) {
        std::unique_ptr<Brick>& brick = all_[{coord.x, coord.y, coord.z}];
        if (!brick) {
            brick = std::make_unique<Brick>();
            brick->coord = {coord.x, coord.y, coord.z};
        }
        return brick.get();
    }

private:
    std::map<std::array<int, 3>, std::unique_ptr<Brick>> all_;
};

/// The light points of a set by brick.
using PointsByBrick = std::map<const Brick*, std::uint64_t>;

PointsByBrick set_of(const QueryPoint& point) {
    PointsByBrick set;
    for (const detail::BrickPoints& entry : point.neighbours.entries())
        set[entry.brick] = entry.points;
    return set;
}

struct World {
    Grid grid{Settings{.radius = 1.0f, .quality = 3.0f}};
    std::vector<Light> lights{PointLight{{0, 0, 5}}, PointLight{{0, 0, -5}}};
    detail::LightTable table{lights, grid};
    Bricks bricks;
    std::vector<float> values;

    /// All blocks of points on a plane whose normal is z: on_block(block, taken).
    template <class OnBlock>
    void take_all(const std::vector<glm::vec3>& positions, OnBlock&& on_block) {
        const std::vector<glm::vec3> normals(positions.size(), glm::vec3(0, 0, 1));
        values.assign(positions.size() * lights.size(), -1.0f);
        const detail::ResultRows rows(table, values);
        const auto block = std::make_unique<PointBlock>(grid, table, detail::kernels());
        for (std::size_t done = 0; done < positions.size();) {
            const std::size_t taken = block->take({positions, normals}, done, rows, bricks);
            REQUIRE(taken > 0);
            block->find_changes();
            on_block(*block, taken);
            done += taken;
        }
    }
};

}  // namespace

TEST_CASE("a block holds each point that a light reaches, and finishes the others") {
    World world;
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    std::vector<glm::vec3> positions;
    for (int i = 0; i < 300; ++i)
        positions.emplace_back(0.05f * static_cast<float>(i), 0.0f, 0.0f);
    positions[7].x = nan;
    positions[100].z = 9.0f;  // above both lights
    std::size_t held = 0;
    world.take_all(positions, [&](PointBlock& block, std::size_t) {
        for (const QueryPoint& point : block.points()) {
            CHECK(point.position == positions[point.row]);
            CHECK(block.reaching(point, 0) == 1u);
            CHECK(block.is_in_window(point) == (point.window == block.points().back().window));
            ++held;
        }
    });
    CHECK(held == positions.size() - 2);
    for (std::size_t i = 0; i < positions.size(); ++i)
        for (std::size_t l = 0; l < 2; ++l) {
            const float value = world.values[2 * i + l];
            CAPTURE(i);
            if (i == 7)
                CHECK(std::isnan(value));
            else
                CHECK(value == (i == 100 ? 0.0f : -1.0f));
        }
}

TEST_CASE("changes lead from the light points around one point to those around the next") {
    World world;
    test::Random random(17);
    std::vector<glm::vec3> positions;
    for (int i = 0; i < 400; ++i) {
        const bool jumps = random.below(16) == 0;
        const glm::vec3 from = positions.empty() || jumps ? glm::vec3(0.0f) : positions.back();
        const glm::vec3 step(random.in_box(test::Vec(-1.0), test::Vec(1.0)));
        positions.push_back(from + (jumps ? 20.0f : 0.1f) * glm::vec3(step.x, step.y, 0.0f));
    }
    int changed = 0;
    world.take_all(positions, [&](PointBlock& block, std::size_t) {
        const QueryPoint* before = nullptr;
        for (const QueryPoint& point : block.points()) {
            if (point.differs_little) {
                REQUIRE(before != nullptr);
                PointsByBrick set = set_of(*before);
                for (const detail::BrickChange& change : block.changes_of(point)) {
                    CHECK((set[change.brick] & change.added) == 0u);
                    CHECK((set[change.brick] & change.removed) == change.removed);
                    set[change.brick] = (set[change.brick] | change.added) & ~change.removed;
                }
                std::erase_if(set, [](const auto& entry) { return entry.second == 0; });
                CHECK(set == set_of(point));
                ++changed;
            }
            before = &point;
        }
    });
    CHECK(changed > 200);
}

}  // namespace point_block_test
