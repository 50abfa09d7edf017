// SPDX-License-Identifier: MIT
#pragma once

#include "model.hpp"

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace demo {

/// Goes over all of a model: `archive.bytes(pointer, size)` is called for each plain value and each array of
/// them, once `archive.resize(container)` has made it as long as the other side has it. One function for both
/// directions, so that they cannot differ.

template <class Archive, class Value>
    requires std::is_trivially_copyable_v<Value>
void exchange(Archive& archive, Value& value) {
    archive.bytes(&value, sizeof(Value));
}

template <class Archive>
void exchange(Archive& archive, std::string& text) {
    archive.resize(text);
    archive.bytes(text.data(), text.size());
}

template <class Archive, class... Values>
void exchange_all(Archive& archive, Values&... values);

template <class Archive>
void exchange(Archive& archive, Material& value);
template <class Archive>
void exchange(Archive& archive, ModelMesh& value);
template <class Archive>
void exchange(Archive& archive, ModelLight& value);
template <class Archive>
void exchange(Archive& archive, ModelCamera& value);
template <class Archive>
void exchange(Archive& archive, ModelImage& value);

template <class Archive, class Value>
void exchange(Archive& archive, std::vector<Value>& values) {
    archive.resize(values);
    if constexpr (std::is_trivially_copyable_v<Value>)
        archive.bytes(values.data(), values.size() * sizeof(Value));
    else
        for (Value& value : values)
            exchange(archive, value);
}

template <class Archive, class... Values>
void exchange_all(Archive& archive, Values&... values) {
    (exchange(archive, values), ...);
}

template <class Archive>
void exchange(Archive& archive, Material& m) {
    exchange_all(archive, m.name, m.diffuse, m.specular, m.shininess, m.k_s, m.k_t, m.refraction_index,
                 m.tint, m.emission, m.metallic, m.opacity, m.alpha_mode, m.alpha_cutoff, m.base_map,
                 m.opacity_map, m.emission_map, m.is_unlit, m.shadow);
}

template <class Archive>
void exchange(Archive& archive, ModelMesh& m) {
    exchange_all(archive, m.name, m.positions, m.normals, m.texture_coordinates[0], m.texture_coordinates[1],
                 m.colours, m.indices, m.material);
}

template <class Archive>
void exchange(Archive& archive, ModelLight& l) {
    exchange_all(archive, l.name, l.kind, l.position, l.axis, l.intensity, l.range, l.inner_cone,
                 l.outer_cone);
}

template <class Archive>
void exchange(Archive& archive, ModelCamera& c) {
    exchange_all(archive, c.name, c.eye, c.ahead, c.up, c.vertical_field_of_view, c.orthographic_height);
}

template <class Archive>
void exchange(Archive& archive, ModelImage& i) {
    exchange_all(archive, i.name, i.texture.width, i.texture.height, i.texture.rgba, i.texture.has_alpha,
                 i.problem);
}

template <class Archive>
void exchange(Archive& archive, Model& m) {
    exchange_all(archive, m.meshes, m.materials, m.images, m.lights, m.cameras, m.notes, m.animation_length);
}

}  // namespace demo
