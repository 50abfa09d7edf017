// SPDX-License-Identifier: MIT
#include "gpu/scene_words.hpp"

#include "image/image.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <variant>

namespace demo {

namespace {

std::uint32_t bits(float value) {
    return std::bit_cast<std::uint32_t>(value);
}

glm::uvec4 four(const glm::vec3& a, float b) {
    return {bits(a.x), bits(a.y), bits(a.z), bits(b)};
}

// ---- vertices

void add(std::vector<float>& words, const float* values, int count) {
    words.insert(words.end(), values, values + count);
}

void place_attributes(SceneWords& words, const Scene& scene) {
    const auto place = [&](bool is_there, std::uint32_t size) {
        const std::uint32_t at = is_there ? words.words_of_vertex : 0;
        words.words_of_vertex += is_there ? size : 0;
        return at;
    };
    words.attributes[0] = place(!scene.normals.empty(), 3);
    words.attributes[1] = place(!scene.colours.empty(), 4);
    words.attributes[2] = place(!scene.texture_coordinates[0].empty(), 2);
    words.attributes[3] = place(!scene.texture_coordinates[1].empty(), 2);
}

// ---- materials

void add_map(std::vector<glm::uvec4>& table, const TextureMap& map) {
    const glm::mat3x2& by = map.transform;
    table.emplace_back(static_cast<std::uint32_t>(map.texture),
                       map.coordinates | static_cast<std::uint32_t>(map.wrap_u) << 1 |
                           static_cast<std::uint32_t>(map.wrap_v) << 3,
                       bits(by[2][0]), bits(by[2][1]));
    table.emplace_back(bits(by[0][0]), bits(by[0][1]), bits(by[1][0]), bits(by[1][1]));
}

void add_material(std::vector<glm::uvec4>& table, const Material& material) {
    table.push_back(four(material.diffuse, material.opacity));
    table.push_back(four(material.specular, material.shininess));
    table.push_back(four(material.emission, material.k_s));
    table.push_back(four(material.tint, material.k_t));
    table.push_back(
        four({material.refraction_index, material.metallic, material.alpha_cutoff}, material.roughness));
    table.emplace_back(static_cast<std::uint32_t>(material.alpha_mode),
                       static_cast<std::uint32_t>(material.shadow),
                       (material.highlight == Highlight::ggx ? 1u : 0u) | (material.is_unlit ? 2u : 0u), 0u);
    add_map(table, material.base_map);
    add_map(table, material.opacity_map);
    add_map(table, material.emission_map);
}

// ---- lights

/// A light of any kind, as shaders know it.
struct LightWords {
    std::uint32_t kind = 0;
    glm::vec3 position{0.0f};
    float range = std::numeric_limits<float>::infinity();
    glm::vec3 axis{0.0f};
    float cone = 0.0f;
    glm::vec3 half_u{0.0f};
    glm::vec3 half_v{0.0f};
    float radius = 0.0f;
    float area = 1.0f;
};

struct WordsOfShape {
    LightWords operator()(const lightmesh::PointLight& light) const {
        return {.kind = 0, .position = light.position, .range = light.range, .radius = light.radius};
    }
    LightWords operator()(const lightmesh::DirectionalLight& light) const {
        return {.kind = 1, .axis = glm::normalize(light.direction)};
    }
    LightWords operator()(const lightmesh::SpotLight& light) const {
        return {.kind = 2,
                .position = light.position,
                .range = light.range,
                .axis = glm::normalize(light.axis),
                .cone = light.cone};
    }
    LightWords operator()(const lightmesh::RectLight& light) const {
        const glm::vec3 front = glm::cross(light.half_u, light.half_v);
        return {.kind = 3,
                .position = light.position,
                .range = light.range,
                .axis = glm::normalize(front),
                .half_u = light.half_u,
                .half_v = light.half_v,
                .area = 4.0f * glm::length(front)};
    }
};

void add_light(std::vector<glm::uvec4>& table, const SceneLight& light, float size) {
    const LightWords words = std::visit(WordsOfShape{}, light.shape);
    table.emplace_back(words.kind, light.fall_off == FallOff::lamps ? 1u : 0u, 0u, 0u);
    table.push_back(four(words.position, words.area));
    // No infinity, and nothing to divide by that is 0: shaders need not know either.
    table.push_back(four(light.intensity, std::clamp(words.range, 1e-30f, 1e30f)));
    table.push_back(four(words.axis, std::cos(words.cone)));
    table.push_back(four(words.half_u, std::cos((std::min)(light.inner_cone, words.cone))));
    table.push_back(four(words.half_v, size));
    table.push_back(four(light.facing, words.radius));
    table.emplace_back(0u);
}

// ---- textures

void add_texture(SceneWords& words, const Texture& texture) {
    words.tables.emplace_back(static_cast<std::uint32_t>(words.texels.size()),
                              static_cast<std::uint32_t>(texture.width),
                              static_cast<std::uint32_t>(texture.height),
                              texture.is_linear        ? 1u
                              : texture.blends_encoded ? 2u
                                                       : 0u);
    for (std::size_t i = 0; i + 3 < texture.rgba.size(); i += 4)
        words.texels.push_back(static_cast<std::uint32_t>(texture.rgba[i]) |
                               static_cast<std::uint32_t>(texture.rgba[i + 1]) << 8 |
                               static_cast<std::uint32_t>(texture.rgba[i + 2]) << 16 |
                               static_cast<std::uint32_t>(texture.rgba[i + 3]) << 24);
}

void add_curve(std::vector<glm::uvec4>& table) {
    for (int i = 0; i < 64; ++i) {
        glm::uvec4 next;
        for (int k = 0; k < 4; ++k)
            next[k] = bits(from_srgb(static_cast<float>(4 * i + k) / 255.0f));
        table.push_back(next);
    }
}

}  // namespace

std::vector<float> vertices_of(const Scene& scene) {
    std::vector<float> words;
    SceneWords layout;
    place_attributes(layout, scene);
    words.reserve(layout.words_of_vertex * scene.positions.size());
    for (std::size_t i = 0; i < scene.positions.size(); ++i) {
        add(words, &scene.positions[i].x, 3);
        if (!scene.normals.empty())
            add(words, &scene.normals[i].x, 3);
        if (!scene.colours.empty())
            add(words, &scene.colours[i].x, 4);
        for (const auto& coordinates : scene.texture_coordinates)
            if (!coordinates.empty())
                add(words, &coordinates[i].x, 2);
    }
    return words;
}

std::vector<glm::uvec4> lights_of(const Scene& scene, std::span<const float> sizes) {
    std::vector<glm::uvec4> words;
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        add_light(words, scene.lights[i], sizes[i]);
    return words;
}

SceneWords words_of(const Scene& scene, std::span<const float> sizes) {
    SceneWords words;
    for (const Triangle& triangle : scene.triangles)
        words.corners.emplace_back(triangle.vertex[0], triangle.vertex[1], triangle.vertex[2],
                                   triangle.material);
    place_attributes(words, scene);
    words.vertices = vertices_of(scene);
    const auto here = [&] {
        return static_cast<std::uint32_t>(words.tables.size());
    };
    for (const Material& material : scene.materials)
        add_material(words.tables, material);
    words.tables_at[1] = here();
    std::ranges::copy(lights_of(scene, sizes), std::back_inserter(words.tables));
    words.tables_at[2] = here();
    for (const Texture& texture : scene.textures)
        add_texture(words, texture);
    words.tables_at[3] = here();
    add_curve(words.tables);
    return words;
}

}  // namespace demo
