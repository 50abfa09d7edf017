// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <assimp/ObjMaterial.h>
#include <assimp/material.h>
#include <glm/common.hpp>

#include <algorithm>
#include <cstddef>
#include <string>

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

/// MTL: Kd, Ks, Ns, d, Tf, Ni and Ke; Whitted's shares by the illumination model: 3 and above mirror by Ks.
inline Material convert_material(const aiMaterial& source, std::size_t number) {
    constexpr int first_mirroring_model = 3;
    Material material;
    material.shadow = ShadowBy::opacity;
    material.name = get_or(source, AI_MATKEY_NAME, aiString{}).C_Str();
    if (material.name.empty()) {
        material.name = "material " + std::to_string(number);
    }
    material.diffuse = to_glm(get_or(source, AI_MATKEY_COLOR_DIFFUSE, aiColor3D{0.8f}));
    material.emission = to_glm(get_or(source, AI_MATKEY_COLOR_EMISSIVE, aiColor3D{0.0f}));
    material.specular = to_glm(get_or(source, AI_MATKEY_COLOR_SPECULAR, aiColor3D{0.0f}));
    material.shininess = get_or(source, AI_MATKEY_SHININESS, 0.0f);
    if (material.shininess <=
        0.0f) {  // no exponent: Assimp's white default would be a highlight over everything
        material.specular = glm::vec3{0.0f};
        material.shininess = 1.0f;
    }
    material.k_t = std::clamp(1.0f - get_or(source, AI_MATKEY_OPACITY, 1.0f), 0.0f, 1.0f);
    material.tint =
        glm::clamp(to_glm(get_or(source, AI_MATKEY_COLOR_TRANSPARENT, aiColor3D{1.0f})), 0.0f, 1.0f);
    const float index = get_or(source, AI_MATKEY_REFRACTI, 1.0f);
    material.refraction_index = index > 0.0f ? index : 1.0f;
    if (get_or(source, AI_MATKEY_OBJ_ILLUM, 0) >= first_mirroring_model) {
        const glm::vec3 s = material.specular;
        material.k_s = std::clamp((s.r + s.g + s.b) / 3.0f, 0.0f, 1.0f - material.k_t);
    }
    return material;
}

}  // namespace demo
