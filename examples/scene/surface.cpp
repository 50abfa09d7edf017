// SPDX-License-Identifier: MIT
#include "surface.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>

namespace demo {
namespace {

/// A vertex attribute between the corners of a triangle.
template <class Value>
Value between(const std::vector<Value>& values, const Triangle& triangle, float u, float v) {
    return (1.0f - u - v) * values[triangle.vertex[0]] + u * values[triangle.vertex[1]] +
           v * values[triangle.vertex[2]];
}

glm::vec4 look_up(const Scene& scene, const TextureMap& map, const Triangle& triangle, float u, float v) {
    if (map.texture < 0)
        return glm::vec4{1.0f};
    const std::vector<glm::vec2>& coordinates = scene.texture_coordinates[map.coordinates];
    const glm::vec2 place = coordinates.empty() ? glm::vec2{0.0f} : between(coordinates, triangle, u, v);
    return scene.textures[static_cast<std::size_t>(map.texture)].sample(
        map.transform * glm::vec3(place, 1.0f), map.wrap_u, map.wrap_v);
}

glm::vec4 colour_at(const Scene& scene, const Triangle& triangle, float u, float v) {
    return scene.colours.empty() ? glm::vec4{1.0f} : between(scene.colours, triangle, u, v);
}

float alpha_at(const Scene& scene, const Material& material, const Triangle& triangle, float u, float v) {
    const float alpha = material.opacity * look_up(scene, material.base_map, triangle, u, v).a *
                        look_up(scene, material.opacity_map, triangle, u, v).r *
                        colour_at(scene, triangle, u, v).a;
    return glm::clamp(alpha, 0.0f, 1.0f);
}

}  // namespace

Surface surface_at(const Scene& scene, std::size_t number, float u, float v) {
    return surface_at(scene, scene.materials[scene.triangles[number].material], number, u, v);
}

Surface surface_at(const Scene& scene, const Material& material, std::size_t number, float u, float v) {
    Surface surface{material.diffuse, material.specular, material.emission, material.k_s,
                    material.k_t * material.tint};
    const bool has_colours = !scene.colours.empty();
    if (!has_colours && material.base_map.texture < 0 && material.emission_map.texture < 0 &&
        material.alpha_mode != AlphaMode::blend)
        return surface;
    const Triangle& triangle = scene.triangles[number];
    if (material.base_map.texture >= 0 || has_colours) {
        const glm::vec3 colour{look_up(scene, material.base_map, triangle, u, v) *
                               colour_at(scene, triangle, u, v)};
        surface.diffuse *= colour;
        surface.specular *= glm::mix(glm::vec3{1.0f}, colour, material.metallic);
        surface.k_t *= colour;
    }
    if (material.emission_map.texture >= 0)
        surface.emission *= glm::vec3{look_up(scene, material.emission_map, triangle, u, v)};
    if (material.is_unlit && has_colours)
        surface.emission *= glm::vec3{colour_at(scene, triangle, u, v)};
    if (material.alpha_mode == AlphaMode::blend) {
        const float alpha = alpha_at(scene, material, triangle, u, v);
        surface.diffuse *= alpha;
        surface.specular *= alpha;
        surface.emission *= alpha;
        surface.k_s *= alpha;
        surface.k_t = 1.0f - alpha * (1.0f - surface.k_t);
    }
    return surface;
}

float share_let_through(const Scene& scene, std::size_t number, float u, float v) {
    const Triangle& triangle = scene.triangles[number];
    const Material& material = scene.materials[triangle.material];
    if (material.shadow == ShadowBy::nothing)
        return 1.0f;
    float k_t = 0.0f;
    if (material.shadow == ShadowBy::opacity && material.k_t > 0.0f) {
        // Shadows have no colour: the share of all light.
        const glm::vec3 colour = material.tint * glm::vec3{look_up(scene, material.base_map, triangle, u, v) *
                                                           colour_at(scene, triangle, u, v)};
        k_t = material.k_t * glm::dot(colour, glm::vec3{0.2126f, 0.7152f, 0.0722f});
    }
    if (material.alpha_mode == AlphaMode::mask)
        return alpha_at(scene, material, triangle, u, v) < material.alpha_cutoff ? 1.0f : k_t;
    if (material.alpha_mode == AlphaMode::blend)
        return 1.0f - alpha_at(scene, material, triangle, u, v) * (1.0f - k_t);
    return k_t;
}

bool is_hole(const Scene& scene, std::size_t number, float u, float v) {
    const Triangle& triangle = scene.triangles[number];
    const Material& material = scene.materials[triangle.material];
    return material.alpha_mode == AlphaMode::mask &&
           alpha_at(scene, material, triangle, u, v) < material.alpha_cutoff;
}

bool may_let_light_through(const Material& material) {
    return material.shadow == ShadowBy::nothing || material.alpha_mode != AlphaMode::opaque ||
           (material.shadow == ShadowBy::opacity && material.k_t > 0.0f);
}

}  // namespace demo
