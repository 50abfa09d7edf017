// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/occluders.hpp>
#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/fill/source.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/shadows/shadow_volume.hpp>
#include <lightmesh/support/check.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace lightmesh::detail {

/// Long tests by shadow volumes (LMM+ATO), of one copy of the user's triangles. They begin where the rays of
/// `RayLongTests` do.
class VolumeLongTests {
public:
    static constexpr LongTest kind = LongTest::shadow_volumes;

    template <Occluders Source>
    VolumeLongTests(const Source& source, std::span<const Light> lights, const Settings& settings)
        : triangles_(std::make_shared<const OccluderTriangles>(source)) {
        const auto step = static_cast<float>(Grid(settings).step());
        volumes_.reserve(lights.size());
        for (std::size_t i = 0; i < lights.size(); ++i)
            volumes_.emplace_back(triangles_, lights[i], light_clearance(lights[i], step),
                                  "light " + to_text(i));
    }

    /// As `RayLongTests`.
    template <Intersector Tracer>
    void operator()(const Tracer&, const LightTable&, std::size_t light, std::span<const glm::vec3> points,
                    std::span<std::uint8_t> seen, LongTestCost& cost) const {
        cost.tests += points.size();
        for (std::size_t i = 0; i < points.size(); ++i)
            seen[i] = volumes_[light].visible(points[i]) ? 1 : 0;
    }

    std::size_t bytes() const {
        std::size_t sum = triangles_->bytes();
        for (const ShadowVolumes& volumes : volumes_)
            sum += volumes.bytes();
        return sum;
    }

private:
    std::shared_ptr<const OccluderTriangles> triangles_;
    std::vector<ShadowVolumes> volumes_;
};

template <Occluders Source>
    requires(!MeansDepthRenderer<Source>)
struct LongTestsOf<Source> {
    using Type = VolumeLongTests;
};

}  // namespace lightmesh::detail
