// SPDX-License-Identifier: MIT
#include "gltf_animation.hpp"
#include "gltf_draco.hpp"
#include "gltf_file.hpp"
#include "gltf_materials.hpp"
#include "isolated.hpp"
#include "model.hpp"

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace demo {
namespace {

using tinygltf::Value;

constexpr std::string_view supported_extensions[] = {"KHR_lights_punctual",
                                                     "KHR_node_visibility",
                                                     "EXT_mesh_gpu_instancing",
                                                     "KHR_texture_transform",
                                                     "KHR_materials_emissive_strength",
                                                     "KHR_materials_unlit",
                                                     "KHR_materials_transmission",
                                                     "KHR_materials_volume",
                                                     "KHR_materials_ior",
                                                     "KHR_materials_pbrSpecularGlossiness",
                                                     "KHR_mesh_quantization",
                                                     "KHR_draco_mesh_compression",
                                                     "EXT_meshopt_compression",
                                                     "KHR_meshopt_compression"};

bool is_supported(const std::string& extension) {
    return std::ranges::find(supported_extensions, extension) != std::end(supported_extensions);
}

/// A name that says more than the extension's own.
std::string described(const std::string& extension) {
    if (extension == "KHR_texture_basisu")
        return extension + " (textures in KTX2)";
    if (extension == "EXT_texture_webp")
        return extension + " (textures in WebP)";
    return extension;
}

void check_extensions(const tinygltf::Model& model, std::vector<std::string>& notes) {
    const auto listed = [](const std::vector<std::string>& names) {
        std::set<std::string> once;
        std::string list;
        for (const std::string& name : names)
            if (!is_supported(name) && once.insert(name).second)
                list += (list.empty() ? "" : ", ") + described(name);
        return list;
    };
    if (const std::string needed = listed(model.extensionsRequired); !needed.empty())
        throw std::runtime_error("requires what is not supported: " + needed);
    if (const std::string used = listed(model.extensionsUsed); !used.empty())
        notes.push_back("the file uses what is not supported, and is drawn without: " + used);
}

glm::dmat4 rotated(const std::vector<double>& q) {
    const glm::dquat rotation(q[3], q[0], q[1], q[2]);
    const double length = glm::length(rotation);
    return length > 0.0 ? glm::mat4_cast(rotation / length) : glm::dmat4(1.0);
}

/// Of a node to its parent; `with_scale` false leaves its scale out, for lights and cameras.
glm::dmat4 local_transform(const tinygltf::Node& node, bool with_scale) {
    glm::dmat4 local(1.0);
    if (node.matrix.size() == 16) {
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 4; ++row)
                local[column][row] = node.matrix[static_cast<std::size_t>(4 * column + row)];
        for (int column = 0; column < 3 && !with_scale; ++column) {
            const double length = glm::length(glm::dvec3(local[column]));
            local[column] = length > 0.0 ? local[column] / length : local[column];
        }
        return local;
    }
    if (node.translation.size() == 3)
        local[3] = {node.translation[0], node.translation[1], node.translation[2], 1.0};
    if (node.rotation.size() == 4)
        local = local * rotated(node.rotation);
    if (with_scale && node.scale.size() == 3)
        for (int axis = 0; axis < 3; ++axis)
            local[axis] *= node.scale[static_cast<std::size_t>(axis)];
    return local;
}

glm::dvec3 transformed(const glm::dmat4& matrix, glm::dvec3 point) {
    return glm::dvec3(matrix * glm::dvec4(point, 1.0));
}

/// The vertices of a primitive as the file has them: in the space of their mesh.
struct Primitive {
    std::vector<float> positions;
    std::vector<float> normals;
    std::array<std::vector<float>, 2> texture_coordinates;
    std::vector<float> colours;
    std::vector<std::vector<std::uint32_t>> joints;
    std::vector<std::vector<float>> weights;
    std::vector<std::uint32_t> indices;

    std::size_t size() const { return positions.size() / 3; }
    glm::dvec3 position(std::size_t i) const {
        return {positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]};
    }
    glm::dvec3 normal(std::size_t i) const {
        return {normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]};
    }
};

