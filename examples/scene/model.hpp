// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace demo {

/// A scene as readers of files find it, in world space and in doubles, before it is checked and becomes a
/// Scene.

struct ModelMesh {
    std::string name;  ///< as errors call it: by node and mesh
    std::vector<glm::dvec3> positions;
    std::vector<glm::vec3> normals;  ///< empty: flat
    std::array<std::vector<glm::vec2>, 2> texture_coordinates;
    std::vector<glm::vec4> colours;
    std::vector<std::uint32_t> indices;  ///< three a triangle
    std::uint32_t material = 0;
};

struct ModelLight {
    enum class Kind : std::uint32_t { point, directional, spot };

    std::string name;
    Kind kind = Kind::point;
    glm::dvec3 position{0.0};
    glm::dvec3 axis{0.0, 0.0, -1.0};  ///< from the light outwards; any length
    glm::vec3 intensity{1.0f};
    float range = std::numeric_limits<float>::infinity();
    float inner_cone = 0.0f;
    float outer_cone = 0.7853982f;
};

struct ModelCamera {
    std::string name;
    glm::dvec3 eye{0.0};
    glm::dvec3 ahead{0.0, 0.0, -1.0};
    glm::dvec3 up{0.0, 1.0, 0.0};
    float vertical_field_of_view = 0.0f;  ///< radians; 0: orthographic
    float orthographic_height = 0.0f;
};

/// A picture of the file, in one of three states.
struct ModelImage {
    std::string name;
    std::vector<std::uint8_t> encoded;  ///< as the file has it, until it is decoded
    Texture texture;                    ///< decoded; of width 0 until then
    std::string problem;                ///< why there is no picture
};

struct Model {
    std::vector<ModelMesh> meshes;
    std::vector<Material> materials;
    std::vector<ModelImage> images;  ///< those that no material has are empty
    std::vector<ModelLight> lights;
    std::vector<ModelCamera> cameras;
    std::vector<std::string> notes;
    double animation_length = 0.0;  ///< seconds, if a time was asked for; 0: the file has no animation
};

/// The wishes that a reader is asked for.
struct ReadOptions {
    std::optional<double> time;  ///< of an animation, in seconds; empty: the file's own pose
    std::string animation;       ///< by its name, or its number from 0; empty: the first one
    bool pictures = true;        ///< whether those of textures are read and decoded
};

/// Readers throw std::exception with what is wrong, without the file's name.
Model read_gltf(const std::filesystem::path& file, const ReadOptions& options = {});
Model read_obj(const std::filesystem::path& file);
Model read_ply(const std::filesystem::path& file);

/// In small letters, with its dot.
std::string extension_of(const std::filesystem::path& file);

/// The origin to be of a model between these corners if it lies so far from its own that floats would
/// hold no detail: its middle, in whole units. Empty: it stays where it is.
std::optional<glm::dvec3> far_middle(const glm::dvec3& low, const glm::dvec3& high);

/// Reads a file by its extension, and decodes its pictures.
Model read_model(const std::filesystem::path& file, const ReadOptions& options = {});

}  // namespace demo
