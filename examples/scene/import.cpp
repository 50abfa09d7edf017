// SPDX-License-Identifier: MIT
#include "boxes.hpp"
#include "by_name.hpp"
#include "emitters.hpp"
#include "import_pose.hpp"
#include "isolated.hpp"
#include "light_rig.hpp"
#include "model.hpp"
#include "scene.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace demo {
namespace {

namespace fs = std::filesystem;

/// Scene::radius as a share of the diagonal.
constexpr float radius_share = 0.025f;
/// Embree traces no rays beyond 2^60.
constexpr float farthest_coordinate = 1e18f;

[[noreturn]] void fail(const fs::path& file, const std::string& problem) {
    throw std::runtime_error(file.string() + ": " + problem);
}

std::string in_brackets(const glm::dvec3& v) {
    return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
}

bool is_finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void check_file(const fs::path& file) {
    if (!fs::exists(file)) {
        fail(file, "no such file, and no built-in scene of that name");
    }
    if (fs::is_directory(file)) {
        fail(file, "is a folder, not a scene");
    }
    const std::string extension = extension_of(file);
    const std::array<const char*, 4> known{".obj", ".gltf", ".glb", ".ply"};
    if (std::find(known.begin(), known.end(), extension) == known.end()) {
        fail(file, "unknown format '" + extension + "'; .obj, .gltf, .glb and .ply can be read");
    }
    if (!fs::is_regular_file(file)) {
        fail(file, "is no regular file");
    }
    if (!std::ifstream{file}) {
        fail(file, "cannot be opened");
    }
}

/// Reads in a child process. What a file says to unpack raises the limits, in bounds: see `allow_memory`.
Model read_safely(const fs::path& file, const ImportOptions& options, bool pictures) {
    constexpr std::size_t megabyte = 1 << 20;
    const std::size_t size = fs::file_size(file);
    // Assimp takes OBJ apart into many small pieces.
    const std::size_t factor = extension_of(file) == ".obj" ? 16 : read_factor;
    const ReaderLimits limits{64 * megabyte + factor * size, 2048 * megabyte + unpacked_factor * size,
                              static_cast<unsigned>(10 + size / megabyte)};
    try {
        return read_isolated(
            [&] {
                return read_model(file, {options.time, options.animation, pictures});
            },
            limits);
    } catch (const std::exception& error) {
        fail(file, error.what());
    }
}

/// No area that a ray could hit: two corners in one place, or all three on a line.
bool is_degenerate(glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    const glm::dvec3 ab = glm::dvec3{b} - glm::dvec3{a};
    const glm::dvec3 ac = glm::dvec3{c} - glm::dvec3{a};
    const double longest = (std::max)(glm::dot(ab, ab), glm::dot(ac, ac));
    return !(glm::length(glm::cross(ab, ac)) > 1e-7 * longest);
}

/// Gives every corner of a triangle a vertex of its own, where a mesh has no normals: it is flat.
ModelMesh unshared(ModelMesh mesh) {
    const auto by_corner = [&](auto& values) {
        if (values.empty())
            return;
        auto spread = values;
        spread.clear();
        spread.reserve(mesh.indices.size());
        for (const std::uint32_t index : mesh.indices)
            spread.push_back(values[index]);
        values = std::move(spread);
    };
    by_corner(mesh.positions);
    by_corner(mesh.texture_coordinates[0]);
    by_corner(mesh.texture_coordinates[1]);
    by_corner(mesh.colours);
    for (std::size_t i = 0; i < mesh.indices.size(); ++i)
        mesh.indices[i] = static_cast<std::uint32_t>(i);
    return mesh;
}

/// Collects the meshes in the scene, in floats about its origin.
class Gatherer {
public:
    /// `keeps_all`: also triangles without area.
    Gatherer(const fs::path& file, Scene& scene, const Model& model, bool keeps_all)
        : file_(file), scene_(scene), keeps_all_(keeps_all) {
        for (const ModelMesh& mesh : model.meshes) {
            has_colours_ = has_colours_ || !mesh.colours.empty();
            for (std::size_t set = 0; set < 2; ++set)
                has_coordinates_[set] = has_coordinates_[set] || !mesh.texture_coordinates[set].empty();
        }
    }

    void add(ModelMesh mesh) {
        if (mesh.normals.empty())
            mesh = unshared(std::move(mesh));
        if (scene_.positions.size() + mesh.positions.size() > std::numeric_limits<std::uint32_t>::max())
            fail(file_, "has more than 2^32 vertices");
        const auto first = static_cast<std::uint32_t>(scene_.positions.size());
        const std::size_t first_triangle = scene_.triangles.size();
        add_vertices(mesh);
        for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3)
            add_triangle({{first + mesh.indices[i], first + mesh.indices[i + 1], first + mesh.indices[i + 2]},
                          mesh.material});
        ranges_.push_back({first_triangle, scene_.triangles.size()});
    }

