// SPDX-License-Identifier: MIT
#include "gltf_materials.hpp"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace demo {
namespace {

using tinygltf::Value;

const Value* member(const Value* object, const char* name) {
    return object != nullptr && object->IsObject() && object->Has(name) ? &object->Get(name) : nullptr;
}

float number(const Value* object, const char* name, float otherwise) {
    const Value* value = member(object, name);
    return value != nullptr && value->IsNumber() ? static_cast<float>(value->GetNumberAsDouble()) : otherwise;
}

glm::vec2 pair(const Value* object, const char* name, glm::vec2 otherwise) {
    const Value* value = member(object, name);
    if (value == nullptr || !value->IsArray() || value->ArrayLen() != 2 || !value->Get(0).IsNumber() ||
        !value->Get(1).IsNumber())
        return otherwise;
    return {value->Get(0).GetNumberAsDouble(), value->Get(1).GetNumberAsDouble()};
}

float share(double value) {
    return value > 0.0 ? static_cast<float>((std::min)(value, 1.0)) : 0.0f;
}

glm::vec3 colour_of(const std::vector<double>& values, glm::vec3 otherwise) {
    if (values.size() < 3)
        return otherwise;
    glm::vec3 colour{values[0], values[1], values[2]};
    for (int channel = 0; channel < 3; ++channel)
        colour[channel] = colour[channel] >= 0.0f && std::isfinite(colour[channel]) ? colour[channel] : 0.0f;
    return colour;
}

Wrap wrap_of(int mode) {
    if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE)
        return Wrap::clamp;
    return mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::mirror : Wrap::repeat;
}

/// KHR_texture_transform: translation * rotation * scale.
glm::mat3x2 transform_of(const Value* transform) {
    const glm::vec2 offset = pair(transform, "offset", {0.0f, 0.0f});
    const glm::vec2 scale = pair(transform, "scale", {1.0f, 1.0f});
    const float angle = number(transform, "rotation", 0.0f);
    const float cosine = std::cos(angle);
    const float sine = std::sin(angle);
    return {scale.x * cosine, -scale.x * sine, scale.y * sine, scale.y * cosine, offset.x, offset.y};
}

/// The picture of a texture. Pictures in formats of extensions come last: the plain one is what can be read.
int image_of(const tinygltf::Texture& texture) {
    if (texture.source >= 0)
        return texture.source;
    for (const char* name :
         {"EXT_texture_webp", "KHR_texture_basisu", "EXT_texture_avif", "MSFT_texture_dds"}) {
        const Value* source = member(gltf_extension(texture.extensions, name), "source");
        if (source != nullptr && source->IsNumber())
            return source->GetNumberAsInt();
    }
    return -1;
}

TextureMap map_of(const GltfFile& file, int texture, int coordinates, const Value* transform) {
    TextureMap map;
    const tinygltf::Model& model = file.model();
    if (texture < 0 || static_cast<std::size_t>(texture) >= model.textures.size())
        return map;
    const tinygltf::Texture& source = model.textures[static_cast<std::size_t>(texture)];
    const int image = image_of(source);
    if (image < 0 || static_cast<std::size_t>(image) >= file.image_count())
        return map;
    map.texture = image;
    map.coordinates = static_cast<std::uint32_t>(
        std::clamp(static_cast<int>(number(transform, "texCoord", static_cast<float>(coordinates))), 0, 1));
    if (source.sampler >= 0 && static_cast<std::size_t>(source.sampler) < model.samplers.size()) {
        map.wrap_u = wrap_of(model.samplers[static_cast<std::size_t>(source.sampler)].wrapS);
        map.wrap_v = wrap_of(model.samplers[static_cast<std::size_t>(source.sampler)].wrapT);
    }
    map.transform = transform_of(transform);
    return map;
}

TextureMap map_of(const GltfFile& file, const tinygltf::TextureInfo& info) {
    return map_of(file, info.index, info.texCoord, gltf_extension(info.extensions, "KHR_texture_transform"));
}

/// As `map_of`, of a texture that stands in an extension.
TextureMap map_in(const GltfFile& file, const Value* info) {
    const Value* transform = member(member(info, "extensions"), "KHR_texture_transform");
    return map_of(file, static_cast<int>(number(info, "index", -1.0f)),
                  static_cast<int>(number(info, "texCoord", 0.0f)), transform);
}

/// The colour of KHR_materials_volume through its thickness.
glm::vec3 attenuation(const Value* volume) {
    const float thickness = number(volume, "thicknessFactor", 0.0f);
    const float distance = number(volume, "attenuationDistance", INFINITY);
    const Value* colour = member(volume, "attenuationColor");
    if (!(thickness > 0.0f) || !(distance > 0.0f) || colour == nullptr || !colour->IsArray() ||
        colour->ArrayLen() != 3)
        return glm::vec3{1.0f};
    glm::vec3 result{1.0f};
    for (int channel = 0; channel < 3; ++channel)
        if (colour->Get(channel).IsNumber())
            result[channel] = std::pow(share(colour->Get(channel).GetNumberAsDouble()), thickness / distance);
    return result;
}

