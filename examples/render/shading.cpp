// SPDX-License-Identifier: MIT
#include "render/shading.hpp"

#include "render/illumination.hpp"
#include "scene/surface.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace demo {

glm::vec3 shade(const Scene& scene, const Hit& hit, const glm::vec3& ray_direction,
                std::span<const float> lit) {
    const Material& material = scene.materials[hit.material];
    const Surface surface = surface_at(scene, material, hit.triangle, hit.u, hit.v);
    glm::vec3 sum = scene.ambient * surface.diffuse + surface.emission;
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        if (lit[l] == 0.0f)
            continue;
        const Illumination light = illuminate(scene.lights[l], hit.position);
        const float lambert = glm::dot(hit.shading_normal, light.to_light);
        if (lambert <= 0.0f)
            continue;
        glm::vec3 reflected = lambert * surface.diffuse;
        if (surface.specular != glm::vec3(0.0f)) {
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
