// SPDX-License-Identifier: MIT
#pragma once

#include "adapters/embree_intersector.hpp"

#include <glm/vec3.hpp>

#include <cstddef>

namespace bench {

/// Sets ray `i` of a packet of any width to the segment from `origin` to `target`.
template <class Packet>
void set_ray(Packet& rays, std::size_t i, const glm::vec3& origin, const glm::vec3& target) {
    rays.org_x[i] = origin.x;
    rays.org_y[i] = origin.y;
    rays.org_z[i] = origin.z;
    rays.dir_x[i] = target.x - origin.x;
    rays.dir_y[i] = target.y - origin.y;
    rays.dir_z[i] = target.z - origin.z;
    rays.tnear[i] = 0.0f;
    rays.tfar[i] = 1.0f;
    rays.time[i] = 0.0f;
    rays.mask[i] = ~0u;
    rays.flags[i] = 0;
}

inline RTCRay make_ray(const glm::vec3& origin, const glm::vec3& target) {
    RTCRay ray{};
    ray.org_x = origin.x;
    ray.org_y = origin.y;
    ray.org_z = origin.z;
    ray.dir_x = target.x - origin.x;
    ray.dir_y = target.y - origin.y;
    ray.dir_z = target.z - origin.z;
    ray.tfar = 1.0f;
    ray.mask = ~0u;
    return ray;
}

/// The calls of Embree 3 and 4 behind one face. Embree 4 has no streams.
class Occlusion {
public:
    Occlusion(RTCScene scene, bool coherent) : scene_(scene) {
#if RTC_VERSION_MAJOR >= 4
        rtcInitOccludedArguments(&how_);
        how_.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
#else
        rtcInitIntersectContext(&how_);
        how_.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
#endif
    }

    /// Afterwards tfar < 0 where a ray is blocked.
#if RTC_VERSION_MAJOR >= 4
    void trace(RTCRay& ray) {
        rtcOccluded1(scene_, &ray, &how_);
    }
    void trace(const int* valid, RTCRay8& rays) {
        rtcOccluded8(valid, scene_, &rays, &how_);
    }
    void trace(const int* valid, RTCRay16& rays) {
        rtcOccluded16(valid, scene_, &rays, &how_);
    }
#else
    void trace(RTCRay& ray) {
        rtcOccluded1(scene_, &how_, &ray);
    }
    void trace(const int* valid, RTCRay8& rays) {
        rtcOccluded8(valid, scene_, &how_, &rays);
    }
    void trace(const int* valid, RTCRay16& rays) {
        rtcOccluded16(valid, scene_, &how_, &rays);
    }
    void trace_stream(RTCRay* rays, std::size_t count) {
        rtcOccluded1M(scene_, &how_, rays, static_cast<unsigned int>(count), sizeof(RTCRay));
    }
#endif

private:
    RTCScene scene_;
#if RTC_VERSION_MAJOR >= 4
    RTCOccludedArguments how_;
#else
    RTCIntersectContext how_;
#endif
};

}  // namespace bench
