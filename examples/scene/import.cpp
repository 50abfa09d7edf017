// SPDX-License-Identifier: MIT
#include "import_lights.hpp"
#include "import_materials.hpp"
#include "light_rig.hpp"
#include "scene.hpp"

#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <string>
#include <variant>

namespace demo {
namespace {

namespace fs = std::filesystem;

/// Scene::radius as a share of the diagonal.
constexpr float radius_share = 0.025f;

[[noreturn]] void fail(const fs::path& file, const std::string& problem) {
    throw std::runtime_error(file.string() + ": " + problem);
}

std::string in_brackets(glm::vec3 v) {
    return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
}

bool is_finite(glm::vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// What Assimp only writes to its log. The log is one for the whole process, so one import runs at a time.
class LogCapture {
public:
    LogCapture() {
        Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0);
        Assimp::DefaultLogger::get()->attachStream(new Stream{lines_},
                                                   Assimp::Logger::Warn | Assimp::Logger::Err);
    }
    ~LogCapture() { Assimp::DefaultLogger::kill(); }  // deletes the stream, too
    LogCapture(const LogCapture&) = delete;
    LogCapture& operator=(const LogCapture&) = delete;

    /// The first line that contains `text`, without its prefix; empty if there is none.
    std::string find(const std::string& text) const {
        for (const std::string& line : lines_) {
            const std::size_t at = line.find(text);
            if (at != std::string::npos) {
                const std::size_t start = line.find(": ") + 2;
                return line.substr(start, line.find_last_not_of('\n') + 1 - start);
            }
        }
        return {};
    }

private:
    struct Stream : Assimp::LogStream {
        explicit Stream(std::vector<std::string>& to) : lines(to) {}
        void write(const char* message) override { lines.emplace_back(message); }
        std::vector<std::string>& lines;
    };

    std::vector<std::string> lines_;
    std::lock_guard<std::mutex> lock_{mutex()};

    static std::mutex& mutex() {
        static std::mutex the_mutex;
        return the_mutex;
    }
};

void check_file(const fs::path& file) {
    if (!fs::exists(file)) {
        fail(file, "no such file, and no built-in scene of that name");
    }
    if (fs::is_directory(file)) {
        fail(file, "is a folder, not a scene");
    }
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const std::array<const char*, 4> known{".obj", ".gltf", ".glb", ".ply"};
    if (std::find(known.begin(), known.end(), extension) == known.end()) {
        fail(file, "unknown format '" + extension + "'; .obj, .gltf, .glb and .ply can be read");
    }
    if (!std::ifstream{file}) {
        fail(file, "cannot be opened");
    }
}

/// Looks at the data as it came from the file. Assimp's later steps trust it: Debian's build ends the process
/// where an assertion fails.
void check_mesh(const fs::path& file, const aiMesh& mesh, unsigned number) {
    const std::string where = "mesh " + std::to_string(number) + " '" + mesh.mName.C_Str() + "'";
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
        const glm::vec3 p = to_glm(mesh.mVertices[i]);
        if (!is_finite(p)) {
            fail(file, "vertex " + std::to_string(i) + " of " + where + " is not finite: " + in_brackets(p));
        }
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
        const aiFace& face = mesh.mFaces[i];
        if (face.mNumIndices == 0) {
            fail(file,
                 "face " + std::to_string(i) + " of " + where + " has no vertices; the file may be cut off");
        }
        for (unsigned k = 0; k < face.mNumIndices; ++k) {
            if (face.mIndices[k] >= mesh.mNumVertices) {
                fail(file, "face " + std::to_string(i) + " of " + where + " refers to vertex " +
                               std::to_string(face.mIndices[k]) + ", but there are only " +
                               std::to_string(mesh.mNumVertices));
            }
        }
    }
}

/// Reads the file, checks it, and has Assimp make triangles with normals of it.
const aiScene& read(Assimp::Importer& importer, const fs::path& file, const LogCapture& log) {
    const aiScene* source = importer.ReadFile(file.string(), 0);
    if (!source) {
        const std::string problem = importer.GetErrorString();
        fail(file,
             problem.find("No suitable reader") == 0 ? "is damaged, or not what its name says" : problem);
    }
    if (const std::string line = log.find("out-of-range indices"); !line.empty()) {
        fail(file, "faces refer to vertices that are not there");
    }
    unsigned faces = 0;
    for (unsigned i = 0; i < source->mNumMeshes; ++i) {
        check_mesh(file, *source->mMeshes[i], i);
        faces += source->mMeshes[i]->mNumFaces;
    }
    if (faces == 0) {
        fail(file, "has no triangles");
    }
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, 40.0f);
    constexpr unsigned steps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_GenSmoothNormals;
    source = importer.ApplyPostProcessing(steps);
    if (!source || !source->mRootNode) {
        fail(file, "has no triangles");
    }
    return *source;
}

