// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <assimp/GltfMaterial.h>
#include <assimp/ObjMaterial.h>
#include <assimp/material.h>
#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace demo {

inline glm::vec3 to_glm(const aiColor3D& c) {
    return {c.r, c.g, c.b};
}

/// The value of a key, or `otherwise` if the material has none.
template <typename Value>
Value get_or(const aiMaterial& source, const char* key, unsigned type, unsigned index, Value otherwise) {
    Value value{};
    return source.Get(key, type, index, value) == AI_SUCCESS ? value : otherwise;
}

/// MTL: Kd, Ks, Ns, d and Ni; Whitted's shares by the illumination model: 3 and above mirror by Ks.
inline void convert_phong(const aiMaterial& source, Material& material) {
    constexpr int first_mirroring_model = 3;
    material.specular = to_glm(get_or(source, AI_MATKEY_COLOR_SPECULAR, aiColor3D{0.0f}));
    material.shininess = get_or(source, AI_MATKEY_SHININESS, 0.0f);
    if (material.shininess <=
        0.0f) {  // no exponent: Assimp's white default would be a highlight over everything
        material.specular = glm::vec3{0.0f};
        material.shininess = 1.0f;
    }
    material.k_t = std::clamp(1.0f - get_or(source, AI_MATKEY_OPACITY, 1.0f), 0.0f, 1.0f);
    const float index = get_or(source, AI_MATKEY_REFRACTI, 1.0f);
    material.refraction_index = index > 0.0f ? index : 1.0f;
    if (get_or(source, AI_MATKEY_OBJ_ILLUM, 0) >= first_mirroring_model) {
        const glm::vec3 s = material.specular;
        material.k_s = std::clamp((s.r + s.g + s.b) / 3.0f, 0.0f, 1.0f - material.k_t);
    }
}

/// glTF's metal and roughness, as near as Whitted's model gets: only smooth metal mirrors.
inline void convert_metallic_roughness(const aiMaterial& source, Material& material) {
    const aiColor3D base_colour = get_or(source, AI_MATKEY_BASE_COLOR, aiColor3D{0.8f});
    const glm::vec3 base = to_glm(base_colour);
    const float metallic = std::clamp(get_or(source, AI_MATKEY_METALLIC_FACTOR, 1.0f), 0.0f, 1.0f);
    const float roughness = std::clamp(get_or(source, AI_MATKEY_ROUGHNESS_FACTOR, 1.0f), 0.0f, 1.0f);
    const float smoothness = (1.0f - roughness) * (1.0f - roughness);
    const float transmission = std::clamp(get_or(source, AI_MATKEY_TRANSMISSION_FACTOR, 0.0f), 0.0f, 1.0f);
    const float opacity = std::clamp(get_or(source, AI_MATKEY_OPACITY, 1.0f), 0.0f, 1.0f);
    material.k_s = 0.85f * metallic * smoothness;
    material.k_t = (std::max)(0.9f * transmission, 1.0f - opacity);
    material.k_s = (std::min)(material.k_s, 1.0f - material.k_t);
    material.refraction_index = transmission > 0.0f ? 1.5f : 1.0f;  // glTF's blending does not bend rays
    material.diffuse = base * (1.0f - material.k_s) * (1.0f - material.k_t);
    material.specular = smoothness * glm::mix(glm::vec3{0.2f}, base, metallic);
    const float alpha = (std::max)(roughness * roughness, 0.03f);
    material.shininess = (std::max)(2.0f / (alpha * alpha) - 2.0f, 1.0f);
}

inline bool has_texture(const aiMaterial& source) {
    for (int type = aiTextureType_DIFFUSE; type <= AI_TEXTURE_TYPE_MAX; ++type) {
        if (source.GetTextureCount(static_cast<aiTextureType>(type)) > 0) {
            return true;
        }
    }
    return false;
}

inline Material convert_material(const aiMaterial& source, std::size_t number) {
    Material material;
    material.name = get_or(source, AI_MATKEY_NAME, aiString{}).C_Str();
    if (material.name.empty()) {
        material.name = "material " + std::to_string(number);
    }
    material.diffuse = to_glm(get_or(source, AI_MATKEY_COLOR_DIFFUSE, aiColor3D{0.8f}));
    material.emission = to_glm(get_or(source, AI_MATKEY_COLOR_EMISSIVE, aiColor3D{0.0f}));
    float unused = 0.0f;
    if (source.Get(AI_MATKEY_METALLIC_FACTOR, unused) == AI_SUCCESS) {
        convert_metallic_roughness(source, material);
    } else {
        convert_phong(source, material);
    }
    return material;
}

}  // namespace demo
