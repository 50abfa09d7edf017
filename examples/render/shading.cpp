// SPDX-License-Identifier: MIT
#include "render/shading.hpp"

#include "render/illumination.hpp"
#include "scene/surface.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace demo {

namespace {

/// Schlick's approximation: `cosine` to the normal of the power of five.
float grazing(float cosine) {
    const float rest = glm::clamp(1.0f - cosine, 0.0f, 1.0f);
    return rest * rest * rest * rest * rest;
}

/// The share of irradiance that a rough surface reflects, times pi and the cosine to the light. Walter and
/// others, "Microfacet Models for Refraction through Rough Surfaces", 2007, and the diffuse lobe of Burley,
/// "Physically-Based Shading at Disney", 2012. A `specular` of 0 reflects nothing at grazing angles either.
glm::vec3 rough_reflection(const Surface& surface, float roughness, const glm::vec3& normal,
                           const glm::vec3& to_eye, const glm::vec3& to_light) {
    const float to_n = glm::dot(normal, to_light);
    const float from_n = (std::max)(glm::dot(normal, to_eye), 1e-4f);
    const glm::vec3 halfway = glm::normalize(to_light + to_eye);
    const float half_n = (std::max)(glm::dot(normal, halfway), 0.0f);
    const float half_to = (std::max)(glm::dot(to_light, halfway), 0.0f);
    const float width = (std::max)(roughness * roughness, 0.01f);
    const float squared = width * width;
    const float spread = half_n * half_n * (squared - 1.0f) + 1.0f;
    // The density of facets, and Smith's masking over 4 times both cosines, without 1/pi.
    const float facets = squared / (spread * spread);
    const float masking = 0.5f / (to_n * std::sqrt(squared + (1.0f - squared) * from_n * from_n) +
                                  from_n * std::sqrt(squared + (1.0f - squared) * to_n * to_n));
    const glm::vec3& head_on = surface.specular;
    const glm::vec3 fresnel =
        head_on + (glm::clamp(50.0f * head_on, 0.0f, 1.0f) - head_on) * grazing(half_to);
    const float edge = 0.5f + 2.0f * half_to * half_to * roughness - 1.0f;
    const float matt = (1.0f + edge * grazing(to_n)) * (1.0f + edge * grazing(from_n));
    return to_n * (matt * surface.diffuse + facets * masking * fresnel);
}

}  // namespace

glm::vec3 shade(const Scene& scene, const Hit& hit, const glm::vec3& ray_direction,
                std::span<const float> lit, float ambient) {
    const Material& material = scene.materials[hit.material];
    const Surface surface = surface_at(scene, material, hit.triangle, hit.u, hit.v);
    glm::vec3 sum = ambient * scene.ambient * surface.diffuse + surface.emission;
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        if (lit[l] == 0.0f)
            continue;
        const Illumination light = illuminate(scene.lights[l], hit.position);
        const float lambert = glm::dot(hit.shading_normal, light.to_light);
        if (lambert <= 0.0f)
            continue;
        glm::vec3 reflected = lambert * surface.diffuse;
        if (material.highlight == Highlight::ggx) {
            reflected = rough_reflection(surface, material.roughness, hit.shading_normal, -ray_direction,
                                         light.to_light);
        } else if (surface.specular != glm::vec3(0.0f)) {
            const glm::vec3 halfway = glm::normalize(light.to_light - ray_direction);
            const float highlight = (std::max)(0.0f, glm::dot(hit.shading_normal, halfway));
            reflected += std::pow(highlight, material.shininess) * surface.specular;
        }
        sum += lit[l] * reflected * light.irradiance;
    }
    return sum;
}

glm::vec3 refracted(const Hit& hit, const glm::vec3& direction, float refraction_index) {
    const float ratio = hit.from_inside ? refraction_index : 1.0f / refraction_index;
    const glm::vec3 through = glm::refract(direction, hit.shading_normal, ratio);
    return through != glm::vec3(0.0f) ? through : glm::reflect(direction, hit.shading_normal);
}

}  // namespace demo