/// No area that a ray could hit: two corners in one place, or all three on a line.
bool is_degenerate(glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    const glm::dvec3 ab = glm::dvec3{b} - glm::dvec3{a};
    const glm::dvec3 ac = glm::dvec3{c} - glm::dvec3{a};
    const double longest = (std::max)(glm::dot(ab, ab), glm::dot(ac, ac));
    return !(glm::length(glm::cross(ab, ac)) > 1e-7 * longest);
}

/// Collects the meshes of all nodes in world space.
class Gatherer {
public:
    Gatherer(const fs::path& file, Scene& scene) : file_(file), scene_(scene) {}

    void add(const aiMesh& mesh, const aiMatrix4x4& to_world) {
        if (scene_.positions.size() + mesh.mNumVertices > std::numeric_limits<std::uint32_t>::max()) {
            fail(file_, "has more than 2^32 vertices");
        }
        const auto first = static_cast<std::uint32_t>(scene_.positions.size());
        add_vertices(mesh, to_world);
        const bool mirrored = aiMatrix3x3{to_world}.Determinant() < 0.0f;
        for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
            const unsigned* corner = mesh.mFaces[i].mIndices;
            add_triangle(
                {{first + corner[0], first + corner[mirrored ? 2 : 1], first + corner[mirrored ? 1 : 2]},
                 mesh.mMaterialIndex});
        }
    }

    std::size_t dropped() const { return dropped_; }

private:
    void add_vertices(const aiMesh& mesh, const aiMatrix4x4& to_world) {
        aiMatrix3x3 for_normals{to_world};
        for_normals.Inverse().Transpose();
        for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
            const glm::vec3 p = transform_point(to_world, to_glm(mesh.mVertices[i]));
            if (!is_finite(p)) {
                fail(file_, "vertex " + std::to_string(i) + " of mesh '" + mesh.mName.C_Str() +
                                "' is not finite where its node puts it: " + in_brackets(p));
            }
            scene_.positions.push_back(p);
            const glm::vec3 n = mesh.HasNormals() ? to_glm(for_normals * mesh.mNormals[i]) : glm::vec3{0.0f};
            const float length = glm::length(n);
            scene_.normals.push_back(length > 0.0f && std::isfinite(length) ? n / length : glm::vec3{0.0f});
        }
    }

    void add_triangle(const Triangle& triangle) {
        const glm::vec3 a = scene_.positions[triangle.vertex[0]];
        const glm::vec3 b = scene_.positions[triangle.vertex[1]];
        const glm::vec3 c = scene_.positions[triangle.vertex[2]];
        if (is_degenerate(a, b, c)) {
            ++dropped_;
            return;
        }
        const glm::dvec3 ab = glm::dvec3{b} - glm::dvec3{a};
        const glm::vec3 flat{glm::normalize(glm::cross(ab, glm::dvec3{c} - glm::dvec3{a}))};
        for (const std::uint32_t vertex : triangle.vertex) {
            if (scene_.normals[vertex] == glm::vec3{0.0f}) {  // the file's normal is 0 or NaN
                scene_.normals[vertex] = flat;
            }
        }
        scene_.triangles.push_back(triangle);
    }

    const fs::path& file_;
    Scene& scene_;
    std::size_t dropped_ = 0;
};

void import_triangles(const fs::path& file, const aiScene& source, const std::vector<PlacedNode>& nodes,
                      Scene& scene) {
    Gatherer gatherer{file, scene};
    for (const PlacedNode& placed : nodes) {
        for (unsigned i = 0; i < placed.node->mNumMeshes; ++i) {
            gatherer.add(*source.mMeshes[placed.node->mMeshes[i]], placed.to_world);
        }
    }
    if (gatherer.dropped() > 0) {
        scene.remarks.push_back(std::to_string(gatherer.dropped()) + " triangles without area left out");
    }
    if (scene.triangles.empty()) {
        fail(file, "has no triangles");
    }
}

/// The mean colour of the vertices of every mesh that has any, in place of its material's: files of scans
/// come so.
void import_vertex_colours(const aiScene& source, Scene& scene) {
    bool any = false;
    for (unsigned i = 0; i < source.mNumMeshes; ++i) {
        const aiMesh& mesh = *source.mMeshes[i];
        if (!mesh.HasVertexColors(0)) {
            continue;
        }
        glm::vec3 sum{0.0f};
        for (unsigned k = 0; k < mesh.mNumVertices; ++k) {
            const aiColor4D& c = mesh.mColors[0][k];
            sum += glm::vec3{c.r, c.g, c.b};
        }
        scene.materials[mesh.mMaterialIndex].diffuse = sum / static_cast<float>(mesh.mNumVertices);
        any = true;
    }
    if (any) {
        scene.remarks.emplace_back("vertex colours are not drawn: each mesh has the mean of its own");
    }
}

