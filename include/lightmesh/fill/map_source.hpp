// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/depth_renderer.hpp>
#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/shadows/shadow_map.hpp>
#include <lightmesh/support/check.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// Long tests by looking into shadow maps (LMM+ATK); with `Settings::refine_shadow_maps`, by rays where a map
/// cannot tell. The maps begin where the rays of `RayLongTest` do.
template <DepthRenderer Renderer>
class MapLongTest {
public:
    MapLongTest(Renderer renderer, std::span<const Light> lights, const Settings& settings)
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

}  // namespace lightmesh::detail
