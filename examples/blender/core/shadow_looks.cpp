// SPDX-License-Identifier: MIT
#include "blender/core/shadow_looks.hpp"

#include "scene/surface.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>

namespace demo {

namespace {

/// A material by what `share_let_through` and `is_hole` ask of it.
class Sieve {
public:
    Sieve(const Material& material, const std::vector<const Texture*>& textures)
        : material_(material), has_colour_(material.shadow == ShadowBy::opacity && material.k_t > 0.0f) {
        if (has_colour_ || material.alpha_mode != AlphaMode::opaque) {
            base_ = texture_of(material.base_map, textures);
            opacity_ = texture_of(material.opacity_map, textures);
        }
    }

    bool has_texture() const { return base_ != nullptr || opacity_ != nullptr; }

    bool operator==(const Sieve& other) const {
        return parts() == other.parts() && same(base_, other.base_) && same(opacity_, other.opacity_) &&
               (base_ == nullptr || same(material_.base_map, other.material_.base_map)) &&
               (opacity_ == nullptr || same(material_.opacity_map, other.material_.opacity_map));
    }

private:
    static const Texture* texture_of(const TextureMap& map, const std::vector<const Texture*>& textures) {
        return map.texture < 0 ? nullptr : textures[static_cast<std::size_t>(map.texture)];
    }

    static bool same(const Texture* a, const Texture* b) {
        const auto parts = [](const Texture& t) {
            return std::tie(t.width, t.height, t.has_alpha, t.is_linear, t.blends_encoded, t.rgba);
        };
        return a == b || (a != nullptr && b != nullptr && parts(*a) == parts(*b));
    }

    static bool same(const TextureMap& a, const TextureMap& b) {
        return std::tie(a.coordinates, a.wrap_u, a.wrap_v, a.transform) ==
               std::tie(b.coordinates, b.wrap_u, b.wrap_v, b.transform);
    }

    std::tuple<ShadowBy, AlphaMode, float, float, float, glm::vec3> parts() const {
        const bool has_alpha = material_.alpha_mode != AlphaMode::opaque;
        return {material_.shadow,
                material_.alpha_mode,
                material_.alpha_mode == AlphaMode::mask ? material_.alpha_cutoff : 0.0f,
                has_alpha ? material_.opacity : 1.0f,
                has_colour_ ? material_.k_t : 0.0f,
                has_colour_ ? material_.tint : glm::vec3(1.0f)};
    }

    const Material& material_;
    bool has_colour_;
    const Texture* base_ = nullptr;
    const Texture* opacity_ = nullptr;
};

std::size_t number_of(const Material& material, const std::vector<const Texture*>& textures,
                      std::vector<Sieve>& known) {
    if (!may_let_light_through(material))
        return 0;
    const Sieve sieve(material, textures);
    const auto found = std::ranges::find(known, sieve);
    const auto number = static_cast<std::size_t>(found - known.begin());
    if (found == known.end())
        known.push_back(sieve);
    return number + 1;
}

}  // namespace

Passing passing_of(const ShadowLooks& before, const ShadowLooks& after) {
    Passing passing;
    std::vector<Sieve> known;
    for (const Material& material : before.materials)
        passing.before.push_back(number_of(material, before.textures, known));
    for (const Material& material : after.materials)
        passing.after.push_back(number_of(material, after.textures, known));
    passing.has_texture.push_back(false);
    for (const Sieve& sieve : known)
        passing.has_texture.push_back(sieve.has_texture());
    return passing;
}

}  // namespace demo
