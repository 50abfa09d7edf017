// SPDX-License-Identifier: MIT
#pragma once

#include "../examples/scene/scene.hpp"

#include <embree3/rtcore.h>
#include <glm/vec3.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace test {

/// Triangles in an Embree scene, to trace against.
class EmbreeScene {
public:
    EmbreeScene(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices)
        : positions_(positions.begin(), positions.end()), indices_(indices.begin(), indices.end()),
          device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        RTCGeometry mesh = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        positions_.emplace_back(0.0f);  // Embree reads 16 bytes at each vertex
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions_.data(), 0,
                                   sizeof(glm::vec3), positions.size());
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices_.data(), 0, 12,
                                   indices.size() / 3);
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(scene_, mesh);
        rtcReleaseGeometry(mesh);
        rtcCommitScene(scene_);
    }
    EmbreeScene(const EmbreeScene&) = delete;
    ~EmbreeScene() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }

    RTCScene scene() const { return scene_; }

    RTCRayHit trace(const glm::vec3& origin, const glm::vec3& way, float t_far) const {
        RTCRayHit hit{};
        hit.ray.org_x = origin.x;
        hit.ray.org_y = origin.y;
        hit.ray.org_z = origin.z;
        hit.ray.dir_x = way.x;
        hit.ray.dir_y = way.y;
        hit.ray.dir_z = way.z;
        hit.ray.tfar = t_far;
        hit.ray.mask = ~0u;
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        hit.hit.primID = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_, &context, &hit);
        return hit;
    }

    bool blocked(const glm::vec3& from, const glm::vec3& to) const {
        return trace(from, to - from, 1.0f).hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }

private:
    std::vector<glm::vec3> positions_;
    std::vector<std::uint32_t> indices_;
    RTCDevice device_;
    RTCScene scene_;
};

}  // namespace test
