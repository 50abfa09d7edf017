// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/depth_renderer.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/fill/source.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/scene_change.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/shadows/shadow_map.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/check.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// Long tests by looking into shadow maps (LMM+ATK); with `Settings::refine_shadow_maps`, by rays where a map
/// cannot tell. The maps begin where the rays of `RayLongTests` do.
template <DepthRenderer Renderer>
class MapLongTests {
public:
    static constexpr LongTest kind = LongTest::shadow_maps;

    MapLongTests(Renderer renderer, std::span<const Light> lights, const Settings& settings)
        : renderer_(std::make_shared<SharedDepthRenderer<Renderer>>(std::move(renderer))),
          settings_(settings), step_(static_cast<float>(Grid(settings).step())) {
        maps_.reserve(lights.size());
        for (std::size_t i = 0; i < lights.size(); ++i)
            maps_.push_back(map_of(i, lights[i]));
    }

    /// As `RayLongTests`.
    template <Intersector Tracer>
    void operator()(const Tracer& tracer, const LightTable& lights, std::size_t light,
                    std::span<const glm::vec3> points, std::span<std::uint8_t> seen,
                    LongTestCost& cost) const {
        const ShadowMap<Renderer>& map = *maps_[light];
        cost.tests += points.size();
        if (!settings_.refine_shadow_maps) {
            for (std::size_t i = 0; i < points.size(); ++i)
                seen[i] = map.visible(points[i]) ? 1 : 0;
            return;
        }
        std::array<glm::vec3, most_in_long_test<Tracer>> unsure;
        std::array<std::uint16_t, most_in_long_test<Tracer>> places;
        std::array<std::uint8_t, most_in_long_test<Tracer>> open;
        std::size_t size = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const ShadowMapLookup in_map = map.look_up(points[i]);
            seen[i] = in_map == ShadowMapLookup::lit ? 1 : 0;
            if (in_map == ShadowMapLookup::edge) {
                unsure[size] = points[i];
                places[size++] = static_cast<std::uint16_t>(i);
            }
        }
        trace_long_test(tracer, lights, light, std::span<const glm::vec3>(unsure).first(size),
                        std::span(open).first(size), cost);
        for (std::size_t i = 0; i < size; ++i)
            seen[places[i]] = open[i];
    }

    std::size_t bytes() const {
        std::size_t sum = maps_.capacity() * sizeof maps_[0];
        for (const auto& map : maps_)
            sum += map->bytes();
        return sum;
    }

    /// As `RayLongTests`.
    void count(MeshStatistics& sum) const {
        sum.forgotten_pictures += forgotten_;
        sum.depth_pictures += forgotten_;
        for (const auto& map : maps_)
            sum.depth_pictures += map->rendered();
    }

    /// As `RayLongTests`.
    void set_light(std::size_t i, const Light& light) {
        auto map = map_of(i, light);
        forgotten_ += maps_[i]->rendered();
        maps_[i] = std::move(map);
    }
    void add_light(const Light& light) { maps_.push_back(map_of(maps_.size(), light)); }
    void remove_last() { maps_.pop_back(); }

    /// As `RayLongTests`. Texels show what lies beyond a point, too; the centres of those that are asked are
    /// up to one side away along both axes, at a picture's edge two.
    LightSight sight_of(std::size_t i) const {
        const ShadowMap<Renderer>& map = *maps_[i];
        return {3.0 * map.texel_angle(), 3.0 * map.texel_side(), SegmentEnd::beyond_point,
                map.texel_side() > 0.0};
    }
    /// As `RayLongTests`.
    struct Change {
        std::vector<bool> is_new;
        std::vector<std::unique_ptr<ShadowMap<Renderer>>> maps;  ///< of these lights
    };
    Change prepare_change(std::span<const Light> lights) const {
        Change change{std::vector<bool>(lights.size()), {}};
        change.maps.resize(lights.size());
        for (std::size_t i = 0; i < lights.size(); ++i) {
            auto map = map_of(i, lights[i]);
            change.is_new[i] = !map->has_views_of(*maps_[i]);
            if (change.is_new[i])
                change.maps[i] = std::move(map);
        }
        return change;
    }
    /// Pictures that may show a box are rendered anew when they are needed.
    void commit(Change&& change, std::span<const Bounds> boxes) {
        for (std::size_t i = 0; i < maps_.size(); ++i) {
            const std::size_t before = maps_[i]->rendered();
            if (change.is_new[i])
                maps_[i] = std::move(change.maps[i]);
            else
                maps_[i]->forget(boxes);
            forgotten_ += before - maps_[i]->rendered();
        }
    }

private:
    std::unique_ptr<ShadowMap<Renderer>> map_of(std::size_t i, const Light& light) const {
        const ShadowMapSettings map{.resolution = settings_.shadow_map_size,
                                    .z_near = light_clearance(light, step_),
                                    .scene_bounds = settings_.scene_bounds};
        return std::make_unique<ShadowMap<Renderer>>(renderer_, light, map, "light " + to_text(i));
    }

    std::shared_ptr<SharedDepthRenderer<Renderer>> renderer_;
    Settings settings_;
    float step_;
    std::vector<std::unique_ptr<ShadowMap<Renderer>>> maps_;
    std::uint64_t forgotten_ = 0;  // pictures
};

template <DepthRenderer Source>
    requires(!MeansOccluders<Source>)
struct LongTestsOf<Source> {
    static_assert(check_depth_renderer<Source>());
    using Type = MapLongTests<Source>;
};

}  // namespace lightmesh::detail
