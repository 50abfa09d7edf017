// SPDX-License-Identifier: MIT
#pragma once

#include "render/light_lanes.hpp"
#include "scene/scene.hpp"

#include <lightmesh/segment.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <span>
#include <vector>

namespace demo {

/// The effect of a light on a point if nothing stands between them.
struct Illumination {
    glm::vec3 to_light;    ///< unit length
    glm::vec3 irradiance;  ///< on a surface that faces the light; 0 out of range and outside the cone
};

/// Inverse squares for point and spot lights, with the window to the range and the fall-off from `inner_cone`
/// to the cone that glTF's KHR_lights_punctual recommends. `FallOff::lamps`: the irradiance vector of a
/// rectangle (Arvo, "Analytic Methods for Simulated Light Transport", 1995; what lies below the horizon of
/// the surface counts too), that of a disc across the way to the point for a point light, and for spots the
/// cosine to the axis times a smooth step to the edge.
Illumination illuminate(const SceneLight& light, const glm::vec3& point);

/// As `Illumination`, of lights that stand beside each other.
struct Illuminations {
    OfLights to_light[3];
    OfLights irradiance[3];
};

/// The lights of a scene, for the illumination by many.
class LightTable {
public:
    /// The lights must outlive it.
    explicit LightTable(std::span<const SceneLight> lights);

    /// What `illuminate` says of the lights from `first` on, a multiple of `lights_at_once`. Of those that
    /// `lit` has 0 for it may be anything.
    void illuminate(std::size_t first, const glm::vec3& point, const OfLights& lit,
                    Illuminations& found) const;

private:
    struct Block {
        OfLights position[3]{};
        OfLights intensity[3]{};
        OfLights range{};
        OfLights disc_radius{};
        std::vector<std::size_t> others{};  ///< places of those that are no plain points
    };

    std::span<const SceneLight> lights_;
    std::vector<Block> blocks_;
};

/// The segment of a hard shadow ray. It leaves the surface by `offset` along the normal and ends as far short
/// of a lamp (world units); one to a directional light ends `far` away.
lightmesh::Segment shadow_segment(const SceneLight& light, const glm::vec3& point, const glm::vec3& normal,
                                  float offset, float far_away);

}  // namespace demo