/// Corners of triangles from those of strips and fans.
std::vector<std::uint32_t> triangles_of(std::vector<std::uint32_t> corners, int mode) {
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        corners.resize(corners.size() / 3 * 3);
        return corners;
    }
    std::vector<std::uint32_t> triangles;
    for (std::size_t i = 2; i < corners.size(); ++i) {
        const bool is_fan = mode == TINYGLTF_MODE_TRIANGLE_FAN;
        const std::size_t a = is_fan ? 0 : i % 2 == 0 ? i - 2 : i - 1;
        const std::size_t b = is_fan ? i - 1 : i % 2 == 0 ? i - 1 : i - 2;
        triangles.insert(triangles.end(), {corners[a], corners[b], corners[i]});
    }
    return triangles;
}

/// The bytes that Draco's decoder and its result take for each vertex, about.
constexpr std::size_t draco_bytes_a_vertex = 400;

/// Reads the primitives of a file.
class PrimitiveReader {
public:
    explicit PrimitiveReader(const GltfFile& file) : file_(file) {}

    /// Nothing for points and lines.
    std::optional<Primitive> read(const tinygltf::Primitive& source,
                                  const std::vector<double>& morph_weights) {
        const int mode = source.mode < 0 ? TINYGLTF_MODE_TRIANGLES : source.mode;
        if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
            mode != TINYGLTF_MODE_TRIANGLE_FAN)
            return std::nullopt;
        open_draco(source);
        Primitive read;
        read.positions = attribute(source, "POSITION", 3);
        read.normals = attribute(source, "NORMAL", 3);
        read.texture_coordinates[0] = attribute(source, "TEXCOORD_0", 2);
        read.texture_coordinates[1] = attribute(source, "TEXCOORD_1", 2);
        read_colours(source, read);
        for (int set = 0; source.attributes.contains("JOINTS_" + std::to_string(set)); ++set)
            read_joints(source, std::to_string(set), read);
        if (draco_)
            read.indices = draco_->indices;
        else if (source.indices >= 0)
            read.indices = triangles_of(file_.integers(source.indices, 1), mode);
        else
            read.indices = triangles_of(count_up(read.size()), mode);
        check(read);
        morph(source, morph_weights, read);
        return read;
    }

