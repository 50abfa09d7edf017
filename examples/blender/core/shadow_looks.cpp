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

/// Numbers materials by what passes them: 0 for those that block everywhere.
class Sieves {
public:
    std::vector<std::size_t> numbers_of(const ShadowLooks& looks) {
        std::vector<std::size_t> numbers;
        numbers.reserve(looks.materials.size());
        for (const Material& material : looks.materials)
            numbers.push_back(may_let_light_through(material) ? 1 + add(Sieve(material, looks.textures)) : 0);
        return numbers;
    }

    bool has_texture(std::size_t number) const { return number > 0 && known_[number - 1].has_texture(); }

private:
    std::size_t add(const Sieve& sieve) {
        const auto found = std::ranges::find(known_, sieve);
        if (found != known_.end())
            return static_cast<std::size_t>(found - known_.begin());
        known_.push_back(sieve);
        return known_.size() - 1;
    }

    std::vector<Sieve> known_;
};

glm::vec2 coordinates_at(const ShadowLooks& looks, std::uint32_t vertex) {
    return looks.coordinates.empty() ? glm::vec2(0.0f) : looks.coordinates[vertex];
}

}  // namespace

bool let_same_light_through(const ShadowLooks& a, const ShadowLooks& b) {
    if (a.triangles.size() != b.triangles.size())
        return false;
    Sieves sieves;
    const std::vector<std::size_t> of_a = sieves.numbers_of(a);
    const std::vector<std::size_t> of_b = sieves.numbers_of(b);
    for (std::size_t t = 0; t < a.triangles.size(); ++t) {
        const Triangle& x = a.triangles[t];
        const Triangle& y = b.triangles[t];
        const std::size_t number = of_a[x.material];
        if (number != of_b[y.material])
            return false;
        if (!sieves.has_texture(number))
            continue;
        for (std::size_t k = 0; k < 3; ++k)
            if (coordinates_at(a, x.vertex[k]) != coordinates_at(b, y.vertex[k]))
                return false;
    }
    return true;
}

}  // namespace demo
