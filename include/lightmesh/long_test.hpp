// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/light_table.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/shadow_map.hpp>
#include <lightmesh/trace.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

/// V(L, x), the visibility of a light from a light point. A long test answers for one unit at a time (see
/// `brick.hpp`).

namespace lightmesh::detail {

/// The eight light points of a cell.
using CellPoints = std::array<glm::vec3, 8>;

/// What long tests have cost so far.
struct LongTestCost {
    std::uint64_t tests = 0;
    std::uint64_t rays = 0;
};

/// What a long test is asked: does light first + l, l < count <= 8, see points[p]? Lights that no point
/// within `radius` of the cell can be reached by are dark and cost nothing. The answer has bit 8 l + p set
/// for yes.
struct LongTestUnit {
    const LightTable& lights;
    std::size_t first;
    int count;
    const CellPoints& points;
    float radius;

    /// Calls visit(light, l) for the lights that need an answer.
    template <class Visitor>
    void for_each_light(Visitor&& visit) const {
        for (int l = 0; l < count; ++l) {
            const std::size_t light = first + static_cast<std::size_t>(l);
            if (lights.in_range(light, points.front(), points.back(), radius))
                visit(light, l);
        }
    }
};

/// Segments of a unit that are yet to be traced, and the bits they decide.
class PendingSegments {
public:
    void add(const Segment& segment, int bit) {
        segments_[size_] = segment;
        bits_[size_++] = static_cast<std::uint8_t>(bit);
    }

    /// The bits of the segments that are open.
    template <Intersector Tracer>
    std::uint64_t trace_all(const Tracer& tracer, LongTestCost& cost) const {
        std::array<std::uint8_t, most_segments> hit;
        trace(tracer, std::span(segments_).first(size_), std::span(hit).first(size_));
        cost.rays += size_;
        std::uint64_t open = 0;
        for (std::size_t i = 0; i < size_; ++i)
            open |= static_cast<std::uint64_t>(hit[i] == 0) << bits_[i];
        return open;
    }

private:
    std::size_t size_ = 0;
    std::array<Segment, most_segments> segments_;
    std::array<std::uint8_t, most_segments> bits_;
};

/// Long tests by rays of the user's tracer.
class RayLongTest {
public:
    template <Intersector Tracer>
    std::uint64_t operator()(const Tracer& tracer, const LongTestUnit& unit, LongTestCost& cost) const {
        PendingSegments pending;
        unit.for_each_light([&](std::size_t light, int l) {
            for (int p = 0; p < 8; ++p)
                pending.add(unit.lights.long_segment(light, unit.points[static_cast<std::size_t>(p)]),
                            8 * l + p);
            cost.tests += 8;
        });
        return pending.trace_all(tracer, cost);
    }

    std::size_t bytes() const { return 0; }
};

/// Long tests by looking into shadow maps (LMM+ATK); with `Settings::refine_shadow_maps`, by rays where a map
/// cannot tell.
template <DepthRenderer Renderer>
class MapLongTest {
public:
    MapLongTest(Renderer renderer, std::span<const Light> lights, const Settings& settings)
        : refine_(settings.refine_shadow_maps) {
        const auto shared = std::make_shared<SharedDepthRenderer<Renderer>>(std::move(renderer));
        const ShadowMapSettings map{.resolution = settings.shadow_map_size,
                                    .scene_bounds = settings.scene_bounds};
        maps_.reserve(lights.size());
        for (std::size_t i = 0; i < lights.size(); ++i)
            maps_.push_back(
                std::make_unique<const ShadowMap<Renderer>>(shared, lights[i], map, "light " + to_text(i)));
    }

    template <Intersector Tracer>
    std::uint64_t operator()(const Tracer& tracer, const LongTestUnit& unit, LongTestCost& cost) const {
        PendingSegments pending;
        std::uint64_t lit = 0;
        unit.for_each_light([&](std::size_t light, int l) {
            const ShadowMap<Renderer>& map = *maps_[light];
            for (int p = 0; p < 8; ++p) {
                const glm::vec3& point = unit.points[static_cast<std::size_t>(p)];
                const int bit = 8 * l + p;
                if (!refine_) {
                    lit |= static_cast<std::uint64_t>(map.visible(point)) << bit;
                    continue;
                }
                const ShadowMapLookup seen = map.look_up(point);
                if (seen == ShadowMapLookup::edge)
                    pending.add(unit.lights.long_segment(light, point), bit);
                else
                    lit |= static_cast<std::uint64_t>(seen == ShadowMapLookup::lit) << bit;
            }
            cost.tests += 8;
        });
        return lit | pending.trace_all(tracer, cost);
    }

    std::size_t bytes() const {
        std::size_t sum = maps_.capacity() * sizeof maps_[0];
        for (const auto& map : maps_)
            sum += map->bytes();
        return sum;
    }

private:
    std::vector<std::unique_ptr<const ShadowMap<Renderer>>> maps_;
    bool refine_;
};

/// The long test that a user's second adapter stands for.
template <class Source>
struct LongTestOf {
    static_assert(check_depth_renderer<Source>());
    using Type = MapLongTest<Source>;
};
template <class Source>
using LongTestFrom = typename LongTestOf<Source>::Type;

}  // namespace lightmesh::detail
