// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/ray_ends.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/light_order.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/neighbours.hpp>
#include <lightmesh/query/seeds.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

namespace lightmesh::detail {

/// One query's steps, its state on the stack.
template <class Store, class Kernel>
class Query {
public:
    /// `spent` may be null.
    Query(const Store& store, const glm::vec3& point, const glm::vec3& normal, QueryStatistics* spent)
        : store_(&store), spent_(spent), point_(point), normal_(unit_or_zero(normal)),
          is_valid_(is_finite(point) && is_finite(normal)) {
        if (is_valid_)
            store.grid().locate(point);  // Throws, also where no light reaches.
        if (spent_ != nullptr)
            ++spent_->points;
    }

    /// S of one light. `memory` has `Hemisphere::max_entries` places.
    float one(std::size_t light, BrickPoints* memory) {
        if (!is_valid_)
            return std::numeric_limits<float>::quiet_NaN();
        if (!lights().reaches(light, point_, normal_))
            return 0.0f;
        find_neighbours(memory);
        if (short_test() == ShortTest::linked) {
            link_neighbours();
        } else if (short_test() == ShortTest::exact) {
            const int lit = count_lit(light);
            const bool agree = lit == 0 || lit == neighbours_.point_count();
            if (agree && sees_any_neighbour())
                return lit == 0 ? 0.0f : 1.0f;
            test_neighbours();
        }
        const int count = neighbours_.point_count();
        if (count == 0) {
            note_empty();
            return shadow_ray(light);
        }
        return static_cast<float>(count_lit(light)) / static_cast<float>(count);
    }

    /// S of all lights. `memory` as for `one`.
    void all(std::span<float> values, BrickPoints* memory) {
        if (answers_without_neighbours(values))
            return;
        find_neighbours(memory);
        if (short_test() == ShortTest::linked)
            link_neighbours();
        const bool agree = average(values);
        if (short_test() != ShortTest::exact || neighbours_.point_count() == 0)
            return;
        // If each light is seen by all neighbours or by none, it does not matter which of them P sees.
        if (agree && sees_any_neighbour())
            return;
        test_neighbours();
        average(values);
    }

    /// Whether the point or the normal is not finite, or no light reaches the point; then the values are set.
    bool answers_without_neighbours(std::span<float> values) {
        if (!is_valid_)
            std::ranges::fill(values, std::numeric_limits<float>::quiet_NaN());
        else if (!any_light_reaches())
            std::ranges::fill(values, 0.0f);
        else
            return false;
        return true;
    }

    /// The hemisphere neighbours. Returns how many places of `memory` are taken.
    std::size_t find_neighbours(BrickPoints* memory) {
        const Hemisphere hemisphere(store_->grid(), point_, normal_);
        neighbours_.template find<Kernel>(hemisphere, store_->bricks(), memory);
        if (short_test() == ShortTest::linked)
            candidates_ = {store_->grid(), point_, normal_};
        return neighbours_.entries().size();
    }

    /// The segment to the next light point that may be the seed of the linked short test; false if there is
    /// none left.
    bool next_seed(Segment& segment) {
        while (!candidates_.empty()) {
            seed_ = candidates_.next();
            seed_brick_ = neighbours_.brick_with(seed_);
            if (seed_brick_ == nullptr)
                continue;
            if (spent_ != nullptr)
                ++spent_->short_rays;
            segment = {surface_end(), store_->grid().position(seed_)};
            return true;
        }
        neighbours_.clear();
        return false;
    }

    /// The linked short test, P being known to see the seed.
    void link_to_seed() {
        const ReachBox box(seed_, store_->settings().quality);
        const std::size_t slots = ReachBox::slots(store_->settings().quality);
        const Reach& reach = store_->reach_of(*seed_brick_, seed_);
        neighbours_.narrow([&](const BrickPoints& entry) {
            const glm::ivec3& place = entry.brick->place();
            return box.contains(place) ? reach.in_slot(box.slot(place), slots) : std::uint64_t{0};
        });
    }

