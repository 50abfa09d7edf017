// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>

#include <glm/vec3.hpp>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace demo {

/// What a surface does with light: Lambert and Blinn-Phong for Omega of equation (1), and Whitted's k_s and
/// k_t.
struct Material {
    std::string name;
    glm::vec3 diffuse{0.8f};
    glm::vec3 specular{0.0f};
    float shininess = 32.0f;
    float k_s = 0.0f;  ///< share of the mirrored ray, 0..1
    float k_t = 0.0f;  ///< share of the refracted ray, 0..1
    float refraction_index = 1.5f;
    glm::vec3 emission{0.0f};
};

/// A light with what the light mesh does not need to know: its strength.
struct SceneLight {
    lightmesh::Light shape;
    glm::vec3 intensity{1.0f};  ///< radiance scale: at distance d of a point or spot light, intensity / d^2;
                                ///< directional: as is
    float inner_cone =
        0.0f;  ///< spot lights: half angle in radians up to which the light is at full strength
};

struct Camera {
    glm::vec3 eye{0.0f, -5.0f, 1.0f};
    glm::vec3 target{0.0f};
    glm::vec3 up{0.0f, 0.0f, 1.0f};
    float vertical_field_of_view = 0.7853982f;  ///< radians
};

struct Triangle {
    std::uint32_t vertex[3];
    std::uint32_t material;
};

/// Triangles, lights and a view; everything in world units.
struct Scene {
    std::string name;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;  ///< per vertex, for shading only; empty: flat
    std::vector<Triangle> triangles;
    std::vector<Material> materials;
    std::vector<SceneLight> lights;
    Camera camera;
    glm::vec3 ambient{0.05f};
    glm::vec3 background{0.0f};
    float radius = 1.0f;               ///< a good r for a light mesh here
    float quality = 4.0f;              ///< and a good q
    std::vector<std::string> remarks;  ///< what the user should be told: a light rig added, textures left out
};

/// The built-in scenes, always the same to the last bit: `spheres` 2,028 triangles, `park` 145,970 triangles,
/// `rooms` an interior of 36 rooms with thin walls.
Scene make_spheres();
Scene make_park();
Scene make_rooms();

/// The lights as a light mesh takes them.
std::vector<lightmesh::Light> shapes_of_lights(const Scene& scene);

/// The triangles' vertices, three a triangle.
std::vector<std::uint32_t> indices_of(const Scene& scene);

/// Names of the built-in scenes, as `load_scene` takes them.
const std::vector<std::string>& built_in_scenes();

/// Reads OBJ, glTF/GLB or PLY. Throws std::runtime_error that names the file and what is wrong with it: not
/// there, no triangles, NaN vertices, an unknown format. A file without lights or camera gets a rig and a
/// view, and a remark.
Scene import_scene(const std::filesystem::path& file);

/// A built-in scene by its name, or a file.
Scene load_scene(const std::string& name_or_file);

/// Replaces the lights by `count` point lights spread evenly over the scene, of the same total strength;
/// deterministic.
void spread_lights(Scene& scene, std::size_t count);

}  // namespace demo
