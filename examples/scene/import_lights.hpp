// SPDX-License-Identifier: MIT
#pragma once

#include "import_materials.hpp"
#include "scene.hpp"

#include <assimp/scene.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace demo {

inline glm::vec3 to_glm(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}

/// A node with its transform to the world.
struct PlacedNode {
    const aiNode* node;
    aiMatrix4x4 to_world;
};

/// All nodes, children before their parents: the order in which Assimp reads them from a glTF file.
inline void collect_nodes(const aiNode& node, const aiMatrix4x4& parent, std::vector<PlacedNode>& result) {
    const aiMatrix4x4 to_world = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumChildren; ++i) {
        collect_nodes(*node.mChildren[i], to_world, result);
    }
    result.push_back({&node, to_world});
}

inline glm::vec3 transform_point(const aiMatrix4x4& matrix, glm::vec3 p) {
    return to_glm(matrix * aiVector3D{p.x, p.y, p.z});
}

inline glm::vec3 transform_direction(const aiMatrix4x4& matrix, glm::vec3 d) {
    return to_glm(aiMatrix3x3{matrix} * aiVector3D{d.x, d.y, d.z});
}

/// The number of the light that a glTF node carries, as the file counts.
inline std::optional<std::uint64_t> light_number(const aiNode& node) {
    aiMetadata extensions;
    aiMetadata punctual;
    std::uint64_t number = 0;
    if (node.mMetaData && node.mMetaData->Get("extensions", extensions) &&
        extensions.Get("KHR_lights_punctual", punctual) && punctual.Get("light", number)) {
        return number;
    }
    return std::nullopt;
}

/// Which of Assimp's lights stands at which node. Assimp 5.2 gives each light the name of one node only, and
/// nodes may share a light or a name; so lights are matched by the order in which the nodes first refer to
/// them, which is the order in which Assimp reads them.
struct PlacedLight {
    const aiLight* light;
    PlacedNode place;
};

inline std::vector<PlacedLight> place_lights(const aiScene& source, const std::vector<PlacedNode>& nodes) {
    std::vector<PlacedLight> result;
    std::vector<std::uint64_t> seen;
    for (const PlacedNode& placed : nodes) {
        const auto number = light_number(*placed.node);
        if (!number) {
            continue;
        }
        auto found = std::find(seen.begin(), seen.end(), *number);
        if (found == seen.end()) {
            found = seen.insert(seen.end(), *number);
        }
        const auto index = static_cast<std::size_t>(found - seen.begin());
        if (index < source.mNumLights) {
            result.push_back({source.mLights[index], placed});
        }
    }
    return result;
}

/// A light as KHR_lights_punctual defines it: at the origin of its node, along the node's -z.
inline std::optional<SceneLight> convert_light(const PlacedLight& placed) {
    const aiLight& source = *placed.light;
    const glm::vec3 position = transform_point(placed.place.to_world, glm::vec3{0.0f});
    const glm::vec3 axis =
        glm::normalize(transform_direction(placed.place.to_world, to_glm(source.mDirection)));
    float range = std::numeric_limits<float>::infinity();
    if (placed.place.node->mMetaData) {
        placed.place.node->mMetaData->Get("PBR_LightRange", range);
    }
    SceneLight light;
    light.intensity = to_glm(source.mColorDiffuse);
    switch (source.mType) {
    case aiLightSource_POINT:
        light.shape = lightmesh::PointLight{position, range};
        return light;
    case aiLightSource_DIRECTIONAL:
        light.shape = lightmesh::DirectionalLight{axis};
        return light;
    case aiLightSource_SPOT:  // Assimp hands on glTF's half angles
        light.shape = lightmesh::SpotLight{position, axis, source.mAngleOuterCone, range};
        light.inner_cone = source.mAngleInnerCone;
        return light;
    default:
        return std::nullopt;
    }
}

/// A camera at its node. Assimp 5.2 also copies the node's translation into the camera's position: counted
/// twice if one followed its documentation.
inline Camera convert_camera(const aiCamera& source, const aiMatrix4x4& to_world, glm::vec3 centre) {
    Camera camera;
    camera.eye = transform_point(to_world, glm::vec3{0.0f});
    const glm::vec3 ahead = glm::normalize(transform_direction(to_world, to_glm(source.mLookAt)));
    camera.up = glm::normalize(transform_direction(to_world, to_glm(source.mUp)));
    const float distance = glm::dot(centre - camera.eye, ahead);
    camera.target = camera.eye + (distance > 0.0f ? distance : 1.0f) * ahead;
    // It hands on the vertical angle times the aspect ratio, where there is one.
    camera.vertical_field_of_view =
        source.mAspect > 0.0f ? source.mHorizontalFOV / source.mAspect : source.mHorizontalFOV;
    return camera;
}

}  // namespace demo
