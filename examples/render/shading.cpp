// SPDX-License-Identifier: MIT
#include "render/shading.hpp"

#include "render/light_lanes.hpp"
#include "scene/surface.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace demo {

namespace {

/// Schlick's approximation: `cosine` to the normal of the power of five.
float grazing(float cosine) {
    const float rest = glm::clamp(1.0f - cosine, 0.0f, 1.0f);
    return rest * rest * rest * rest * rest;
}

/// The same of cosines to several lights.
void graze(OfLights& cosines) {
    OfLights rest = 1.0f - cosines;
    raise_to(rest, 0.0f);
    limit_to(rest, 1.0f);
    cosines = rest * rest * rest * rest * rest;
}

/// The share of the irradiance by each of several lights that a surface reflects, in three colours.
using Reflections = OfLights[3];

/// Of a rough surface, times pi: Walter and others, "Microfacet Models for Refraction through Rough
/// Surfaces", 2007, and the diffuse lobe of Burley, "Physically-Based Shading at Disney", 2012. A `specular`
/// of 0 reflects nothing at grazing angles either. `to_n`: the cosines to the lights.
void reflect_roughly(const Surface& surface, float roughness, const glm::vec3& normal,
                     const glm::vec3& to_eye, const OfLights& to_n, const Illuminations& light,
                     Reflections& reflected) {
    const float from_n = (std::max)(glm::dot(normal, to_eye), 1e-4f);
    const float width = (std::max)(roughness * roughness, 0.01f);
    const float squared = width * width;
    OfLights half[3];
    for (int axis = 0; axis < 3; ++axis)
        half[axis] = light.to_light[axis] + to_eye[axis];
    OfLights length = half[0] * half[0] + half[1] * half[1] + half[2] * half[2];
    take_roots(length);
    const OfLights shorten = 1.0f / length;
    for (OfLights& along : half)
        along *= shorten;
    OfLights half_n = normal.x * half[0] + normal.y * half[1] + normal.z * half[2];
    raise_to(half_n, 0.0f);
    OfLights half_to =
        light.to_light[0] * half[0] + light.to_light[1] * half[1] + light.to_light[2] * half[2];
    raise_to(half_to, 0.0f);
    const OfLights spread = half_n * half_n * (squared - 1.0f) + 1.0f;
    // The density of facets, and Smith's masking over 4 times both cosines, without 1/pi.
    const OfLights facets = squared / (spread * spread);
    OfLights masked = squared + (1.0f - squared) * to_n * to_n;
    take_roots(masked);
    const OfLights masking =
        0.5f / (to_n * std::sqrt(squared + (1.0f - squared) * from_n * from_n) + from_n * masked);
    const OfLights shine = facets * masking;
    const OfLights edge = 0.5f + 2.0f * half_to * half_to * roughness - 1.0f;
    OfLights grazing_to = to_n;
    graze(grazing_to);
    const OfLights matt = (1.0f + edge * grazing_to) * (1.0f + edge * grazing(from_n));
    OfLights aslant = half_to;
    graze(aslant);
    for (int channel = 0; channel < 3; ++channel) {
        const float head_on = surface.specular[channel];
        const OfLights fresnel = head_on + (glm::clamp(50.0f * head_on, 0.0f, 1.0f) - head_on) * aslant;
        reflected[channel] = to_n * (matt * surface.diffuse[channel] + shine * fresnel);
    }
}

/// Of a matt surface with Blinn's highlight.
void reflect_smoothly(const Surface& surface, float shininess, const glm::vec3& normal,
                      const glm::vec3& to_eye, const OfLights& to_n, const Illuminations& light,
                      Reflections& reflected) {
    for (int channel = 0; channel < 3; ++channel)
        reflected[channel] = to_n * surface.diffuse[channel];
    if (surface.specular == glm::vec3(0.0f))
        return;
    for (std::size_t i = 0; i < lights_at_once; ++i) {
        if (!(to_n[i] > 0.0f))
            continue;
        const glm::vec3 to_light{light.to_light[0][i], light.to_light[1][i], light.to_light[2][i]};
        const glm::vec3 halfway = glm::normalize(to_light + to_eye);
        const float highlight = (std::max)(0.0f, glm::dot(normal, halfway));
        for (int channel = 0; channel < 3; ++channel)
            reflected[channel][i] += std::pow(highlight, shininess) * surface.specular[channel];
    }
}

}  // namespace

glm::vec3 shade(const Scene& scene, const LightTable& lights, const Hit& hit, const glm::vec3& ray_direction,
                std::span<const float> lit, float ambient) {
    const Material& material = scene.materials[hit.material];
    const Surface surface = surface_at(scene, material, hit.triangle, hit.u, hit.v);
    const glm::vec3& normal = hit.shading_normal;
    const OfLights none{};
    glm::vec3 sum = ambient * scene.ambient * surface.diffuse + surface.emission;
    for (std::size_t first = 0; first < lit.size(); first += lights_at_once) {
        const std::size_t count = (std::min)(lights_at_once, lit.size() - first);
        OfLights share{};
        std::memcpy(&share, lit.data() + first, count * sizeof(float));
        Illuminations light;
        lights.illuminate(first, hit.position, share, light);
        OfLights to_n =
            normal.x * light.to_light[0] + normal.y * light.to_light[1] + normal.z * light.to_light[2];
        // Of lights that are hidden or behind the surface nothing is used.
        const auto counts = (share != none) & (to_n > none);
        to_n = counts ? to_n : none;
        Reflections reflected;
        if (material.highlight == Highlight::ggx)
            reflect_roughly(surface, material.roughness, normal, -ray_direction, to_n, light, reflected);
        else
            reflect_smoothly(surface, material.shininess, normal, -ray_direction, to_n, light, reflected);
        float terms[3][lights_at_once];
        for (int channel = 0; channel < 3; ++channel) {
            const OfLights arrives = share * reflected[channel] * light.irradiance[channel];
            const OfLights term = counts ? arrives : none;
            std::memcpy(terms[channel], &term, sizeof term);
        }
        for (std::size_t i = 0; i < count; ++i)
            sum += glm::vec3(terms[0][i], terms[1][i], terms[2][i]);
    }
    return sum;
}

glm::vec3 refracted(const Hit& hit, const glm::vec3& direction, float refraction_index) {
    const float ratio = hit.from_inside ? refraction_index : 1.0f / refraction_index;
    const glm::vec3 through = glm::refract(direction, hit.shading_normal, ratio);
    return through != glm::vec3(0.0f) ? through : glm::reflect(direction, hit.shading_normal);
}

}  // namespace demo