    /// Equation (3) for all lights. True if for each light that reaches P all neighbours agree, and there are
    /// some.
    bool average(std::span<float> values) {
        const int count = neighbours_.point_count();
        if (count == 0) {
            trace_shadow_rays(values);
            return false;
        }
        if (!lights().order().is_given())
            return average_reordered(count, values);
        bool agree = true;
        for (std::size_t t = 0; t < lights().tile_count(); ++t) {
            const auto first = t * lights_per_tile;
            agree &= average_tile(t, count,
                                  values.subspan(first, static_cast<std::size_t>(lights().tile_size(t))));
        }
        return agree;
    }

private:
    const LightTable& lights() const { return store_->lights(); }
    ShortTest short_test() const { return store_->settings().short_test; }

    const Reaching& reaching(std::size_t tile) {
        if (tile != reaching_tile_) {
            reaching_ = lights().find_reaching(tile, point_, normal_);
            reaching_tile_ = tile;
        }
        return reaching_;
    }

    bool any_light_reaches() {
        for (std::size_t t = 0; t < lights().tile_count(); ++t)
            if (groups_with_any(reaching(t)) != 0)
                return true;
        return false;
    }

    void link_neighbours() {
        Segment segment;
        while (next_seed(segment)) {
            if (!store_->tracer().occluded(segment))
                return link_to_seed();
        }
    }

    /// Whether P sees at least one of its neighbours: then the interpolation set is not empty.
    bool sees_any_neighbour() const {
        const glm::vec3 end = surface_end();
        for (const BrickPoints& entry : neighbours_.entries()) {
            for (std::uint64_t rest = entry.points; rest != 0; rest &= rest - 1) {
                if (spent_ != nullptr)
                    ++spent_->short_rays;
                const glm::ivec3 index = index_of(*entry.brick, std::countr_zero(rest));
                if (!store_->tracer().occluded(Segment{end, store_->grid().position(index)}))
                    return true;
            }
        }
        return false;
    }

    /// The short test of equation (2), by a ray for each neighbour.
    void test_neighbours() {
        const glm::vec3 end = surface_end();
        neighbours_.narrow([&](const BrickPoints& entry) {
            std::array<Segment, most_segments> segments;
            std::array<std::uint8_t, most_segments> hit;
            std::size_t size = 0;
            for (std::uint64_t rest = entry.points; rest != 0; rest &= rest - 1) {
                const glm::ivec3 index = index_of(*entry.brick, std::countr_zero(rest));
                segments[size++] = {end, store_->grid().position(index)};
            }
            trace(store_->tracer(), std::span(segments).first(size), std::span(hit).first(size));
            if (spent_ != nullptr)
                spent_->short_rays += size;
            std::uint64_t seen = 0;
            std::size_t i = 0;
            for (std::uint64_t rest = entry.points; rest != 0; rest &= rest - 1)
                if (hit[i++] == 0)
                    seen |= rest & (~rest + 1);
            return seen;
        });
    }

    bool average_tile(std::size_t tile, int count, std::span<float> values) {
        const Reaching& reaches = reaching(tile);
        const std::uint32_t groups = groups_with_any(reaches);
        alignas(64) std::array<std::uint16_t, lights_per_tile> lit{};
        if (groups != 0)
            add_lit(tile, groups, lit.data());
        // Plain loops of fixed length, for the sake of vector instructions.
        std::uint32_t mixed = 0;
        for (std::size_t l = 0; l < lit.size(); ++l) {
            lit[l] = static_cast<std::uint16_t>(lit[l] & -reaches[l]);
            mixed |= static_cast<std::uint32_t>(lit[l]) * (static_cast<std::uint32_t>(count) - lit[l]);
        }
        const auto whole = static_cast<float>(count);
        if (values.size() == lit.size()) {
            for (std::size_t l = 0; l < lit.size(); ++l)
                values[l] = static_cast<float>(lit[l]) / whole;
        } else {
            for (std::size_t l = 0; l < values.size(); ++l)
                values[l] = static_cast<float>(lit[l]) / whole;
        }
        return mixed == 0;
    }

    /// `average` where the lights' places are not their numbers: most tiles then reach nothing.
    bool average_reordered(int count, std::span<float> values) {
        std::ranges::fill(values, 0.0f);
        bool agree = true;
        for (std::size_t t = 0; t < lights().tile_count(); ++t) {
            if (groups_with_any(reaching(t)) == 0)
                continue;
            std::array<float, lights_per_tile> in_tile;
            const auto size = static_cast<std::size_t>(lights().tile_size(t));
            agree &= average_tile(t, count, std::span(in_tile).first(size));
            for (std::size_t l = 0; l < size; ++l)
                values[lights().order().light_at(t * lights_per_tile + l)] = in_tile[l];
        }
        return agree;
    }

