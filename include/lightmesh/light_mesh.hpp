// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/brick_map.hpp>
#include <lightmesh/concepts.hpp>
#include <lightmesh/grid.hpp>
#include <lightmesh/kernels/kernels.hpp>
#include <lightmesh/light_table.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/long_test.hpp>
#include <lightmesh/long_test_source.hpp>
#include <lightmesh/neighbours.hpp>
#include <lightmesh/reach_search.hpp>
#include <lightmesh/seeds.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace lightmesh {

/// Soft shadows from many lights: equations (1) to (3) of the light mesh method (Debelov, Sevastyanov,
/// Novikov, Vasilyeva, "Ray Tracing Based on Interpolation of Visibility of Point Light Sources", Springer
/// SCI 441, 2013).
///
/// A mesh starts empty and fills itself as it is queried. All queries are const and may be called from any
/// number of threads at once; their results do not depend on the number of threads or on the order of
/// queries. A query on a filled mesh allocates nothing; one that is the first to touch some part of space may
/// add memory to the mesh (and throw std::bad_alloc). Lights, settings and the scene behind the adapters are
/// fixed for the life of a mesh.
///
/// In a query, `point` is a surface point P in world units, and `normal` the geometric normal there, on the
/// side that is shaded; its length does not matter. A point or normal that is not finite gives NaN. A zero
/// normal has no hemisphere: the result is the exact shadow ray of the case m = 0, with chi = 1. A finite
/// point whose light points have no index (farther than 2^24 steps from the origin) throws std::out_of_range.
template <class Tracer, class LongTest = detail::RayLongTest, class Kernel = detail::FastestKernel>
class LightMesh {
    static_assert(check_intersector<Tracer>());

public:
    /// Copies adapter and lights. Any number of lights, also none. Throws std::invalid_argument that names
    /// the value for settings out of range and lights that are not finite.
    LightMesh(Tracer tracer, std::span<const Light> lights, const Settings& settings)
        : tracer_(std::move(tracer)), grid_(settings), settings_(settings), lights_(lights, grid_),
          state_(std::make_unique<State>(lights_.tile_count())) {}

    /// The same with long tests by something else than rays. `source` is either a `DepthRenderer`, for shadow
    /// maps (LMM+ATK): nothing is rendered before a query needs it. Throws std::invalid_argument also for a
    /// map size out of range, and for a directional light if nobody knows the scene's bounds. Or `source` is
    /// `Occluders`, for shadow volumes (LMM+ATO): S as with rays but within rounding of a shadow's edge;
    /// settings and bounds of shadow maps play no part. Throws what `OccluderTriangles` throws, which names a
    /// triangle that is not finite.
    template <class Source>
    LightMesh(Tracer tracer, Source source, std::span<const Light> lights, const Settings& settings)
        : tracer_(std::move(tracer)), grid_(settings), settings_(settings), lights_(lights, grid_),
          long_test_(std::move(source), lights, settings),
          state_(std::make_unique<State>(lights_.tile_count())) {}

    std::size_t light_count() const { return lights_.size(); }
    const Grid& grid() const { return grid_; }
    const Settings& settings() const { return settings_; }

    /// S_i(P) of equation (3) for one light: how lit the point is, 0 in shadow to 1 lit. Throws
    /// std::out_of_range for a light that is not there. `spent`, if given, has this query's cost added.
    float visibility(const glm::vec3& point, const glm::vec3& normal, std::size_t light,
                     QueryStatistics* spent = nullptr) const {
        if (light >= lights_.size())
            throw_no_such_light(light);
        detail::BrickPoints memory[detail::Hemisphere::max_entries];
        return Query(*this, point, normal, spent).one(light, memory);
    }

