// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/occluders.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/fill/source.hpp>
#include <lightmesh/fill/trace.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/scene_change.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/shadows/shadow_volume.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/check.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// Long tests by shadow volumes (LMM+ATO), of one copy of the user's triangles. They begin where the rays of
/// `RayLongTests` do.
template <Occluders Source>
class VolumeLongTests {
public:
    static constexpr LongTest kind = LongTest::shadow_volumes;

    VolumeLongTests(Source source, std::span<const Light> lights, const Settings& settings)
        : source_(std::move(source)), step_(static_cast<float>(Grid(settings).step())),
          triangles_(std::make_shared<const OccluderTriangles>(source_)),
          volumes_(volumes_of(triangles_, lights)) {}

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

    /// As `RayLongTests`.
    void count(MeshStatistics& sum) const {
        sum.forgotten_grids += forgotten_;
        sum.volume_grids += forgotten_;
        for (const ShadowVolumes& volumes : volumes_)
            sum.volume_grids += volumes.made();
    }

    /// As `RayLongTests`.
    void set_light(std::size_t i, const Light& light) {
        ShadowVolumes volumes = volumes_of(triangles_, i, light);
        forgotten_ += volumes_[i].made();
        volumes_[i] = std::move(volumes);
    }
    void add_light(const Light& light) { volumes_.push_back(volumes_of(triangles_, volumes_.size(), light)); }
    void remove_last() { volumes_.pop_back(); }

    /// As `RayLongTests`. Seen from a light far away, roundings decide about what lies next to a point.
    LightSight sight_of(std::size_t i) const {
        return {.fits_scene = volumes_[i].fits_triangles() || volumes_[i].distance() > 0x1p14f * step_};
    }
    /// As `RayLongTests`.
    struct Change {
        std::vector<bool> is_new;
        std::shared_ptr<const OccluderTriangles> triangles;
        std::vector<std::uint32_t> changed;  ///< triangles that are others, where there are as many
        std::vector<ShadowVolumes> volumes;
    };
    Change prepare_change(std::span<const Light> lights) const {
        Change change{
            std::vector<bool>(lights.size()), std::make_shared<const OccluderTriangles>(source_), {}, {}};
        if (change.triangles->size() == triangles_->size())
            for (std::size_t i = 0; i < triangles_->size(); ++i)
                if ((*change.triangles)[i] != (*triangles_)[i])
                    change.changed.push_back(static_cast<std::uint32_t>(i));
        change.volumes = volumes_of(change.triangles, lights);
        // Where the frame is another one, so are roundings.
        for (std::size_t i = 0; i < lights.size(); ++i)
            change.is_new[i] = !change.volumes[i].has_frames_of(volumes_[i]) ||
                               (sight_of(i).fits_scene && !volumes_[i].fits_triangles());
        return change;
    }
    /// Grids stay that hold no triangle which has changed.
    void commit(Change&& change, std::span<const Bounds>) {
        for (std::size_t i = 0; i < volumes_.size(); ++i) {
            change.volumes[i].take_grids(volumes_[i], change.changed);
            forgotten_ += volumes_[i].made();
        }
        triangles_ = std::move(change.triangles);
        volumes_ = std::move(change.volumes);
    }

private:
    ShadowVolumes volumes_of(const std::shared_ptr<const OccluderTriangles>& triangles, std::size_t i,
                             const Light& light) const {
        return ShadowVolumes(triangles, light, light_clearance(light, step_), "light " + to_text(i));
    }
    std::vector<ShadowVolumes> volumes_of(const std::shared_ptr<const OccluderTriangles>& triangles,
                                          std::span<const Light> lights) const {
        std::vector<ShadowVolumes> volumes;
        volumes.reserve(lights.size());
        for (std::size_t i = 0; i < lights.size(); ++i)
            volumes.push_back(volumes_of(triangles, i, lights[i]));
        return volumes;
    }

    Source source_;
    float step_;
    std::shared_ptr<const OccluderTriangles> triangles_;
    std::vector<ShadowVolumes> volumes_;
    std::uint64_t forgotten_ = 0;  // grids
};

template <Occluders Source>
    requires(!MeansDepthRenderer<Source>)
struct LongTestsOf<Source> {
    using Type = VolumeLongTests<Source>;
};

}  // namespace lightmesh::detail
