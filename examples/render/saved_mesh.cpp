// SPDX-License-Identifier: MIT
#include "render/saved_mesh.hpp"

#include "render/files.hpp"

#include <lightmesh/snapshot.hpp>

#include <array>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

namespace demo {

namespace {

/// After the snapshot, so that it begins where memory does: a mark and the fingerprint.
constexpr std::string_view mark = "LMRENDER";
constexpr std::size_t trailer_size = mark.size() + sizeof(std::uint64_t);

class Fingerprint {
public:
    /// Values without padding.
    template <class Value>
    void add(std::span<const Value> values) {
        static_assert(std::is_trivially_copyable_v<Value>);
        add_word(values.size());
        const std::span<const std::byte> bytes = std::as_bytes(values);
        for (std::size_t i = 0; i < bytes.size(); i += 8) {
            std::uint64_t word = 0;
            std::memcpy(&word, bytes.data() + i, bytes.size() - i < 8 ? bytes.size() - i : 8);
            add_word(word);
        }
    }
    template <class Value>
    void add(const Value& value) {
        add(std::span<const Value>(&value, 1));
    }
    std::uint64_t value() const { return value_; }

private:
    /// FNV-1a of words; the shift brings high bits down, which a product alone never does.
    void add_word(std::uint64_t word) {
        value_ = (value_ ^ word) * 1099511628211ULL;
        value_ ^= value_ >> 32;
    }

    std::uint64_t value_ = 14695981039346656037ULL;
};

void add_map(Fingerprint& sum, const TextureMap& map) {
    sum.add(map.texture);
    sum.add(map.coordinates);
    sum.add(map.wrap_u);
    sum.add(map.wrap_v);
    sum.add(map.transform);
}

void add_light(Fingerprint& sum, const lightmesh::Light& light) {
    sum.add(light.index());
    std::visit(
        [&](const auto& kind) {
            using Kind = std::remove_cvref_t<decltype(kind)>;
            if constexpr (std::is_same_v<Kind, lightmesh::DirectionalLight>) {
                sum.add(kind.direction);
            } else {
                sum.add(kind.position);
                sum.add(kind.range);
            }
            if constexpr (std::is_same_v<Kind, lightmesh::SpotLight>) {
                sum.add(kind.axis);
                sum.add(kind.cone);
            }
            if constexpr (std::is_same_v<Kind, lightmesh::RectLight>) {
                sum.add(kind.half_u);
                sum.add(kind.half_v);
            }
        },
        light);
}

}  // namespace

std::uint64_t shadow_fingerprint(const Scene& scene) {
    Fingerprint sum;
    sum.add(std::span(scene.positions));
    sum.add(std::span(scene.triangles));
    sum.add(std::span(scene.colours));
    for (const std::vector<glm::vec2>& coordinates : scene.texture_coordinates)
        sum.add(std::span(coordinates));
    for (const Material& material : scene.materials) {
        sum.add(material.k_t);
        sum.add(material.tint);
        sum.add(material.opacity);
        sum.add(material.alpha_mode);
        sum.add(material.alpha_cutoff);
        sum.add(material.shadow);
        add_map(sum, material.base_map);
        add_map(sum, material.opacity_map);
    }
    for (const Texture& texture : scene.textures) {
        sum.add(texture.width);
        sum.add(std::span(texture.rgba));
    }
    for (const SceneLight& light : scene.lights)
        add_light(sum, light.shape);
    return sum.value();
}

std::uint64_t look_fingerprint(const Scene& scene) {
    Fingerprint sum;
    sum.add(shadow_fingerprint(scene));
    sum.add(std::span(scene.normals));
    for (const Material& m : scene.materials) {
        for (const glm::vec3& colour : {m.diffuse, m.specular, m.emission})
            sum.add(colour);
        for (const float value : {m.shininess, m.k_s, m.refraction_index, m.metallic})
            sum.add(value);
        add_map(sum, m.emission_map);
        sum.add(m.is_unlit);
    }
    for (const SceneLight& light : scene.lights) {
        sum.add(light.intensity);
        sum.add(light.inner_cone);
        sum.add(light.facing);
    }
    sum.add(scene.background);
    return sum.value();
}

void save_mesh(const std::filesystem::path& file, std::span<const std::byte> snapshot, const Scene& scene) {
    const std::uint64_t fingerprint = shadow_fingerprint(scene);
    std::string content(reinterpret_cast<const char*>(snapshot.data()), snapshot.size());
    content += mark;
    content.append(reinterpret_cast<const char*>(&fingerprint), sizeof fingerprint);
    write_file(file, content);
}

std::vector<std::byte> load_mesh(const std::filesystem::path& file, const Scene& scene) {
    const std::string content = read_file(file);
    const auto refuse = [&](const std::string& why) {
        throw std::runtime_error("cannot use the mesh " + file.string() + ": " + why);
    };
    if (content.size() < trailer_size ||
        !std::string_view(content).substr(content.size() - trailer_size).starts_with(mark))
        refuse("--save-mesh has not written it, or it is not whole");
    const std::size_t size = content.size() - trailer_size;
    std::vector<std::byte> snapshot(size);
    std::memcpy(snapshot.data(), content.data(), size);
    try {
        static_cast<void>(lightmesh::SnapshotView(snapshot));
    } catch (const std::invalid_argument& wrong) {
        refuse(wrong.what());
    }
    std::uint64_t fingerprint = 0;
    std::memcpy(&fingerprint, content.data() + size + mark.size(), sizeof fingerprint);
    if (fingerprint != shadow_fingerprint(scene))
        refuse("it is of another scene, or of other lights");
    return snapshot;
}

}  // namespace demo
