// SPDX-License-Identifier: MIT
#pragma once

// A light mesh's Intersector on Embree 3 or 4. Copy this file into your program.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <lightmesh/segment.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

namespace demo {

/// Asks an Embree scene whether segments are blocked. Copies share the scene, which stays alive as long as
/// any of them. The scene must be committed, and must not change while a light mesh uses it.
class EmbreeIntersector {
public:
    explicit EmbreeIntersector(RTCScene scene) : scene_(scene) { rtcRetainScene(scene_); }
    EmbreeIntersector(const EmbreeIntersector& other) : EmbreeIntersector(other.scene_) {}
    EmbreeIntersector(EmbreeIntersector&& other) noexcept : scene_(std::exchange(other.scene_, nullptr)) {}
    EmbreeIntersector& operator=(EmbreeIntersector other) noexcept {
        std::swap(scene_, other.scene_);
        return *this;
    }
    ~EmbreeIntersector() {
        if (scene_ != nullptr)
            rtcReleaseScene(scene_);
    }

    bool occluded(const lightmesh::Segment& segment) const {
        RTCRay ray = ray_along(segment);
#if RTC_VERSION_MAJOR >= 4
        rtcOccluded1(scene_, &ray);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(scene_, &context, &ray);
#endif
        return is_blocked(ray.tfar);
    }

    /// Where a segment first meets a surface.
    std::optional<lightmesh::Hit> closest_hit(const lightmesh::Segment& segment) const {
        RTCRayHit query{};
        query.ray = ray_along(segment);
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
        rtcIntersect1(scene_, &query);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_, &context, &query);
#endif
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
            return std::nullopt;
        const float length = glm::length(segment.target - segment.origin);
        return lightmesh::Hit{query.ray.tfar * length,
                              glm::normalize(glm::vec3(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z))};
    }

    /// Many segments at once. Embree 3 takes them as one stream: its INCOHERENT streams were the fastest form
    /// of long tests in foliage and no slower elsewhere. Embree 4 has no streams: packets of 16.
    void occluded(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) const {
#if RTC_VERSION_MAJOR >= 4
        for (std::size_t first = 0; first < segments.size(); first += 16) {
            const std::size_t count = (std::min)(segments.size() - first, std::size_t{16});
            occluded_packet(segments.subspan(first, count), hit.subspan(first, count));
        }
#else
        constexpr std::size_t most = 64;
        for (std::size_t first = 0; first < segments.size(); first += most) {
            const std::size_t count = (std::min)(segments.size() - first, most);
            RTCRay rays[most];
            for (std::size_t i = 0; i < count; ++i)
                rays[i] = ray_along(segments[first + i]);
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            rtcOccluded1M(scene_, &context, rays, static_cast<unsigned int>(count), sizeof(RTCRay));
            for (std::size_t i = 0; i < count; ++i)
                hit[first + i] = is_blocked(rays[i].tfar) ? 1 : 0;
        }
#endif
    }

private:
    static RTCRay ray_along(const lightmesh::Segment& segment) {
        RTCRay ray{};
        ray.org_x = segment.origin.x;
        ray.org_y = segment.origin.y;
        ray.org_z = segment.origin.z;
        ray.dir_x = segment.target.x - segment.origin.x;
        ray.dir_y = segment.target.y - segment.origin.y;
        ray.dir_z = segment.target.z - segment.origin.z;
        ray.tfar = 1.0f;
        ray.mask = ~0u;
        return ray;
    }

    /// Embree marks a blocked ray by tfar = -infinity.
    static bool is_blocked(float tfar) {
        return tfar < 0.0f;
    }

#if RTC_VERSION_MAJOR >= 4
    void occluded_packet(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) const {
        alignas(64) int valid[16] = {};
        alignas(64) RTCRay16 rays{};
        for (std::size_t i = 0; i < segments.size(); ++i) {
            const RTCRay ray = ray_along(segments[i]);
            valid[i] = -1;
            rays.org_x[i] = ray.org_x;
            rays.org_y[i] = ray.org_y;
            rays.org_z[i] = ray.org_z;
            rays.dir_x[i] = ray.dir_x;
            rays.dir_y[i] = ray.dir_y;
            rays.dir_z[i] = ray.dir_z;
            rays.tfar[i] = ray.tfar;
            rays.mask[i] = ray.mask;
        }
        rtcOccluded16(valid, scene_, &rays);
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = is_blocked(rays.tfar[i]) ? 1 : 0;
    }
#endif

    RTCScene scene_;
};

}  // namespace demo