    std::size_t dropped() const { return dropped_; }
    const std::vector<TriangleRange>& ranges() const { return ranges_; }

private:
    void add_vertices(const ModelMesh& mesh) {
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
            const glm::vec3 p{mesh.positions[i] - scene_.origin};
            if (!is_finite(p))
                fail(file_, "vertex " + std::to_string(i) + " of " + mesh.name +
                                " is not finite where its node puts it: " + in_brackets(mesh.positions[i]));
            scene_.positions.push_back(p);
            const glm::vec3 n = mesh.normals.empty() ? glm::vec3{0.0f} : mesh.normals[i];
            const float length = glm::length(n);
            scene_.normals.push_back(length > 0.0f && std::isfinite(length) ? n / length : glm::vec3{0.0f});
            if (has_colours_)
                scene_.colours.push_back(mesh.colours.empty() ? glm::vec4{1.0f}
                                                              : glm::clamp(mesh.colours[i], 0.0f, 1.0f));
            for (std::size_t set = 0; set < 2; ++set)
                if (has_coordinates_[set])
                    scene_.texture_coordinates[set].push_back(mesh.texture_coordinates[set].empty()
                                                                  ? glm::vec2{0.0f}
                                                                  : mesh.texture_coordinates[set][i]);
        }
    }

    void add_triangle(const Triangle& triangle) {
        const glm::vec3 a = scene_.positions[triangle.vertex[0]];
        const glm::vec3 b = scene_.positions[triangle.vertex[1]];
        const glm::vec3 c = scene_.positions[triangle.vertex[2]];
        if (is_degenerate(a, b, c)) {
            if (keeps_all_)
                scene_.triangles.push_back(triangle);
            else
                ++dropped_;
            return;
        }
        const glm::dvec3 ab = glm::dvec3{b} - glm::dvec3{a};
        const glm::vec3 flat{glm::normalize(glm::cross(ab, glm::dvec3{c} - glm::dvec3{a}))};
        for (const std::uint32_t vertex : triangle.vertex) {
            if (scene_.normals[vertex] == glm::vec3{0.0f}) {  // the file's normal is 0, NaN or not there
                scene_.normals[vertex] = flat;
            }
        }
        scene_.triangles.push_back(triangle);
    }

    const fs::path& file_;
    Scene& scene_;
    bool keeps_all_;
    bool has_colours_ = false;
    std::array<bool, 2> has_coordinates_{};
    std::vector<TriangleRange> ranges_;
    std::size_t dropped_ = 0;
};

/// Moves the origin to the middle of a model that lies so far out that floats would not hold its shape.
void choose_origin(const Model& model, Scene& scene) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    glm::dvec3 low{infinity};
    glm::dvec3 high{-infinity};
    for (const ModelMesh& mesh : model.meshes)
        for (const std::uint32_t index : mesh.indices) {
            low = glm::min(low, mesh.positions[index]);
            high = glm::max(high, mesh.positions[index]);
        }
    if (const std::optional<glm::dvec3> middle = far_middle(low, high)) {
        scene.origin = *middle;
        scene.remarks.push_back("the scene lies far from the origin: " + in_brackets(*middle) +
                                " of the file is the origin here");
    }
}

std::vector<TriangleRange> import_triangles(const fs::path& file, Model& model, Scene& scene,
                                            bool keeps_all) {
    Gatherer gatherer{file, scene, model, keeps_all};
    for (ModelMesh& mesh : model.meshes)
        gatherer.add(std::exchange(mesh, {}));
    if (gatherer.dropped() > 0) {
        scene.remarks.push_back(std::to_string(gatherer.dropped()) + " triangles without area left out");
    }
    if (scene.triangles.empty()) {
        fail(file, "has no triangles");
    }
    const Bounds bounds = bounds_of(scene);
    const glm::vec3 farthest = glm::max(glm::abs(bounds.low), glm::abs(bounds.high));
    if (!((std::max)({farthest.x, farthest.y, farthest.z}) < farthest_coordinate))
        fail(file, "reaches from " + in_brackets(bounds.low) + " to " + in_brackets(bounds.high) +
                       ", farther than rays can be traced");
    return gatherer.ranges();
}