    /// S_i(P) of every light, in one pass over the neighbours: much cheaper than light by light, and the same
    /// values. Throws std::invalid_argument if `all` does not have exactly `light_count()` places.
    void visibility(const glm::vec3& point, const glm::vec3& normal, std::span<float> all,
                    QueryStatistics* spent = nullptr) const {
        if (all.size() != lights_.size())
            throw_wrong_size("visibilities", all.size(), lights_.size());
        detail::BrickPoints memory[detail::Hemisphere::max_entries];
        Query(*this, point, normal, spent).all(all, memory);
    }

    /// S_i(P) of every light for many points, which share the rays' batches: the same values, faster for
    /// points near to each other (a tile of pixels). `all` is row-major, a row of `light_count()` for each
    /// point. Throws std::invalid_argument unless there are as many normals and rows as points.
    void visibility(std::span<const glm::vec3> points, std::span<const glm::vec3> normals,
                    std::span<float> all, QueryStatistics* spent = nullptr) const;

    /// What the mesh holds by now. Walks over all of it.
    MeshStatistics statistics() const {
        MeshStatistics sum;
        state_->bricks.for_each([&](const detail::Brick& brick) {
            std::uint64_t cells = 0;
            for (std::size_t t = 0; t < lights_.tile_count(); ++t)
                cells |= detail::cells_in(brick.tile(t).known());
            sum.light_points +=
                static_cast<std::size_t>(std::popcount(cells));  // 8 bits for each cell of 8 points
            ++sum.bricks;
        });
        sum.long_tests = state_->long_tests.load(std::memory_order_relaxed);
        sum.long_rays = state_->long_rays.load(std::memory_order_relaxed);
        sum.link_rays = state_->link_rays.load(std::memory_order_relaxed);
        sum.bytes = state_->bricks.bytes() + sizeof *this + lights_.bytes() + long_test_.bytes();
        return sum;
    }

private:
    class Query;

    /// All that changes.
    struct State {
        explicit State(std::size_t tiles) : bricks(tiles) {}
        detail::BrickMap bricks;
        std::atomic<std::uint64_t> long_tests{0};
        std::atomic<std::uint64_t> long_rays{0};
        std::atomic<std::uint64_t> link_rays{0};
    };

    /// Finds the seeds of the linked short test for the queries whose numbers are in `waiting`, with rays in
    /// batches, and does the test.
    void find_seeds(std::span<std::optional<Query>> queries, std::span<std::size_t> waiting) const;

    /// Finds the units in `missing` (see `BrickTile`) by long tests and stores them.
    void fill(detail::Brick& brick, std::size_t tile, std::uint64_t missing) const;

    /// What a light point of the brick reaches over links.
    const detail::Reach& reach_of(const detail::Brick& brick, const glm::ivec3& seed) const {
        if (const detail::Reach* known = brick.reach_of(detail::bit_of(seed.x & 3, seed.y & 3, seed.z & 3)))
            return *known;
        return find_reach(seed);
    }
    const detail::Reach& find_reach(const glm::ivec3& seed) const {
        detail::ReachSearch search(tracer_, grid_, state_->bricks, seed);
        const detail::Reach* found = search.find();
        state_->link_rays.fetch_add(search.rays(), std::memory_order_relaxed);
        return *found;
    }

    [[noreturn]] void throw_no_such_light(std::size_t light) const {
        throw std::out_of_range("lightmesh: there is no light " + std::to_string(light) + "; the mesh has " +
                                std::to_string(lights_.size()));
    }
    [[noreturn]] static void throw_wrong_size(const char* what, std::size_t size, std::size_t expected) {
        throw std::invalid_argument("lightmesh: the span of " + std::string(what) + " has " +
                                    std::to_string(size) + " places; it must have " +
                                    std::to_string(expected));
    }

    Tracer tracer_;
    Grid grid_;
    Settings settings_;
    detail::LightTable lights_;
    LongTest long_test_;
    std::unique_ptr<State> state_;
};

template <class Tracer, class Lights>
LightMesh(Tracer, const Lights&, Settings) -> LightMesh<Tracer>;

