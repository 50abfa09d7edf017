// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <lightmesh/adapters/depth_view.hpp>
#include <lightmesh/bounds.hpp>

#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace demo {

/// A `lightmesh::DepthRenderer` that traces one ray through the middle of each texel: exact, and slower than
/// a rasteriser. Needs a committed scene, and oneTBB for all cores. Copy it into your program.
class EmbreeDepthRenderer {
public:
    /// Keeps a reference to the scene, as Embree counts them.
    explicit EmbreeDepthRenderer(RTCScene scene) : scene_(scene) { rtcRetainScene(scene_); }
    EmbreeDepthRenderer(const EmbreeDepthRenderer& other) : EmbreeDepthRenderer(other.scene_) {}
    EmbreeDepthRenderer& operator=(EmbreeDepthRenderer other) {
        std::swap(scene_, other.scene_);
        return *this;
    }
    ~EmbreeDepthRenderer() { rtcReleaseScene(scene_); }

    void render_depth(const lightmesh::DepthView& view, std::span<float> distance) {
        const int tiles = (view.resolution + 3) / 4;
        // In isolation: a thread that waits here must not take over a task of the caller's, which may query
        // the mesh that waits for this picture.
        tbb::this_task_arena::isolate([&] {
            tbb::parallel_for(tbb::blocked_range<int>(0, tiles), [&](const tbb::blocked_range<int>& rows) {
                for (int row = rows.begin(); row != rows.end(); ++row)
                    for (int column = 0; column < tiles; ++column)
                        trace_tile(view, 4 * column, 4 * row, distance);
            });
        });
    }

    lightmesh::Bounds bounds() const {
        RTCBounds box;
        rtcGetSceneBounds(scene_, &box);
        return {{box.lower_x, box.lower_y, box.lower_z}, {box.upper_x, box.upper_y, box.upper_z}};
    }

private:
    /// 4x4 texels in one packet; those beyond the right and lower edge are left out.
    void trace_tile(const lightmesh::DepthView& view, int left, int top, std::span<float> distance) const {
        alignas(64) int valid[16];
        RTCRayHit16 packet;
        for (int i = 0; i < 16; ++i) {
            const int column = left + i % 4;
            const int row = top + i / 4;
            valid[i] = column < view.resolution && row < view.resolution ? -1 : 0;
            const lightmesh::DepthRay ray = view.ray(column, row);
            set_ray(packet.ray, i, ray, view.z_near / glm::dot(ray.direction, view.forward));
            packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        intersect(valid, packet);
        for (int i = 0; i < 16; ++i) {
            if (valid[i] == 0)
                continue;
            const auto place =
                static_cast<std::size_t>(top + i / 4) * static_cast<std::size_t>(view.resolution) +
                static_cast<std::size_t>(left + i % 4);
            const bool hit = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
            distance[place] = hit ? packet.ray.tfar[i] : std::numeric_limits<float>::infinity();
        }
    }

    static void set_ray(RTCRay16& rays, int i, const lightmesh::DepthRay& ray, float t_near) {
        rays.org_x[i] = ray.origin.x;
        rays.org_y[i] = ray.origin.y;
        rays.org_z[i] = ray.origin.z;
        rays.dir_x[i] = ray.direction.x;
        rays.dir_y[i] = ray.direction.y;
        rays.dir_z[i] = ray.direction.z;
        rays.tnear[i] = t_near;
        rays.tfar[i] = std::numeric_limits<float>::infinity();
        rays.time[i] = 0.0f;
        rays.mask[i] = ~0u;
        rays.id[i] = 0;
        rays.flags[i] = 0;
    }

    void intersect(const int* valid, RTCRayHit16& packet) const {
#if RTC_VERSION_MAJOR >= 4
        RTCIntersectArguments arguments;
        rtcInitIntersectArguments(&arguments);
        arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
        rtcIntersect16(valid, scene_, &packet, &arguments);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        rtcIntersect16(valid, scene_, &context, &packet);
#endif
    }

    RTCScene scene_;
};

}  // namespace demo