private:
    static std::vector<std::uint32_t> count_up(std::size_t count) {
        std::vector<std::uint32_t> numbers(count);
        for (std::size_t i = 0; i < count; ++i)
            numbers[i] = static_cast<std::uint32_t>(i);
        return numbers;
    }

    void open_draco(const tinygltf::Primitive& source) {
        draco_.reset();
        draco_numbers_.clear();
        const auto found = source.extensions.find("KHR_draco_mesh_compression");
        if (found == source.extensions.end())
            return;
        const Value& extension = found->second;
        if (!extension.Has("bufferView") || !extension.Get("bufferView").IsNumber() ||
            !extension.Has("attributes") || !extension.Get("attributes").IsObject())
            throw std::runtime_error(
                "is damaged: KHR_draco_mesh_compression without a buffer view or attributes");
        if (const auto positions = source.attributes.find("POSITION"); positions != source.attributes.end())
            allow_memory(draco_bytes_a_vertex * file_.count(positions->second));
        draco_ = decode_draco(file_.view(extension.Get("bufferView").GetNumberAsInt()));
        for (const std::string& name : extension.Get("attributes").Keys())
            draco_numbers_[name] = extension.Get("attributes").Get(name).GetNumberAsInt();
    }

    /// The values of an attribute, from Draco or an accessor; empty if there is none.
    std::vector<float> attribute(const tinygltf::Primitive& source, const std::string& name,
                                 int components) const {
        if (const auto number = draco_numbers_.find(name); number != draco_numbers_.end()) {
            const auto found = draco_->attributes.find(number->second);
            if (found == draco_->attributes.end() || found->second.components != components)
                throw std::runtime_error("is damaged: Draco has no attribute " + name);
            return found->second.values;
        }
        const auto found = source.attributes.find(name);
        return found == source.attributes.end() ? std::vector<float>()
                                                : file_.floats(found->second, components);
    }

    void read_colours(const tinygltf::Primitive& source, Primitive& to) const {
        const auto found = source.attributes.find("COLOR_0");
        if (found == source.attributes.end())
            return;
        const int components = file_.components(found->second) == 3 ? 3 : 4;
        to.colours = attribute(source, "COLOR_0", components);
        if (components == 4)
            return;
        std::vector<float> with_alpha;
        with_alpha.reserve(to.colours.size() / 3 * 4);
        for (std::size_t i = 0; i + 2 < to.colours.size(); i += 3)
            with_alpha.insert(with_alpha.end(), {to.colours[i], to.colours[i + 1], to.colours[i + 2], 1.0f});
        to.colours = std::move(with_alpha);
    }

    void read_joints(const tinygltf::Primitive& source, const std::string& set, Primitive& to) const {
        std::vector<float> weights = attribute(source, "WEIGHTS_" + set, 4);
        if (draco_numbers_.contains("JOINTS_" + set)) {
            std::vector<std::uint32_t> joints;
            for (const float joint : attribute(source, "JOINTS_" + set, 4))
                joints.push_back(joint >= 0.0f ? static_cast<std::uint32_t>(joint) : 0u);
            to.joints.push_back(std::move(joints));
        } else {
            to.joints.push_back(file_.integers(source.attributes.at("JOINTS_" + set), 4));
        }
        to.weights.push_back(std::move(weights));
    }

    static void check(const Primitive& read) {
        const std::size_t count = read.size();
        const auto check_size = [count](std::size_t size, const char* name) {
            if (size != 0 && size != count)
                throw std::runtime_error("is damaged: " + std::to_string(size) + " of " + name + " for " +
                                         std::to_string(count) + " positions");
        };
        check_size(read.normals.size() / 3, "NORMAL");
        check_size(read.texture_coordinates[0].size() / 2, "TEXCOORD_0");
        check_size(read.texture_coordinates[1].size() / 2, "TEXCOORD_1");
        check_size(read.colours.size() / 4, "COLOR_0");
        for (std::size_t set = 0; set < read.joints.size(); ++set)
            if (read.joints[set].size() != 4 * count || read.weights[set].size() != 4 * count)
                throw std::runtime_error("is damaged: JOINTS and WEIGHTS do not fit the positions");
        for (const std::uint32_t index : read.indices)
            if (index >= count)
                throw std::runtime_error("a face refers to vertex " + std::to_string(index) +
                                         ", but there are only " + std::to_string(count));
    }

    void morph(const tinygltf::Primitive& source, const std::vector<double>& weights, Primitive& to) const {
        for (std::size_t target = 0; target < source.targets.size() && target < weights.size(); ++target) {
            if (weights[target] == 0.0)
                continue;
            const auto add = [&](const char* name, std::vector<float>& values) {
                const auto found = source.targets[target].find(name);
                if (found == source.targets[target].end() || values.empty())
                    return;
                const std::vector<float> moved = file_.floats(found->second, 3);
                if (moved.size() != values.size())
                    throw std::runtime_error("is damaged: a morph target has another number of vertices");
                for (std::size_t i = 0; i < values.size(); ++i)
                    values[i] += static_cast<float>(weights[target]) * moved[i];
            };
            add("POSITION", to.positions);
            add("NORMAL", to.normals);
        }
    }

    const GltfFile& file_;
    std::optional<DracoMesh> draco_;
    std::map<std::string, int> draco_numbers_;
};

/// Walks the nodes of the scene and collects what they carry, in world space.
class Walker {
public:
    Walker(const GltfFile& file, Model& result)
        : file_(file), source_(file.model()), result_(result), reader_(file), placed_(source_.nodes.size()) {}

    void walk() {
        place_nodes();
        collect_lights_and_cameras();
        for (const std::size_t node : order_)
            if (placed_[node].is_in_scene && source_.nodes[node].mesh >= 0) {
                if (placed_[node].is_visible)
                    add_mesh(node);
                else
                    ++hidden_meshes_;
            }
        add_notes();
    }

private:
    struct Placed {
        glm::dmat4 to_world{1.0};
        glm::dmat4 without_scale{1.0};  ///< its axes, for lights and cameras
        bool is_reached = false;
        bool is_in_scene = false;
        bool is_visible = true;
    };

    std::string called(std::size_t node) const {
        const std::string& name = source_.nodes[node].name;
        return "node " + std::to_string(node) + (name.empty() ? "" : " '" + name + "'");
    }

    /// All nodes without a parent.
    std::vector<int> all_roots() const {
        std::vector<bool> is_child(source_.nodes.size(), false);
        for (const tinygltf::Node& node : source_.nodes)
            for (const int child : node.children)
                if (child >= 0 && static_cast<std::size_t>(child) < is_child.size())
                    is_child[static_cast<std::size_t>(child)] = true;
        std::vector<int> roots;
        for (std::size_t node = 0; node < is_child.size(); ++node)
            if (!is_child[node])
                roots.push_back(static_cast<int>(node));
        return roots;
    }

