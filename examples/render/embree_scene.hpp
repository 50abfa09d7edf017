// SPDX-License-Identifier: MIT
#pragma once

#include "adapters/embree_intersector.hpp"
#include "scene/scene.hpp"

#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>
#include <optional>

namespace demo {

/// Where a ray first meets a surface.
struct Hit {
    glm::vec3 position;
    glm::vec3 geometric_normal;  ///< unit length, towards where the ray came from
    glm::vec3 shading_normal;    ///< unit length, on the same side
    std::uint32_t material;
    bool from_inside;  ///< whether the ray came from the back of the triangle
};

/// A scene's triangles in an Embree BVH. Const members may be used by any number of threads.
class EmbreeScene {
public:
    /// Builds the BVH, on all cores. The scene must outlive this. Throws std::runtime_error with Embree's own
    /// words.
    explicit EmbreeScene(const Scene& scene);

    const Scene& scene() const { return scene_; }
    RTCScene handle() const { return handle_.get(); }
    EmbreeIntersector intersector() const { return EmbreeIntersector(handle_.get()); }

    /// Seconds that the BVH took.
    double seconds_building() const { return seconds_building_; }
    /// How far rays leave surfaces behind them, along the normal: world units, by the size of the
    /// coordinates.
    float offset() const { return offset_; }
    /// Of the box around all triangles.
    float diagonal() const { return diagonal_; }
    /// A distance beyond everything: where rays to directional lights end.
    float far_away() const { return 2.0f * diagonal_; }

    /// The first surface on origin + t * direction, t > 0.
    std::optional<Hit> trace(const glm::vec3& origin, const glm::vec3& direction) const;

private:
    struct Release {
        void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    const Scene& scene_;
    double seconds_building_;
    float offset_;
    float diagonal_;
    std::unique_ptr<RTCDeviceTy, Release> device_;
    std::unique_ptr<RTCSceneTy, Release> handle_;
};

}  // namespace demo
