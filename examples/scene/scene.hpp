// SPDX-License-Identifier: MIT
#pragma once

#include "image/texture.hpp"
#include "scene/instances.hpp"

#include <lightmesh/lights.hpp>

#include <glm/mat3x2.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace demo {

/// A texture as a material uses it.
struct TextureMap {
    std::int32_t texture = -1;      ///< number in Scene::textures; -1: none
    std::uint32_t coordinates = 0;  ///< which of Scene::texture_coordinates, 0 or 1
    Wrap wrap_u = Wrap::repeat;
    Wrap wrap_v = Wrap::repeat;
    glm::mat3x2 transform{1, 0, 0, 1, 0, 0};  ///< of (u, v, 1)
};

/// The nature of a surface where its base colour is not opaque.
enum class AlphaMode : std::uint32_t {
    opaque,  ///< alpha does not count
    mask,    ///< there is no surface where alpha is below the cutoff
    blend    ///< light passes by 1 - alpha
};

/// The part of a shadow ray that a surface stops.
enum class ShadowBy : std::uint32_t {
    surface,  ///< all, also if it is of glass
    opacity,  ///< what it does not let through
    nothing
};

/// The lobe of a surface's highlights.
enum class Highlight : std::uint32_t {
    blinn_phong,  ///< `specular` by the `shininess`-th power
    ggx           ///< of a rough surface: `specular` is its reflectance head-on
};

/// The way that a surface sends light on: Lambert and a highlight for Omega of equation (1), and Whitted's
/// k_s and k_t.
struct Material {
    std::string name;
    glm::vec3 diffuse{0.8f};
    glm::vec3 specular{0.0f};
    float shininess = 32.0f;
    float k_s = 0.0f;  ///< share of the mirrored ray, 0..1
    float k_t = 0.0f;  ///< share of the refracted ray, 0..1
    float refraction_index = 1.5f;
    glm::vec3 tint{1.0f};  ///< of what is seen through the surface; textures and vertices multiply it
    glm::vec3 emission{0.0f};

    float metallic = 0.0f;  ///< share in which `specular` has the colour of the texture
    float opacity = 1.0f;   ///< alpha, by which that of texture and vertices is multiplied
    AlphaMode alpha_mode = AlphaMode::opaque;
    float alpha_cutoff = 0.5f;
    TextureMap base_map{};      ///< multiplies `diffuse` and `opacity`
    TextureMap opacity_map{};   ///< its red channel multiplies `opacity`
    TextureMap emission_map{};  ///< multiplies `emission`
    bool is_unlit = false;      ///< `emission` is a colour as drawn, and no light
    ShadowBy shadow = ShadowBy::surface;
    Highlight highlight = Highlight::blinn_phong;
    float roughness = 0.5f;  ///< of `Highlight::ggx`, which also dims `diffuse` at grazing angles: its square
                             ///< is the width of the lobe
};

/// The course of a light's strength away from its middle.
enum class FallOff : std::uint32_t {
    points,  ///< as KHR_lights_punctual recommends: spots by the squared share of the way to their edge
    lamps    ///< spots are discs with a smooth edge; each piece of a rectangle sends light of its own
};

/// A light with what the light mesh does not need to know: its strength.
struct SceneLight {
    lightmesh::Light shape;
    glm::vec3 intensity{1.0f};  ///< radiance scale: at distance d of a point or spot light, intensity / d^2;
                                ///< directional: as is
    float inner_cone =
        0.0f;  ///< spot lights: half angle in radians up to which the light is at full strength
    /// Point lights: the normal of the patch of a surface that shines, with a strength that falls off by the
    /// cosine to it on both sides; 0: in all directions alike.
    glm::vec3 facing{0.0f};
    std::string name{};  ///< as the file has it; empty: none
    FallOff fall_off = FallOff::points;
};

struct Camera {
    glm::vec3 eye{0.0f, -5.0f, 1.0f};
    glm::vec3 target{0.0f};
    glm::vec3 up{0.0f, 0.0f, 1.0f};
    float vertical_field_of_view = 0.7853982f;  ///< radians
    float orthographic_height = 0.0f;           ///< of the picture in world units; 0: a perspective view
    /// Left, right, lower and upper edge of the picture beside the middle of the view, for shifted lenses and
    /// for parts of pictures: world units, in a perspective view at a distance of 1. All 0: by the field of
    /// view, or the height, and the picture's shape.
    glm::vec4 edges{0.0f};
    /// Distances along the view that are seen, world units.
    float z_near = 0.0f;
    float z_far = std::numeric_limits<float>::infinity();
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
    std::vector<glm::vec4> colours;  ///< per vertex, linear, with alpha; empty: white
    std::array<std::vector<glm::vec2>, 2> texture_coordinates;  ///< per vertex; empty: none
    std::vector<Triangle> triangles;
    /// What chance knows the triangles by that let some of the light through; empty: their own numbers.
    std::vector<std::uint32_t> surfaces;
    /// Triangles that only instances show: after all others, part by part, and so are their vertices.
    std::vector<MeshPart> parts;
    std::vector<Instance> instances;
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<SceneLight> lights;
    Camera camera;
    glm::dvec3 origin{0.0};  ///< where the file has what lies at 0 here
    glm::vec3 ambient{0.05f};
    glm::vec3 background{0.0f};
    float exposure = 1.0f;  ///< factor of all values of a picture
    float radius = 1.0f;    ///< a good r for a light mesh here
    float quality = 4.0f;   ///< and a good q
    bool is_file = false;   ///< read from a file, not built in
    bool has_own_camera = true;
    bool has_own_lights = true;
    std::vector<std::string> cameras;  ///< names of all cameras of the file
    std::size_t mesh_count = 0;        ///< as the file counts
    std::vector<std::string> remarks;  ///< what the user should be told: a light rig added, textures left out
};

/// A user's wishes from a file.
struct ImportOptions {
    std::string camera;            ///< by its name, or its number from 0; empty: the first one
    bool emitters = true;          ///< whether surfaces that shine become lights
    bool z_is_up = false;          ///< of OBJ and PLY, which do not say; else +y
    std::optional<double> time{};  ///< of an animation of glTF, in seconds; empty: the file's own pose
    std::string animation{};       ///< by its name, or its number from 0; empty: the first one
};

/// The built-in scenes, always the same to the last bit: `spheres` 2,028 triangles, `park` 145,970 triangles,
/// `rooms` an interior of 36 rooms with thin walls, `street` 212 m of houses and lamps at true scale.
Scene make_spheres();
Scene make_park();
Scene make_rooms();
Scene make_street();

/// The lights as a light mesh takes them.
std::vector<lightmesh::Light> shapes_of_lights(const Scene& scene);

/// The triangles' vertices, three a triangle. Throws std::invalid_argument for a scene with instances.
std::vector<std::uint32_t> indices_of(const Scene& scene);

/// Names of the built-in scenes, as `load_scene` takes them.
const std::vector<std::string>& built_in_scenes();

/// Reads OBJ, glTF/GLB or PLY. Throws std::runtime_error that names the file and what is wrong with it: not
/// there, no triangles, NaN vertices, an unknown format. A file without lights or camera gets a rig and a
/// view, and a remark.
Scene import_scene(const std::filesystem::path& file, const ImportOptions& options = {});

/// A built-in scene by its name, or a file.
Scene load_scene(const std::string& name_or_file, const ImportOptions& options = {});

/// Replaces the lights by `count` point lights spread evenly over the scene, of the same total strength;
/// deterministic.
void spread_lights(Scene& scene, std::size_t count);

}  // namespace demo