    /// The roots of the scene that is shown.
    std::vector<int> scene_roots() const {
        if (source_.scenes.empty())
            return all_roots();
        const int chosen = source_.defaultScene < 0 ? 0 : source_.defaultScene;
        if (static_cast<std::size_t>(chosen) >= source_.scenes.size())
            throw std::runtime_error("is damaged: there is no scene " + std::to_string(chosen));
        if (source_.scenes.size() > 1)
            result_.notes.push_back("the file has " + std::to_string(source_.scenes.size()) +
                                    " scenes: number " + std::to_string(chosen) + " is drawn");
        return source_.scenes[static_cast<std::size_t>(chosen)].nodes;
    }

    /// Nodes below the given ones, parents first, without recursion: chains may be very long.
    void place_below(const std::vector<int>& roots, bool is_in_scene) {
        std::vector<int> waiting(roots.rbegin(), roots.rend());
        while (!waiting.empty()) {
            const int number = waiting.back();
            waiting.pop_back();
            if (number < 0 || static_cast<std::size_t>(number) >= placed_.size())
                throw std::runtime_error("is damaged: there is no node " + std::to_string(number));
            const auto node = static_cast<std::size_t>(number);
            Placed& placed = placed_[node];
            if (placed.is_reached)
                throw std::runtime_error("is damaged: " + called(node) + " has two parents, or is its own");
            placed.is_reached = true;
            placed.is_in_scene = is_in_scene;
            order_.push_back(node);
            placed.to_world = placed.to_world * local_transform(source_.nodes[node], true);
            placed.without_scale = placed.without_scale * local_transform(source_.nodes[node], false);
            const Value* visibility = gltf_extension(source_.nodes[node].extensions, "KHR_node_visibility");
            if (visibility != nullptr && visibility->Has("visible") && visibility->Get("visible").IsBool() &&
                !visibility->Get("visible").Get<bool>())
                placed.is_visible = false;
            const std::vector<int>& children = source_.nodes[node].children;
            for (auto child = children.rbegin(); child != children.rend(); ++child) {
                if (*child >= 0 && static_cast<std::size_t>(*child) < placed_.size()) {
                    Placed& below = placed_[static_cast<std::size_t>(*child)];
                    below.to_world = placed.to_world;
                    below.without_scale = placed.without_scale;
                    below.is_visible = placed.is_visible;
                }
                waiting.push_back(*child);
            }
        }
    }

    void place_nodes() {
        place_below(scene_roots(), true);
        if (source_.skins.empty())
            return;
        for (const int root : all_roots())  // bones may lie outside of the scene
            if (!placed_[static_cast<std::size_t>(root)].is_reached)
                place_below({root}, false);
    }

    void collect_lights_and_cameras() {
        for (const std::size_t node : order_) {
            if (!placed_[node].is_in_scene)
                continue;
            const Value* punctual = gltf_extension(source_.nodes[node].extensions, "KHR_lights_punctual");
            if (punctual != nullptr && punctual->Has("light") && punctual->Get("light").IsNumber()) {
                if (placed_[node].is_visible)
                    add_light(node, punctual->Get("light").GetNumberAsInt());
                else
                    ++hidden_lights_;
            }
            if (source_.nodes[node].camera >= 0)
                add_camera(node, source_.nodes[node].camera);
        }
    }

    void add_light(std::size_t node, int number) {
        if (number < 0 || static_cast<std::size_t>(number) >= file_.lights().size())
            throw std::runtime_error("is damaged: " + called(node) + " has the light " +
                                     std::to_string(number) + ", but there are only " +
                                     std::to_string(file_.lights().size()));
        ModelLight light = file_.lights()[static_cast<std::size_t>(number)];
        if (!source_.nodes[node].name.empty())
            light.name = source_.nodes[node].name;
        light.position = glm::dvec3(placed_[node].to_world[3]);
        light.axis = glm::dvec3(placed_[node].without_scale * glm::dvec4(0, 0, -1, 0));
        if (light.kind == ModelLight::Kind::spot && !(light.outer_cone > 0.0f)) {
            result_.notes.push_back("lamp '" + light.name + "' (" + called(node) +
                                    ") has a cone of 0: left out");
            return;
        }
        result_.lights.push_back(light);
    }