    static std::uint32_t groups_with_any(const Reaching& reaching) {
        std::uint32_t groups = 0;
        for (std::size_t g = 0; g < 8; ++g) {
            std::uint64_t lights;
            std::memcpy(&lights, &reaching[8 * g], sizeof lights);
            groups |= static_cast<std::uint32_t>(lights != 0) << g;
        }
        return groups;
    }

    /// Adds to lit[l] the number of neighbours that see light l of the tile, for the groups of lights in the
    /// mask.
    void add_lit(std::size_t tile, std::uint32_t groups, std::uint16_t* lit) {
        constexpr int capacity = 256;
        std::array<CellRow, capacity + cells_per_brick> rows;
        int size = 0;
        const auto stride = static_cast<std::size_t>(lights().tile_groups(tile));
        for (const BrickPoints& entry : neighbours_.entries()) {
            const std::uint8_t* lit_in_brick = known_tile(entry, tile, groups).rows();
            std::uint64_t cells = cells_in(entry.points) & every_byte;
            for (; cells != 0; cells &= cells - 1) {
                const auto first =
                    static_cast<std::size_t>(std::countr_zero(cells));  // bit, and byte of 8 lights
                rows[static_cast<std::size_t>(size++)] = {lit_in_brick + first * stride,
                                                          static_cast<std::uint8_t>(entry.points >> first)};
            }
            if (size > capacity) {
                Kernel::add_lit(rows.data(), size, groups, lit);
                size = 0;
            }
        }
        Kernel::add_lit(rows.data(), size, groups, lit);
    }

    /// The number of neighbours that see one light.
    int count_lit(std::size_t light) {
        const std::size_t tile = lights().order().place_of(light) / lights_per_tile;
        const std::size_t place = lights().order().place_of(light) % lights_per_tile;
        const auto stride = static_cast<std::size_t>(8 * lights().tile_groups(tile));
        int lit = 0;
        for (const BrickPoints& entry : neighbours_.entries()) {
            const std::uint8_t* lit_in_brick = known_tile(entry, tile, 1u << (place / 8)).rows();
            for (std::size_t cell = 0; cell < cells_per_brick; ++cell) {
                const auto points = static_cast<std::uint8_t>(entry.points >> (8 * cell));
                if (points == 0)
                    continue;
                lit += std::popcount(static_cast<std::uint8_t>(lit_in_brick[cell * stride + place] & points));
            }
        }
        return lit;
    }

    /// The entry's tile, after making sure that its light points know the lights of the groups.
    const BrickTile& known_tile(const BrickPoints& entry, std::size_t t, std::uint32_t groups) const {
        return store_->known_tile(*entry.brick, t, cells_in(entry.points) & (groups * every_byte));
    }

    glm::vec3 surface_end() const {
        return detail::surface_end(point_, normal_, static_cast<float>(store_->grid().step()));
    }

    void note_empty() {
        if (spent_ != nullptr)
            ++spent_->empty_points;
    }

    /// The case m = 0 of equation (3).
    float shadow_ray(std::size_t light) {
        if (spent_ != nullptr)
            ++spent_->shadow_rays;
        return store_->tracer().occluded(lights().shadow_segment(light, surface_end())) ? 0.0f : 1.0f;
    }

    void trace_shadow_rays(std::span<float> values) {
        note_empty();
        for (std::size_t t = 0; t < lights().tile_count(); ++t) {
            const Reaching& reaches = reaching(t);
            for (int l = 0; l < lights().tile_size(t); ++l) {
                const std::size_t light =
                    lights().order().light_at(t * lights_per_tile + static_cast<std::size_t>(l));
                values[light] = reaches[static_cast<std::size_t>(l)] != 0 ? shadow_ray(light) : 0.0f;
            }
        }
    }

    const Store* store_;
    QueryStatistics* spent_;
    glm::vec3 point_;
    glm::vec3 normal_;
    bool is_valid_;
    Neighbours neighbours_;
    SeedCandidates candidates_;
    glm::ivec3 seed_{0};
    const Brick* seed_brick_ = nullptr;
    std::size_t reaching_tile_ = (std::numeric_limits<std::size_t>::max)();
    Reaching reaching_;
};

}  // namespace lightmesh::detail