template <class Tracer, class Source, class Lights>
LightMesh(Tracer, Source, const Lights&, Settings) -> LightMesh<Tracer, detail::LongTestFrom<Source>>;

/// One query's steps, its state on the stack.
template <class Tracer, class LongTest, class Kernel>
class LightMesh<Tracer, LongTest, Kernel>::Query {
public:
    /// `spent` may be null.
    Query(const LightMesh& mesh, const glm::vec3& point, const glm::vec3& normal, QueryStatistics* spent)
        : mesh_(&mesh), spent_(spent), point_(point), normal_(detail::unit_or_zero(normal)),
          is_valid_(detail::is_finite(point) && detail::is_finite(normal)) {
        if (is_valid_)
            mesh.grid_.locate(point);  // Throws, also where no light reaches.
        if (spent_ != nullptr)
            ++spent_->points;
    }

    /// S of one light. `memory` has `Hemisphere::max_entries` places.
    float one(std::size_t light, detail::BrickPoints* memory) {
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
    void all(std::span<float> values, detail::BrickPoints* memory) {
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
    std::size_t find_neighbours(detail::BrickPoints* memory) {
        const detail::Hemisphere hemisphere(mesh_->grid_, point_, normal_);
        neighbours_.template find<Kernel>(hemisphere, mesh_->state_->bricks, memory);
        if (short_test() == ShortTest::linked)
            candidates_ = {mesh_->grid_, point_, normal_};
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
            segment = {surface_end(), mesh_->grid_.position(seed_)};
            return true;
        }
        neighbours_.clear();
        return false;
    }

    /// The linked short test, P being known to see the seed.
    void link_to_seed() {
        const detail::ReachBox box(seed_, mesh_->settings_.quality);
        const std::size_t slots = detail::ReachBox::slots(mesh_->settings_.quality);
        const detail::Reach& reach = mesh_->reach_of(*seed_brick_, seed_);
        neighbours_.narrow([&](const detail::BrickPoints& entry) {
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
        bool agree = true;
        for (std::size_t t = 0; t < lights().tile_count(); ++t) {
            const auto first = t * detail::lights_per_tile;
            agree &= average_tile(t, count,
                                  values.subspan(first, static_cast<std::size_t>(lights().tile_size(t))));
        }
        return agree;
    }

private:
    /// One byte a light: 1 if it can reach P.
    using Reaching = std::array<std::uint8_t, detail::lights_per_tile>;

    const detail::LightTable& lights() const { return mesh_->lights_; }
    ShortTest short_test() const { return mesh_->settings_.short_test; }

    const Reaching& reaching(std::size_t tile) {
        if (tile != reaching_tile_) {
            lights().find_reaching(tile, point_, normal_, reaching_.data());
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
            if (!mesh_->tracer_.occluded(segment))
                return link_to_seed();
        }
    }

    /// Whether P sees at least one of its neighbours: then the interpolation set is not empty.
    bool sees_any_neighbour() const {
        const glm::vec3 end = surface_end();
        for (const detail::BrickPoints& entry : neighbours_.entries()) {
            for (std::uint64_t rest = entry.points; rest != 0; rest &= rest - 1) {
                if (spent_ != nullptr)
                    ++spent_->short_rays;
                const glm::ivec3 index = detail::index_of(*entry.brick, std::countr_zero(rest));
                if (!mesh_->tracer_.occluded(Segment{end, mesh_->grid_.position(index)}))
                    return true;
            }
        }
        return false;
    }

    /// The short test of equation (2), by a ray for each neighbour.
    void test_neighbours() {
        const glm::vec3 end = surface_end();
        neighbours_.narrow([&](const detail::BrickPoints& entry) {
            std::array<Segment, detail::most_segments> segments;
            std::array<std::uint8_t, detail::most_segments> hit;
            std::size_t size = 0;
            for (std::uint64_t rest = entry.points; rest != 0; rest &= rest - 1) {
                const glm::ivec3 index = detail::index_of(*entry.brick, std::countr_zero(rest));
                segments[size++] = {end, mesh_->grid_.position(index)};
            }
            detail::trace(mesh_->tracer_, std::span(segments).first(size), std::span(hit).first(size));
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
        alignas(64) std::array<std::uint16_t, detail::lights_per_tile> lit{};
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
        std::array<detail::CellRow, capacity + detail::cells_per_brick> rows;
        int size = 0;
        const auto stride = static_cast<std::size_t>(lights().tile_groups(tile));
        for (const detail::BrickPoints& entry : neighbours_.entries()) {
            const std::uint8_t* lit_in_brick = known_tile(entry, tile, groups).rows();
            std::uint64_t cells = detail::cells_in(entry.points) & detail::every_byte;
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
        const std::size_t tile = light / detail::lights_per_tile;
        const std::size_t place = light % detail::lights_per_tile;
        const auto stride = static_cast<std::size_t>(8 * lights().tile_groups(tile));
        int lit = 0;
        for (const detail::BrickPoints& entry : neighbours_.entries()) {
            const std::uint8_t* lit_in_brick = known_tile(entry, tile, 1u << (place / 8)).rows();
            for (std::size_t cell = 0; cell < detail::cells_per_brick; ++cell) {
                const auto points = static_cast<std::uint8_t>(entry.points >> (8 * cell));
                if (points == 0)
                    continue;
                lit += std::popcount(static_cast<std::uint8_t>(lit_in_brick[cell * stride + place] & points));
            }
        }
        return lit;
    }

    /// The entry's tile, after making sure that its light points know the lights of the groups.
    const detail::BrickTile& known_tile(const detail::BrickPoints& entry, std::size_t t,
                                        std::uint32_t groups) {
        detail::BrickTile& tile = entry.brick->tile(t);
        const std::uint64_t needed = detail::cells_in(entry.points) & (groups * detail::every_byte);
        const std::uint64_t missing = needed & ~tile.known();
        if (missing != 0) [[unlikely]]
            mesh_->fill(*entry.brick, t, missing);
        return tile;
    }

    glm::vec3 surface_end() const {
        return detail::surface_end(point_, normal_, static_cast<float>(mesh_->grid_.step()));
    }

    void note_empty() {
        if (spent_ != nullptr)
            ++spent_->empty_points;
    }

    /// The case m = 0 of equation (3).
    float shadow_ray(std::size_t light) {
        if (spent_ != nullptr)
            ++spent_->shadow_rays;
        return mesh_->tracer_.occluded(lights().shadow_segment(light, surface_end())) ? 0.0f : 1.0f;
    }

    void trace_shadow_rays(std::span<float> values) {
        note_empty();
        for (std::size_t t = 0; t < lights().tile_count(); ++t) {
            const Reaching& reaches = reaching(t);
            for (int l = 0; l < lights().tile_size(t); ++l) {
                const std::size_t light = t * detail::lights_per_tile + static_cast<std::size_t>(l);
                values[light] = reaches[static_cast<std::size_t>(l)] != 0 ? shadow_ray(light) : 0.0f;
            }
        }
    }

    const LightMesh* mesh_;
    QueryStatistics* spent_;
    glm::vec3 point_;
    glm::vec3 normal_;
    bool is_valid_;
    detail::Neighbours neighbours_;
    detail::SeedCandidates candidates_;
    glm::ivec3 seed_{0};
    const detail::Brick* seed_brick_ = nullptr;
    std::size_t reaching_tile_ = (std::numeric_limits<std::size_t>::max)();
    Reaching reaching_;
};

template <class Tracer, class LongTest, class Kernel>
void LightMesh<Tracer, LongTest, Kernel>::visibility(std::span<const glm::vec3> points,
                                                     std::span<const glm::vec3> normals, std::span<float> all,
                                                     QueryStatistics* spent) const {
    if (normals.size() != points.size())
        throw_wrong_size("normals", normals.size(), points.size());
    if (all.size() != points.size() * lights_.size())
        throw_wrong_size("visibilities", all.size(), points.size() * lights_.size());
    if (lights_.size() == 0)
        return;
    detail::BrickPoints memory[2 * detail::Hemisphere::max_entries];
    if (settings_.short_test != ShortTest::linked) {
        for (std::size_t i = 0; i < points.size(); ++i)
            Query(*this, points[i], normals[i], spent)
                .all(all.subspan(i * lights_.size(), lights_.size()), memory);
        return;
    }
    // As many points at once as there are places for segments and for neighbours.
    std::array<std::optional<Query>, detail::most_segments> queries;
    for (std::size_t done = 0; done < points.size();) {
        std::array<std::size_t, detail::most_segments> waiting;
        std::size_t waiting_count = 0;
        std::size_t taken = 0;
        std::size_t count = 0;
        for (; count < queries.size() && done + count < points.size(); ++count) {
            if (taken + detail::Hemisphere::max_entries > std::size(memory))
                break;
            Query& query = queries[count].emplace(*this, points[done + count], normals[done + count], spent);
            const auto values = all.subspan((done + count) * lights_.size(), lights_.size());
            if (query.answers_without_neighbours(values)) {
                queries[count].reset();
                continue;
            }
            taken += query.find_neighbours(memory + taken);
            waiting[waiting_count++] = count;
        }
        find_seeds(queries, std::span(waiting).first(waiting_count));
        for (std::size_t i = 0; i < count; ++i)
            if (queries[i])
                queries[i]->average(all.subspan((done + i) * lights_.size(), lights_.size()));
        done += count;
    }
}

template <class Tracer, class LongTest, class Kernel>
void LightMesh<Tracer, LongTest, Kernel>::find_seeds(std::span<std::optional<Query>> queries,
                                                     std::span<std::size_t> waiting) const {
    while (!waiting.empty()) {
        std::array<Segment, detail::most_segments> segments;
        std::array<std::uint8_t, detail::most_segments> hit;
        std::size_t size = 0;
        for (const std::size_t i : waiting)
            if (queries[i]->next_seed(segments[size]))
                waiting[size++] = i;
        detail::trace(tracer_, std::span<const Segment>(segments).first(size), std::span(hit).first(size));
        std::size_t still = 0;
        for (std::size_t k = 0; k < size; ++k) {
            if (hit[k] != 0)
                waiting[still++] = waiting[k];
            else
                queries[waiting[k]]->link_to_seed();
        }
        waiting = waiting.first(still);
    }
}

template <class Tracer, class LongTest, class Kernel>
void LightMesh<Tracer, LongTest, Kernel>::fill(detail::Brick& brick, std::size_t t,
                                               std::uint64_t missing) const {
    detail::BrickTile& tile = brick.tile(t);
    const int groups = lights_.tile_groups(t);
    state_->bricks.ensure_storage(tile, groups);
    std::array<std::uint64_t, 64> units;
    detail::LongTestCost cost;
    for (std::uint64_t rest = missing; rest != 0; rest &= rest - 1) {
        const int unit = std::countr_zero(rest);
        const int group = unit % 8;
        detail::CellPoints points;
        for (int p = 0; p < 8; ++p)
            points[static_cast<std::size_t>(p)] = grid_.position(detail::index_of(brick, unit - group + p));
        const int count = (std::min)(8, lights_.tile_size(t) - 8 * group);
        const std::size_t first = t * detail::lights_per_tile + static_cast<std::size_t>(8 * group);
        units[static_cast<std::size_t>(unit)] =
            long_test_(tracer_, detail::LongTestUnit{lights_, first, count, points, grid_.radius()}, cost);
    }
    brick.publish(t, missing, units.data(), groups);
    state_->long_tests.fetch_add(cost.tests, std::memory_order_relaxed);
    state_->long_rays.fetch_add(cost.rays, std::memory_order_relaxed);
}

}  // namespace lightmesh
