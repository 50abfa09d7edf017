// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/bounds.hpp>
#include <lightmesh/fill/ray_ends.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/light_shape.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/scene_change.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/statistics.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// V(L, x), the visibility of a light from light points. Here what all long tests share, and the one by rays.

namespace lightmesh::detail {

/// The most light points that a long test is asked about at once.
template <Intersector Tracer>
inline constexpr std::size_t most_in_long_test = (std::max)(largest_batch<Tracer>(), most_segments);

/// The cost of long tests so far.
struct LongTestCost {
    std::uint64_t tests = 0;
    std::uint64_t rays = 0;
};

/// The distance from the light at which the rays of long tests start; what is nearer hides nothing (see
/// `light_end`). 0 for directional lights, which are nowhere.
inline float light_clearance(const Light& light, float step) {
    const LightShape shape = shape_of(light);
    return shape.is_directional ? 0.0f : end_offset(shape.at, step);
}

/// Sets seen[i] to 1 if a light is seen from points[i], else to 0: by rays.
template <Intersector Tracer>
void trace_long_test(const Tracer& tracer, const LightTable& lights, std::size_t light,
                     std::span<const glm::vec3> points, std::span<std::uint8_t> seen, LongTestCost& cost) {
    std::array<Segment, most_in_long_test<Tracer>> segments;
    for (std::size_t i = 0; i < points.size(); ++i)
        segments[i] = lights.long_segment(light, points[i]);
    trace(tracer, std::span<const Segment>(segments).first(points.size()), seen);
    cost.rays += points.size();
    for (std::uint8_t& is_seen : seen)
        is_seen = is_seen == 0 ? 1 : 0;
}

/// Long tests by rays of the user's tracer.
class RayLongTests {
public:
    static constexpr LongTest kind = LongTest::rays;

    /// Of up to `most_in_long_test` points; `seen` has as many places.
    template <Intersector Tracer>
    void operator()(const Tracer& tracer, const LightTable& lights, std::size_t light,
                    std::span<const glm::vec3> points, std::span<std::uint8_t> seen,
                    LongTestCost& cost) const {
        cost.tests += points.size();
        trace_long_test(tracer, lights, light, points, seen, cost);
    }

    std::size_t bytes() const { return 0; }
    /// Adds what was made to see lights by, and what of it updates have forgotten.
    void count(MeshStatistics&) const {}

    /// Gets ready for a light to be replaced, or added behind all others. Throws what the constructor throws
    /// for it; nothing has changed then.
    void set_light(std::size_t, const Light&) {}
    void add_light(const Light&) {}
    void remove_last() {}
    /// The way that a light looks at the scene.
    LightSight sight_of(std::size_t) const { return {}; }
    /// The source that long tests will be made of, now that the scene has changed.
    struct Change {
        std::vector<bool> is_new;  ///< lights that look at it in another way: nothing of them holds
    };
    /// Throws what reading the scene anew throws; nothing has changed then.
    Change prepare_change(std::span<const Light> lights) const { return {std::vector<bool>(lights.size())}; }
    /// The scene has changed in some boxes.
    void commit(Change&&, std::span<const Bounds>) {}
};

}  // namespace lightmesh::detail
