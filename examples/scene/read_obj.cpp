// SPDX-License-Identifier: MIT
#include "assimp_materials.hpp"
#include "file_bytes.hpp"
#include "image/image.hpp"
#include "isolated.hpp"
#include "model.hpp"
#include "obj_text.hpp"

#include <assimp/DefaultIOSystem.h>
#include <assimp/DefaultLogger.hpp>
#include <assimp/IOStream.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

namespace demo {
namespace {

namespace fs = std::filesystem;

std::string in_brackets(glm::vec3 v) {
    return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
}

glm::vec3 to_glm(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}

/// Remarks that Assimp only writes to its log. The log is one for the whole process, so one import runs at a
/// time.
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

/// Gives Assimp one file from memory, and all others from the disk.
class PreparedFile : public Assimp::DefaultIOSystem {
public:
    PreparedFile(std::string path, std::string content)
        : path_(std::move(path)), content_(std::move(content)) {}

    Assimp::IOStream* Open(const char* file, const char* mode) override {
        if (path_ != file)
            return DefaultIOSystem::Open(file, mode);
        return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(content_.data()),
                                          content_.size());
    }

private:
    std::string path_;
    std::string content_;
};

/// Looks at the data as it came from the file. Assimp's later steps trust it: Debian's build ends the process
/// where an assertion fails.
void check_mesh(const aiMesh& mesh, unsigned number) {
    const std::string where = "mesh " + std::to_string(number) + " '" + mesh.mName.C_Str() + "'";
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
        const glm::vec3 p = to_glm(mesh.mVertices[i]);
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            throw std::runtime_error("vertex " + std::to_string(i) + " of " + where +
                                     " is not finite: " + in_brackets(p));
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
        const aiFace& face = mesh.mFaces[i];
        if (face.mNumIndices == 0)
            throw std::runtime_error("face " + std::to_string(i) + " of " + where +
                                     " has no vertices; the file may be cut off");
        for (unsigned k = 0; k < face.mNumIndices; ++k)
            if (face.mIndices[k] >= mesh.mNumVertices)
                throw std::runtime_error("face " + std::to_string(i) + " of " + where + " refers to vertex " +
                                         std::to_string(face.mIndices[k]) + ", but there are only " +
                                         std::to_string(mesh.mNumVertices));
    }
}

/// Reads the file, checks it, and has Assimp make triangles with normals of it.
const aiScene& read(Assimp::Importer& importer, const fs::path& file, const LogCapture& log) {
    const aiScene* source = importer.ReadFile(file.string(), 0);
    if (!source) {
        const std::string problem = importer.GetErrorString();
        throw std::runtime_error(
            problem.find("No suitable reader") == 0 ? "is damaged, or not what its name says" : problem);
    }
    if (const std::string line = log.find("out-of-range indices"); !line.empty())
        throw std::runtime_error("faces refer to vertices that are not there");
    unsigned faces = 0;
    for (unsigned i = 0; i < source->mNumMeshes; ++i) {
        check_mesh(*source->mMeshes[i], i);
        faces += source->mMeshes[i]->mNumFaces;
    }
    if (faces == 0)
        throw std::runtime_error("has no triangles");
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, 40.0f);
    constexpr unsigned steps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_GenSmoothNormals;
    source = importer.ApplyPostProcessing(steps);
    if (!source || !source->mRootNode)
        throw std::runtime_error("has no triangles");
    return *source;
}

/// Collects the pictures of textures, each once.
class Pictures {
public:
    Pictures(const fs::path& folder, std::vector<ModelImage>& images) : folder_(folder), images_(images) {}

    TextureMap map(const aiMaterial& material, aiTextureType type) {
        TextureMap map;
        aiString path;
        if (material.GetTexture(type, 0, &path) != AI_SUCCESS)
            return map;
        std::string name = path.C_Str();
        std::ranges::replace(name, '\\', '/');
        map.texture = number_of(name);
        // OBJ counts v from the lower edge of a picture.
        map.transform = glm::mat3x2{1, 0, 0, -1, 0, 1};
        map.wrap_u = wrap(material, AI_MATKEY_MAPPINGMODE_U(type, 0));
        map.wrap_v = wrap(material, AI_MATKEY_MAPPINGMODE_V(type, 0));
        return map;
    }

private:
    static Wrap wrap(const aiMaterial& material, const char* key, unsigned type, unsigned index) {
        return get_or(material, key, type, index, 0) == aiTextureMapMode_Clamp ? Wrap::clamp : Wrap::repeat;
    }