    void add_camera(std::size_t node, int number) {
        if (static_cast<std::size_t>(number) >= source_.cameras.size())
            throw std::runtime_error("is damaged: " + called(node) + " has the camera " +
                                     std::to_string(number) + ", but there are only " +
                                     std::to_string(source_.cameras.size()));
        const tinygltf::Camera& source = source_.cameras[static_cast<std::size_t>(number)];
        const Placed& placed = placed_[node];
        if (glm::dvec3(placed.to_world[0]) == glm::dvec3(0.0) ||
            glm::dvec3(placed.to_world[1]) == glm::dvec3(0.0) ||
            glm::dvec3(placed.to_world[2]) == glm::dvec3(0.0))
            throw std::runtime_error(called(node) + " has the scale 0, so its camera looks nowhere");
        ModelCamera camera;
        camera.name = !source_.nodes[node].name.empty() ? source_.nodes[node].name : source.name;
        camera.eye = glm::dvec3(placed.to_world[3]);
        camera.ahead = glm::dvec3(placed.without_scale * glm::dvec4(0, 0, -1, 0));
        camera.up = glm::dvec3(placed.without_scale * glm::dvec4(0, 1, 0, 0));
        if (source.type == "orthographic")
            camera.orthographic_height = static_cast<float>(2.0 * std::abs(source.orthographic.ymag));
        else
            camera.vertical_field_of_view = static_cast<float>(source.perspective.yfov);
        result_.cameras.push_back(camera);
    }

    const std::vector<double>& morph_weights(const tinygltf::Node& node, const tinygltf::Mesh& mesh) const {
        return node.weights.empty() ? mesh.weights : node.weights;
    }