void import_materials(const aiScene& source, const LogCapture& log, Scene& scene) {
    bool textures = false;
    for (unsigned i = 0; i < source.mNumMaterials; ++i) {
        scene.materials.push_back(convert_material(*source.mMaterials[i], i));
        textures = textures || has_texture(*source.mMaterials[i]);
    }
    if (textures) {
        scene.remarks.emplace_back("textures left out: surfaces have the plain colours of their materials");
    }
    for (const char* problem : {"Unable to locate material file", "failed to locate material"}) {
        if (const std::string line = log.find(problem); !line.empty()) {
            scene.remarks.push_back(line);
        }
    }
}

/// The light that falls on a point if nothing is in the way.
float irradiance(const Scene& scene, glm::vec3 p) {
    float sum = 0.0f;
    for (const SceneLight& light : scene.lights) {
        const float strength = (light.intensity.r + light.intensity.g + light.intensity.b) / 3.0f;
        const auto falling = [&](const auto& shape) {
            if constexpr (requires { shape.position; }) {
                const glm::vec3 way = shape.position - p;
                const float squared = glm::dot(way, way);
                return squared < shape.range * shape.range ? strength / squared : 0.0f;
            } else {
                return strength;
            }
        };
        sum += std::visit(falling, light.shape);
    }
    return sum;
}

/// Files give lights in candela and lux, anything from 0.1 to 100,000. Brings the median over the scene to
/// what the picture shows well, if it is far from it.
void adjust_exposure(Scene& scene) {
    constexpr float dark = 0.1f;
    constexpr float bright = 6.0f;
    constexpr std::size_t samples = 1000;
    std::vector<float> found;
    const std::size_t step = scene.triangles.size() / samples + 1;
    for (std::size_t i = 0; i < scene.triangles.size(); i += step) {
        const float value = irradiance(scene, scene.positions[scene.triangles[i].vertex[0]]);
        if (value > 0.0f && std::isfinite(value)) {
            found.push_back(value);
        }
    }
    if (found.empty()) {
        return;
    }
    const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
    std::nth_element(found.begin(), middle, found.end());
    if (*middle >= dark && *middle <= bright) {
        return;
    }
    const float factor = 1.2f / *middle;
    for (SceneLight& light : scene.lights) {
        light.intensity *= factor;
    }
    scene.remarks.push_back("the lights are scaled by " + std::to_string(factor) +
                            " to suit the picture's range");
}

void import_lights(const aiScene& source, const std::vector<PlacedNode>& nodes, Scene& scene) {
    for (const PlacedLight& placed : place_lights(source, nodes)) {
        const auto light = convert_light(placed);
        if (light && light->intensity != glm::vec3{0.0f}) {
            scene.lights.push_back(*light);
        }
    }
    if (scene.lights.empty()) {
        add_light_rig(scene);
        scene.remarks.push_back("the file has no lights: " + std::to_string(scene.lights.size()) +
                                " point lights added around and above");
    } else {
        adjust_exposure(scene);
    }
}

void import_camera(const aiScene& source, const std::vector<PlacedNode>& nodes, Scene& scene) {
    const glm::vec3 centre = bounds_of(scene).centre();
    for (unsigned i = 0; i < source.mNumCameras; ++i) {
        const aiCamera& camera = *source.mCameras[i];
        const auto place = std::find_if(nodes.begin(), nodes.end(), [&](const PlacedNode& placed) {
            return placed.node->mName == camera.mName;
        });
        if (place != nodes.end() && camera.mHorizontalFOV > 0.0f) {
            scene.camera = convert_camera(camera, place->to_world, centre);
            if (source.mNumCameras > 1) {
                scene.remarks.push_back("the file has " + std::to_string(source.mNumCameras) +
                                        " cameras: the view is '" + camera.mName.C_Str() + "'");
            }
            return;
        }
    }
    // All three formats are used with +y up; only glTF says so.
    scene.camera = view_of_all(scene, {0, 1, 0});
    scene.remarks.emplace_back("the file has no camera: seen from the front, with +y up");
}

}  // namespace

Scene import_scene(const fs::path& file) {
    check_file(file);
    const LogCapture log;
    Assimp::Importer importer;
    const aiScene& source = read(importer, file, log);
    std::vector<PlacedNode> nodes;
    collect_nodes(*source.mRootNode, aiMatrix4x4{}, nodes);

    Scene scene;
    scene.name = file.stem().string();
    import_triangles(file, source, nodes, scene);
    import_materials(source, log, scene);
    import_vertex_colours(source, scene);
    import_camera(source, nodes, scene);
    import_lights(source, nodes, scene);
    scene.background = {0.05f, 0.06f, 0.08f};
    scene.ambient = glm::vec3{0.06f};
    scene.radius = radius_share * bounds_of(scene).diagonal();
    return scene;
}

}  // namespace demo
