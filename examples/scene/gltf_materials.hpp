// SPDX-License-Identifier: MIT
#pragma once

#include "gltf_file.hpp"

#include <cstddef>

namespace demo {

/// glTF's metal and roughness, as near as Whitted's model gets: only smooth metal mirrors.
struct MetallicRoughness {
    glm::vec3 base{1.0f};
    float metallic = 1.0f;
    float roughness = 1.0f;
    float transmission = 0.0f;
    float refraction_index = 1.0f;
};
void set_metallic_roughness(Material& material, const MetallicRoughness& values);

/// Material `number` of the file; textures refer to the file's pictures. `left_out` is set if a texture of it
/// is not drawn that changes how light is reflected: of normals, roughness, occlusion.
Material gltf_material(const GltfFile& file, std::size_t number, bool& left_out);

}  // namespace demo