/// Takes the pictures; those that cannot be drawn are left out with a note, and what they would have lit is
/// dark.
void import_textures(Model& model, Scene& scene) {
    std::vector<std::int32_t> numbers(model.images.size(), -1);
    const auto wanted = [&](std::size_t image) {
        return std::ranges::any_of(scene.materials, [&](const Material& material) {
            const auto number = static_cast<std::int32_t>(image);
            return material.base_map.texture == number || material.emission_map.texture == number ||
                   material.opacity_map.texture == number;
        });
    };
    for (std::size_t i = 0; i < model.images.size(); ++i) {
        if (!wanted(i))
            continue;
        ModelImage& image = model.images[i];
        if (image.problem.empty() && image.texture.width > 0) {
            numbers[i] = static_cast<std::int32_t>(scene.textures.size());
            scene.textures.push_back(std::exchange(image.texture, {}));
        } else {
            scene.remarks.push_back("texture '" + image.name + "' is left out: it " +
                                    (image.problem.empty() ? "is empty" : image.problem));
        }
    }
    const auto renumber = [&](TextureMap& map) {
        if (map.texture >= 0)
            map.texture = numbers[static_cast<std::size_t>(map.texture)];
    };
    for (Material& material : scene.materials) {
        const bool has_emission_map = material.emission_map.texture >= 0;
        renumber(material.base_map);
        renumber(material.opacity_map);
        renumber(material.emission_map);
        if (has_emission_map && material.emission_map.texture < 0 && !material.is_unlit)
            material.emission = glm::vec3{0.0f};
        const bool may_have_holes =
            material.opacity_map.texture >= 0 || material.opacity < material.alpha_cutoff ||
            (material.base_map.texture >= 0 &&
             scene.textures[static_cast<std::size_t>(material.base_map.texture)].has_alpha) ||
            std::ranges::any_of(scene.colours, [](const glm::vec4& colour) { return colour.a < 1.0f; });
        if (material.alpha_mode == AlphaMode::mask && !may_have_holes)
            material.alpha_mode = AlphaMode::opaque;
    }
}

std::string lamp_name(const ModelLight& light) {
    return light.name.empty() ? "a lamp" : "lamp '" + light.name + "'";
}

/// The light as a Scene has it; nothing, with a remark, for one that cannot shine.
std::optional<SceneLight> converted(const ModelLight& source, Scene& scene) {
    const glm::vec3 position{source.position - scene.origin};
    const double length = glm::length(source.axis);
    if (!is_finite(position)) {
        scene.remarks.push_back(lamp_name(source) + " is not at a finite place: left out");
        return std::nullopt;
    }
    if (source.kind != ModelLight::Kind::point && !(length > 0.0 && std::isfinite(length))) {
        scene.remarks.push_back(lamp_name(source) +
                                " shines nowhere, since its node has no direction: left out");
        return std::nullopt;
    }
    SceneLight light;
    light.name = source.name;
    light.intensity = source.intensity;
    const glm::vec3 axis{source.axis / (length > 0.0 ? length : 1.0)};
    switch (source.kind) {
    case ModelLight::Kind::point:
        light.shape = lightmesh::PointLight{position, source.range};
        break;
    case ModelLight::Kind::directional:
        light.shape = lightmesh::DirectionalLight{axis};
        break;
    case ModelLight::Kind::spot:
        light.shape = lightmesh::SpotLight{position, axis, source.outer_cone, source.range};
        light.inner_cone = source.inner_cone;
        break;
    }
    return light;
}

/// The lights that the file has as such; returns how many of them are switched off.
std::size_t import_lamps(const Model& model, Scene& scene) {
    std::size_t switched_off = 0;
    for (const ModelLight& source : model.lights) {
        if (source.intensity == glm::vec3{0.0f})
            ++switched_off;
        else if (const auto light = converted(source, scene))
            scene.lights.push_back(*light);
    }
    return switched_off;
}

/// Lamps of surfaces that shine, and a rig where there is no light at all.
void complete_lights(const Model& model, std::size_t switched_off, const std::vector<TriangleRange>& meshes,
                     const ImportOptions& options, Scene& scene) {
    if (switched_off > 0)
        scene.remarks.push_back(
            (switched_off == model.lights.size() ? "all " : "") + std::to_string(switched_off) +
            (switched_off == model.lights.size() ? "" : " of " + std::to_string(model.lights.size())) +
            " lights of the file are switched off");
    const std::size_t before = scene.lights.size();
    const std::size_t shining = options.emitters ? add_emitter_lights(scene, meshes) : 0;
    open_bulbs(scene, meshes);
    if (shining > 0)
        scene.remarks.push_back(std::to_string(shining) + " surfaces that shine light the scene, as " +
                                std::to_string(scene.lights.size() - before) +
                                " lamps of their power (--emitters off: as none)");
    scene.has_own_lights = !scene.lights.empty() || switched_off > 0;
    if (!scene.has_own_lights) {
        add_light_rig(scene);
        scene.remarks.push_back("the file has no lights: " + std::to_string(scene.lights.size()) +
                                " point lights added around and above");
    }
}

