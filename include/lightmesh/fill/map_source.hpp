// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/depth_renderer.hpp>
#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/fill/source.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/shadows/shadow_map.hpp>
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
        : refine_(settings.refine_shadow_maps) {
        const auto shared = std::make_shared<SharedDepthRenderer<Renderer>>(std::move(renderer));
        ShadowMapSettings map{.resolution = settings.shadow_map_size, .scene_bounds = settings.scene_bounds};
        const auto step = static_cast<float>(Grid(settings).step());
        maps_.reserve(lights.size());
        for (std::size_t i = 0; i < lights.size(); ++i) {
            map.z_near = light_clearance(lights[i], step);
            maps_.push_back(
                std::make_unique<const ShadowMap<Renderer>>(shared, lights[i], map, "light " + to_text(i)));
        }
    }

    /// As `RayLongTests`.
    template <Intersector Tracer>
    void operator()(const Tracer& tracer, const LightTable& lights, std::size_t light,
                    std::span<const glm::vec3> points, std::span<std::uint8_t> seen,
                    LongTestCost& cost) const {
        const ShadowMap<Renderer>& map = *maps_[light];
        cost.tests += points.size();
        if (!refine_) {
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

private:
    std::vector<std::unique_ptr<const ShadowMap<Renderer>>> maps_;
    bool refine_;
};

template <DepthRenderer Source>
    requires(!MeansOccluders<Source>)
struct LongTestsOf<Source> {
    static_assert(check_depth_renderer<Source>());
    using Type = MapLongTests<Source>;
};

}  // namespace lightmesh::detail