/// KHR_materials_pbrSpecularGlossiness, which older files have: its diffuse colour.
bool set_specular_glossiness(const GltfFile& file, const tinygltf::Material& source, Material& material,
                             MetallicRoughness& values) {
    const Value* old = gltf_extension(source.extensions, "KHR_materials_pbrSpecularGlossiness");
    if (old == nullptr)
        return false;
    values.metallic = 0.0f;
    values.roughness = 1.0f - share(static_cast<double>(number(old, "glossinessFactor", 1.0f)));
    const Value* factor = member(old, "diffuseFactor");
    if (factor != nullptr && factor->IsArray() && factor->ArrayLen() == 4) {
        for (int channel = 0; channel < 3; ++channel)
            values.base[channel] = share(factor->Get(channel).GetNumberAsDouble());
        material.opacity = share(factor->Get(3).GetNumberAsDouble());
    }
    material.base_map = map_in(file, member(old, "diffuseTexture"));
    return true;
}

}  // namespace

void set_metallic_roughness(Material& material, const MetallicRoughness& values) {
    const float smoothness = (1.0f - values.roughness) * (1.0f - values.roughness);
    material.k_t = 0.9f * values.transmission;
    material.k_s = (std::min)(0.85f * values.metallic * smoothness, 1.0f - material.k_t);
    material.refraction_index = values.refraction_index;
    material.metallic = values.metallic;
    material.diffuse = values.base * (1.0f - material.k_s) * (1.0f - material.k_t);
    material.specular = smoothness * glm::mix(glm::vec3{0.2f}, values.base, values.metallic);
    const float alpha = (std::max)(values.roughness * values.roughness, 0.03f);
    material.shininess = (std::max)(2.0f / (alpha * alpha) - 2.0f, 1.0f);
}

Material gltf_material(const GltfFile& file, std::size_t number_of_it, bool& left_out) {
    const tinygltf::Material& source = file.model().materials[number_of_it];
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    Material material;
    material.name = source.name.empty() ? "material " + std::to_string(number_of_it) : source.name;
    material.shadow = ShadowBy::opacity;
    MetallicRoughness values;
    if (!set_specular_glossiness(file, source, material, values)) {
        values.base = colour_of(pbr.baseColorFactor, glm::vec3{1.0f});
        values.metallic = share(pbr.metallicFactor);
        values.roughness = share(pbr.roughnessFactor);
        material.opacity = pbr.baseColorFactor.size() == 4 ? share(pbr.baseColorFactor[3]) : 1.0f;
        material.base_map = map_of(file, pbr.baseColorTexture);
    }
    const Value* transmission = gltf_extension(source.extensions, "KHR_materials_transmission");
    const Value* volume = gltf_extension(source.extensions, "KHR_materials_volume");
    const Value* ior = gltf_extension(source.extensions, "KHR_materials_ior");
    values.transmission = share(static_cast<double>(number(transmission, "transmissionFactor", 0.0f)));
    // Without a volume glass is a thin sheet, which does not bend rays.
    if (number(volume, "thicknessFactor", 0.0f) > 0.0f)
        values.refraction_index = (std::max)(1.0f, number(ior, "ior", 1.5f));
    set_metallic_roughness(material, values);
    material.tint = values.base * attenuation(volume);

    if (source.alphaMode == "MASK")
        material.alpha_mode = AlphaMode::mask;
    else if (source.alphaMode == "BLEND")
        material.alpha_mode = AlphaMode::blend;
    material.alpha_cutoff = static_cast<float>(source.alphaCutoff);
    const Value* strength = gltf_extension(source.extensions, "KHR_materials_emissive_strength");
    material.emission = colour_of(source.emissiveFactor, glm::vec3{0.0f}) *
                        (std::max)(0.0f, number(strength, "emissiveStrength", 1.0f));
    material.emission_map = map_of(file, source.emissiveTexture);
    if (source.emissiveTexture.index >= 0 && material.emission_map.texture < 0)
        material.emission = glm::vec3{0.0f};  // the factor alone would make everything shine
    if (gltf_extension(source.extensions, "KHR_materials_unlit") != nullptr) {
        material.is_unlit = true;
        material.emission = values.base;
        material.emission_map = material.base_map;
        material.diffuse = glm::vec3{0.0f};
        material.specular = glm::vec3{0.0f};
        material.k_s = 0.0f;
    }
    left_out = left_out || source.normalTexture.index >= 0 || pbr.metallicRoughnessTexture.index >= 0 ||
               source.occlusionTexture.index >= 0 || member(transmission, "transmissionTexture") != nullptr;
    return material;
}

}  // namespace demo