    void add_mesh(std::size_t number) {
        const tinygltf::Node& node = source_.nodes[number];
        if (static_cast<std::size_t>(node.mesh) >= source_.meshes.size())
            throw std::runtime_error("is damaged: " + called(number) + " has the mesh " +
                                     std::to_string(node.mesh) + ", but there are only " +
                                     std::to_string(source_.meshes.size()));
        const tinygltf::Mesh& mesh = source_.meshes[static_cast<std::size_t>(node.mesh)];
        const std::vector<glm::dmat4> joints = joint_matrices(node, number);
        const std::vector<glm::dmat4> places =
            joints.empty() ? instances(number) : std::vector{glm::dmat4(1.0)};
        for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
            const std::string name =
                "mesh " + std::to_string(node.mesh) + " '" + mesh.name + "' at " + called(number);
            std::optional<Primitive> primitive;
            try {
                primitive = reader_.read(mesh.primitives[i], morph_weights(node, mesh));
            } catch (const std::bad_alloc&) {
                throw;
            } catch (const std::exception& error) {
                throw std::runtime_error(name + ": " + error.what());
            }
            if (!primitive) {
                ++left_out_primitives_;
                continue;
            }
            for (const glm::dmat4& place : places)
                add_primitive(*primitive, mesh.primitives[i].material, name, place, joints);
        }
    }

    /// The places where EXT_mesh_gpu_instancing puts the meshes of a node; otherwise where the node is.
    std::vector<glm::dmat4> instances(std::size_t number) const {
        const glm::dmat4& to_world = placed_[number].to_world;
        const Value* extension = gltf_extension(source_.nodes[number].extensions, "EXT_mesh_gpu_instancing");
        if (extension == nullptr || !extension->Has("attributes"))
            return {to_world};
        std::size_t count = 0;
        const auto values = [&](const char* name, int components) {
            const Value& attributes = extension->Get("attributes");
            if (!attributes.IsObject() || !attributes.Has(name) || !attributes.Get(name).IsNumber())
                return std::vector<float>();
            std::vector<float> read = file_.floats(attributes.Get(name).GetNumberAsInt(), components);
            const std::size_t found = read.size() / static_cast<std::size_t>(components);
            if (count != 0 && found != count)
                throw std::runtime_error("is damaged: the instances of " + called(number) + " are " +
                                         std::to_string(count) + " and " + std::to_string(found));
            count = found;
            return read;
        };
        const std::vector<float> moved = values("TRANSLATION", 3);
        const std::vector<float> turned = values("ROTATION", 4);
        const std::vector<float> scaled = values("SCALE", 3);
        std::vector<glm::dmat4> places(count, to_world);
        for (std::size_t i = 0; i < count; ++i) {
            glm::dmat4 local(1.0);
            if (!moved.empty())
                local[3] = {moved[3 * i], moved[3 * i + 1], moved[3 * i + 2], 1.0};
            if (!turned.empty())
                local =
                    local * rotated({turned[4 * i], turned[4 * i + 1], turned[4 * i + 2], turned[4 * i + 3]});
            for (int axis = 0; axis < 3 && !scaled.empty(); ++axis)
                local[axis] *= static_cast<double>(scaled[3 * i + static_cast<std::size_t>(axis)]);
            places[i] = to_world * local;
        }
        return places;
    }

    /// From the mesh to the world by each bone of the node's skin; empty without a skin.
    std::vector<glm::dmat4> joint_matrices(const tinygltf::Node& node, std::size_t number) const {
        if (node.skin < 0)
            return {};
        if (static_cast<std::size_t>(node.skin) >= source_.skins.size())
            throw std::runtime_error("is damaged: " + called(number) + " has the skin " +
                                     std::to_string(node.skin) + ", but there are only " +
                                     std::to_string(source_.skins.size()));
        const tinygltf::Skin& skin = source_.skins[static_cast<std::size_t>(node.skin)];
        std::vector<float> inverse;
        if (skin.inverseBindMatrices >= 0)
            inverse = file_.floats(skin.inverseBindMatrices, 16);
        if (!inverse.empty() && inverse.size() < 16 * skin.joints.size())
            throw std::runtime_error("is damaged: skin " + std::to_string(node.skin) + " has " +
                                     std::to_string(skin.joints.size()) + " joints, but " +
                                     std::to_string(inverse.size() / 16) + " bind matrices");
        std::vector<glm::dmat4> matrices;
        for (std::size_t i = 0; i < skin.joints.size(); ++i) {
            const int joint = skin.joints[i];
            if (joint < 0 || static_cast<std::size_t>(joint) >= placed_.size())
                throw std::runtime_error("is damaged: skin " + std::to_string(node.skin) + " has the joint " +
                                         std::to_string(joint) + ", which is no node");
            glm::dmat4 matrix = placed_[static_cast<std::size_t>(joint)].to_world;
            if (!inverse.empty()) {
                glm::dmat4 bind;
                for (int column = 0; column < 4; ++column)
                    for (int row = 0; row < 4; ++row)
                        bind[column][row] =
                            static_cast<double>(inverse[16 * i + static_cast<std::size_t>(4 * column + row)]);
                matrix = matrix * bind;
            }
            matrices.push_back(matrix);
        }
        return matrices;
    }

    /// The bones' matrices at a vertex, by its weights.
    static glm::dmat4 skinned(const Primitive& primitive, std::size_t vertex,
                              const std::vector<glm::dmat4>& joints) {
        glm::dmat4 sum(0.0);
        double total = 0.0;
        for (std::size_t set = 0; set < primitive.joints.size(); ++set) {
            for (std::size_t k = 4 * vertex; k < 4 * vertex + 4; ++k) {
                const auto weight = static_cast<double>(primitive.weights[set][k]);
                if (weight == 0.0)
                    continue;
                const std::uint32_t joint = primitive.joints[set][k];
                if (joint >= joints.size())
                    throw std::runtime_error("is damaged: a vertex hangs on joint " + std::to_string(joint) +
                                             ", but there are only " + std::to_string(joints.size()));
                sum += weight * joints[joint];
                total += weight;
            }
        }
        return total > 0.0 ? sum / total : joints.front();
    }

    void add_primitive(const Primitive& from, int material, const std::string& name, const glm::dmat4& place,
                       const std::vector<glm::dmat4>& joints) {
        const bool has_skin = !joints.empty() && !from.joints.empty();
        ModelMesh to;
        to.name = name;
        if (material >= 0 && static_cast<std::size_t>(material) >= source_.materials.size())
            throw std::runtime_error("is damaged: " + name + " has the material " + std::to_string(material) +
                                     ", but there are only " + std::to_string(source_.materials.size()));
        to.material = material >= 0 ? static_cast<std::uint32_t>(material) : default_material();
        const std::size_t count = from.size();
        // Meshes may be there many times.
        allow_memory(
            count * (sizeof(glm::dvec3) + sizeof(glm::vec3) + sizeof(glm::vec4)) +
            (from.texture_coordinates[0].size() + from.texture_coordinates[1].size() + from.indices.size()) *
                sizeof(float));
        to.positions.reserve(count);
        if (!from.normals.empty())
            to.normals.reserve(count);
        glm::dmat4 matrix = place;
        glm::dmat3 for_normals = cofactors(matrix);
        for (std::size_t i = 0; i < count; ++i) {
            if (has_skin) {
                matrix = skinned(from, i, joints);
                for_normals = cofactors(matrix);
            }
            to.positions.push_back(transformed(matrix, from.position(i)));
            if (!from.normals.empty())
                to.normals.push_back(unit(for_normals * from.normal(i)));
        }
        for (std::size_t set = 0; set < 2; ++set)
            for (std::size_t i = 0; i + 1 < from.texture_coordinates[set].size(); i += 2)
                to.texture_coordinates[set].emplace_back(from.texture_coordinates[set][i],
                                                         from.texture_coordinates[set][i + 1]);
        for (std::size_t i = 0; i + 3 < from.colours.size(); i += 4)
            to.colours.emplace_back(from.colours[i], from.colours[i + 1], from.colours[i + 2],
                                    from.colours[i + 3]);
        to.indices = from.indices;
        if (!has_skin && glm::determinant(glm::dmat3(place)) < 0.0)
            for (std::size_t i = 0; i + 2 < to.indices.size(); i += 3)
                std::swap(to.indices[i + 1], to.indices[i + 2]);
        result_.meshes.push_back(std::move(to));
    }

    /// The matrix that turns normals: the inverse transposed, times the determinant, so that a plane's
    /// thickness of 0 does no harm.
    static glm::dmat3 cofactors(const glm::dmat4& matrix) {
        const glm::dmat3 m(matrix);
        const double sign = glm::determinant(m) < 0.0 ? -1.0 : 1.0;
        return {sign * glm::cross(m[1], m[2]), sign * glm::cross(m[2], m[0]), sign * glm::cross(m[0], m[1])};
    }

    static glm::vec3 unit(const glm::dvec3& v) {
        const double length = glm::length(v);
        return length > 0.0 && std::isfinite(length) ? glm::vec3(v / length) : glm::vec3(0.0f);
    }

    /// glTF's material of meshes that have none.
    std::uint32_t default_material() {
        if (!default_material_) {
            default_material_ = static_cast<std::uint32_t>(result_.materials.size());
            Material plain;
            plain.name = "default";
            set_metallic_roughness(plain, {});
            plain.diffuse = glm::vec3{0.8f};
            result_.materials.push_back(plain);
        }
        return *default_material_;
    }

    void add_notes() {
        if (left_out_primitives_ > 0)
            result_.notes.push_back(std::to_string(left_out_primitives_) +
                                    " meshes of points or lines are not drawn");
        if (hidden_meshes_ + hidden_lights_ > 0)
            result_.notes.push_back(std::to_string(hidden_meshes_) + " meshes and " +
                                    std::to_string(hidden_lights_) + " lights are hidden, as the file says");
    }

    const GltfFile& file_;
    const tinygltf::Model& source_;
    Model& result_;
    PrimitiveReader reader_;
    std::vector<Placed> placed_;
    std::vector<std::size_t> order_;
    std::optional<std::uint32_t> default_material_;
    std::size_t left_out_primitives_ = 0;
    std::size_t hidden_meshes_ = 0;
    std::size_t hidden_lights_ = 0;
};

}  // namespace

Model read_gltf(const std::filesystem::path& path, const ReadOptions& options) {
    GltfFile file(path);
    Model model;
    if (options.time)
        model.animation_length = pose_at(file, *options.time, options.animation);
    else if (!file.model().animations.empty())
        file.add_note("the file has animations: its default pose is drawn; --time takes another");
    model.notes = file.notes();
    check_extensions(file.model(), model.notes);
    bool left_out = false;
    std::set<std::int32_t> wanted;
    for (std::size_t i = 0; i < file.model().materials.size(); ++i) {
        model.materials.push_back(gltf_material(file, i, left_out));
        wanted.insert(model.materials.back().base_map.texture);
        wanted.insert(model.materials.back().emission_map.texture);
    }
    if (left_out)
        model.notes.emplace_back("textures of normals, roughness, occlusion and transmission are not drawn");
    for (std::size_t i = 0; i < file.image_count(); ++i)
        model.images.push_back(
            options.pictures && wanted.contains(static_cast<std::int32_t>(i)) ? file.image(i) : ModelImage{});
    Walker(file, model).walk();
    return model;
}

}  // namespace demo