Camera converted(const ModelCamera& source, const Scene& scene, glm::vec3 centre) {
    Camera camera;
    camera.eye = glm::vec3{source.eye - scene.origin};
    const glm::vec3 ahead{glm::normalize(source.ahead)};
    camera.up = glm::vec3{glm::normalize(source.up)};
    const float distance = glm::dot(centre - camera.eye, ahead);
    camera.target = camera.eye + (distance > 0.0f ? distance : 1.0f) * ahead;
    if (source.vertical_field_of_view > 0.0f)
        camera.vertical_field_of_view = source.vertical_field_of_view;
    camera.orthographic_height = source.orthographic_height;
    return camera;
}

/// Throws for a camera that sees nothing.
void check(const ModelCamera& camera, const fs::path& file) {
    const auto problem = [&](const std::string& what) {
        fail(file, "camera '" + camera.name + "' " + what);
    };
    if (!(glm::length(camera.eye) < static_cast<double>(farthest_coordinate)))
        problem("is too far away to see anything: " + in_brackets(camera.eye));
    if (!(glm::length(glm::cross(camera.ahead, camera.up)) > 0.0) ||
        !std::isfinite(glm::length(camera.ahead)))
        problem("looks nowhere");
    const float angle = camera.vertical_field_of_view;
    if (camera.orthographic_height == 0.0f && !(angle > 0.0f && angle < 3.14159f))
        problem("has the vertical angle " + std::to_string(angle) + " in radians");
    if (!(camera.orthographic_height >= 0.0f) || !std::isfinite(camera.orthographic_height))
        problem("shows a height of " + std::to_string(camera.orthographic_height));
}

/// The camera that the user asks for; otherwise the first.
std::size_t chosen_camera(const fs::path& file, const Scene& scene, const std::string& wanted) {
    try {
        return number_by_name(scene.cameras, wanted, "camera");
    } catch (const std::runtime_error& error) {
        fail(file, error.what());
    }
}

void import_camera(const fs::path& file, const Model& model, const ImportOptions& options,
                   const glm::vec3& centre, Scene& scene) {
    for (const ModelCamera& camera : model.cameras)
        scene.cameras.push_back(camera.name);
    const std::size_t chosen = chosen_camera(file, scene, options.camera);
    if (model.cameras.empty()) {
        scene.has_own_camera = false;
        const bool z_is_up = options.z_is_up && extension_of(file) != ".gltf" && extension_of(file) != ".glb";
        scene.camera = view_of_all(scene, z_is_up ? glm::vec3{0, 0, 1} : glm::vec3{0, 1, 0});
        scene.remarks.emplace_back(std::string("the file has no camera: seen from the front, with ") +
                                   (z_is_up ? "+z" : "+y") + " up");
        return;
    }
    check(model.cameras[chosen], file);
    scene.camera = converted(model.cameras[chosen], scene, centre);
    if (model.cameras.size() > 1 && options.camera.empty())
        scene.remarks.push_back("the file has " + std::to_string(model.cameras.size()) +
                                " cameras: the view is '" + model.cameras[chosen].name +
                                "'; --camera takes another by its name or number");
}

/// `film`: null for a still.
Scene import_any(const fs::path& file, const ImportOptions& options, FilmOfFile* film) {
    const bool is_later = film != nullptr && film->length > 0.0;
    check_file(file);
    Model model = read_safely(file, options, !is_later);
    Scene scene;
    scene.name = file.stem().string();
    scene.is_file = true;
    scene.mesh_count = model.meshes.size();
    scene.remarks = std::move(model.notes);
    scene.materials = std::move(model.materials);
    if (is_later)
        scene.origin = film->origin;
    else
        choose_origin(model, scene);
    const std::vector<TriangleRange> meshes = import_triangles(file, model, scene, film != nullptr);
    if (!is_later)
        import_textures(model, scene);
    const glm::vec3 centre = is_later ? film->centre : centre_of(bounds_of(scene));
    import_camera(file, model, options, centre, scene);
    const std::size_t switched_off = import_lamps(model, scene);
    if (is_later)
        return scene;
    if (film != nullptr)
        *film = {scene.origin, centre, scene.lights.size(), model.animation_length};
    complete_lights(model, switched_off, meshes, options, scene);
    scene.background = {0.05f, 0.06f, 0.08f};
    scene.ambient = glm::vec3{0.06f};
    scene.radius = radius_share * diagonal_of(bounds_of(scene));
    return scene;
}

}  // namespace

Scene import_scene(const fs::path& file, const ImportOptions& options) {
    return import_any(file, options, nullptr);
}

Scene import_pose(const fs::path& file, const ImportOptions& options, FilmOfFile& film) {
    return import_any(file, options, &film);
}

}  // namespace demo
