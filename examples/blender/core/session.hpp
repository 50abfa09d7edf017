// SPDX-License-Identifier: MIT
#pragma once

#include "blender/core/grouped_visibility.hpp"
#include "blender/core/light_mesh_core.h"
#include "blender/core/triangle_change.hpp"
#include "render/embree_scene.hpp"
#include "render/renderer.hpp"
#include "scene/scene.hpp"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace demo {

/// A mesh as it is told: a vertex for each place, smoothing and texture coordinate that differ.
struct ToldMesh {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<glm::vec2> uvs;       ///< empty: none
    std::vector<Triangle> triangles;  ///< their material is a slot of the object's
    std::uint32_t slot_count = 0;
    bool is_near_origin = true;  ///< else its coordinates have fewer digits than its size wants
};

/// A mesh in its place.
struct PlacedMesh {
    std::uint64_t hash;
    std::array<double, 12> matrix;  ///< row-major, 3 rows of 4
    std::vector<std::int32_t> materials;

    bool operator==(const PlacedMesh&) const = default;
};

/// An object's part of the scene, with what its key is made of.
struct PlacedPiece {
    Piece piece;                          ///< without its key
    std::uint64_t place;                  ///< a hash of its mesh and where it lies
    std::vector<std::int32_t> materials;  ///< of the slots that the mesh has
};

/// The work of the functions of light_mesh_core.h, with exceptions for errors.
class Session {
public:
    explicit Session(std::size_t memory_budget) : memory_budget_(memory_budget) {}
    ~Session() { stop(); }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    void begin();
    /// -1 if there is none.
    std::int32_t find_image(std::uint64_t key);
    std::int32_t add_image(std::uint64_t key, int width, int height, const std::uint8_t* rgba,
                           std::int32_t flags);
    std::int32_t add_material(const LmMaterial& material);
    /// -1 if there is none.
    std::int32_t find_mesh(std::uint64_t hash);
    std::int32_t add_mesh(std::uint64_t hash, const LmMesh& mesh);
    void add_object(std::int32_t mesh, const double* matrix, std::span<const std::int32_t> materials);
    void add_light(const LmLight& light);
    void commit();

    void render(const LmView& view);
    /// Rethrows what the worker threw.
    LmState poll(std::chrono::duration<double> patience, float& progress);
    void read(std::span<float> rgba);
    /// `visible` and `colours` may be empty.
    void bake(const LmPoints& points, std::span<float> visible, std::span<float> colours);
    void cancel() { cancel_ = true; }
    std::size_t light_count() const { return scene_.lights.size(); }
    LmStatistics statistics() const;

private:
    struct Image {
        std::uint64_t key;
        bool clamps;  ///< whether it does not repeat
    };
    struct ToldImage {
        Image image;
        std::optional<Texture> texture;  ///< nullopt: the scene has it
        std::size_t number = 0;          ///< there, of its textures
    };

    /// The parts of a frame between `begin` and `commit`.
    struct Told {
        std::vector<ToldImage> images;
        std::vector<Material> materials;
        std::vector<std::uint64_t> meshes;
        std::vector<PlacedMesh> objects;
        std::vector<SceneLight> lights;
        std::map<std::string, LightGroup> groups;
    };

    void stop();
    const Texture& texture_of(const ToldImage& image) const;
    /// Those of the scene are taken from it.
    std::vector<Texture> take_textures(Told& told);
    /// Of the scene, and of what was told.
    Passing find_passing() const;
    /// Objects that have triangles of their own, and those that share them.
    struct Placing {
        std::vector<const PlacedMesh*> copies;
        std::vector<std::vector<const PlacedMesh*>> parts;  ///< with the same mesh and materials
    };

    Placing sort_objects(std::span<const PlacedMesh> objects) const;
    /// Whether what was told has the triangles of the scene.
    bool has_same_triangles(const Passing& passing) const;
    /// Of what was told, all but its lights and its looks.
    void assemble(Scene& scene, std::vector<PlacedPiece>& pieces) const;
    void place(Scene& scene, const PlacedMesh& object, bool with_uvs) const;
    void add_copy(Scene& scene, std::vector<PlacedPiece>& pieces, const PlacedMesh& object,
                  bool with_uvs) const;
    /// After all copies.
    void add_part(Scene& scene, std::vector<PlacedPiece>& pieces,
                  const std::vector<const PlacedMesh*>& objects, bool with_uvs) const;
    /// Makes what was told the session's scene.
    SceneChange replace_scene();
    void run(const RenderOptions& options);
    void put(const TilePixels& tile);

    std::size_t memory_budget_;
    std::map<std::uint64_t, std::shared_ptr<const ToldMesh>> meshes_;
    Told told_;

    Scene scene_;                // that the next five are of
    std::vector<Image> images_;  // the textures
    std::vector<PlacedMesh> objects_;
    std::vector<PlacedPiece> pieces_;
    std::unique_ptr<EmbreeScene> embree_;
    std::unique_ptr<GroupedVisibility> visibility_;
    SceneChange last_change_;

    std::thread worker_;
    std::atomic<bool> cancel_ = false;
    std::atomic<float> progress_ = 0.0f;
    mutable std::mutex state_mutex_;  // of the next three
    std::condition_variable ended_;
    LmState state_ = LM_FINISHED;
    std::exception_ptr failure_;
    RenderStatistics rendered_;
    std::mutex pixels_mutex_;        // of the next three
    std::vector<glm::vec4> pixels_;  // rows from the bottom up
    int width_ = 0;
    int height_ = 0;
};

inline glm::vec3 vector(const float (&values)[3]) {
    return {values[0], values[1], values[2]};
}

/// A mesh with shared vertices. Throws std::invalid_argument and std::out_of_range that name the mesh.
ToldMesh told_mesh(const LmMesh& mesh);

/// Throws std::invalid_argument that names the light.
SceneLight told_light(const LmLight& light);

/// What the light's shadow is found by, without its lights. Lamps without a size throw hard shadows.
LightGroup told_group(const LmLight& light, std::size_t memory_budget);

}  // namespace demo