    std::int32_t number_of(const std::string& name) {
        const auto [found, is_new] = numbers_.emplace(name, static_cast<std::int32_t>(images_.size()));
        if (is_new) {
            ModelImage image;
            image.name = name;
            std::error_code ignored;
            if (!fs::is_regular_file(folder_ / name, ignored)) {
                image.problem = "is not there";
            } else {
                image.encoded = read_whole<std::vector<std::uint8_t>>(folder_ / name);
                allow_file(image.encoded.size());
            }
            images_.push_back(std::move(image));
        }
        return found->second;
    }

    fs::path folder_;
    std::vector<ModelImage>& images_;
    std::map<std::string, std::int32_t> numbers_;
};

void read_materials(const aiScene& source, const fs::path& file, const LogCapture& log, Model& model) {
    Pictures pictures(file.parent_path(), model.images);
    bool left_out = false;
    for (unsigned i = 0; i < source.mNumMaterials; ++i) {
        const aiMaterial& from = *source.mMaterials[i];
        Material material = convert_material(from, i);
        material.base_map = pictures.map(from, aiTextureType_DIFFUSE);
        material.opacity_map = pictures.map(from, aiTextureType_OPACITY);
        material.emission_map = pictures.map(from, aiTextureType_EMISSIVE);
        if (material.emission_map.texture >= 0 && material.emission == glm::vec3{0.0f})
            material.emission = glm::vec3{1.0f};
        // Without a word of the format on it, alpha of a picture is a stencil: leaves and fences.
        if (material.base_map.texture >= 0 || material.opacity_map.texture >= 0)
            material.alpha_mode = AlphaMode::mask;
        model.materials.push_back(std::move(material));
        for (const aiTextureType type :
             {aiTextureType_SPECULAR, aiTextureType_HEIGHT, aiTextureType_NORMALS, aiTextureType_SHININESS,
              aiTextureType_REFLECTION, aiTextureType_DISPLACEMENT, aiTextureType_AMBIENT})
            left_out = left_out || from.GetTextureCount(type) > 0;
    }
    if (left_out)
        model.notes.emplace_back("textures of highlights, bumps and reflections are not drawn");
    for (const char* problem : {"Unable to locate material file", "failed to locate material"})
        if (const std::string line = log.find(problem); !line.empty())
            model.notes.push_back(line);
}

ModelMesh read_mesh(const aiMesh& source, unsigned number, const glm::dvec3& origin) {
    ModelMesh mesh;
    mesh.name = "mesh " + std::to_string(number) + " '" + source.mName.C_Str() + "'";
    mesh.material = source.mMaterialIndex;
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
        mesh.positions.push_back(glm::dvec3(to_glm(source.mVertices[i])) + origin);
        if (source.HasNormals())
            mesh.normals.push_back(to_glm(source.mNormals[i]));
        if (source.HasTextureCoords(0))
            mesh.texture_coordinates[0].emplace_back(source.mTextureCoords[0][i].x,
                                                     source.mTextureCoords[0][i].y);
        if (source.HasVertexColors(0)) {
            const aiColor4D& c = source.mColors[0][i];
            mesh.colours.emplace_back(from_srgb(c.r), from_srgb(c.g), from_srgb(c.b), 1.0f);
        }
    }
    for (unsigned i = 0; i < source.mNumFaces; ++i)
        if (source.mFaces[i].mNumIndices == 3)
            mesh.indices.insert(mesh.indices.end(), source.mFaces[i].mIndices, source.mFaces[i].mIndices + 3);
    return mesh;
}

}  // namespace

Model read_obj(const fs::path& file) {
    const LogCapture log;
    Assimp::Importer importer;
    ObjText prepared = prepare_obj(read_whole<std::string>(file));
    importer.SetIOHandler(new PreparedFile(file.string(), std::move(prepared.text)));  // deleted by it
    const aiScene& source = read(importer, file, log);
    Model model;
    read_materials(source, file, log, model);
    for (unsigned i = 0; i < source.mNumMeshes; ++i)
        model.meshes.push_back(read_mesh(*source.mMeshes[i], i, prepared.origin));
    return model;
}

}  // namespace demo
