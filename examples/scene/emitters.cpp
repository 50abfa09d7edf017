// SPDX-License-Identifier: MIT
#include "emitters.hpp"

#include "boxes.hpp"
#include "surface.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

namespace demo {
namespace {

/// Patches wider than this share of the scene's diagonal get four lamps.
constexpr float small_patch = 0.02f;
/// A piece of more patches is no box: it is taken as round.
constexpr std::size_t most_patches = 6;

bool shines(const Material& material) {
    return !material.is_unlit && material.emission != glm::vec3{0.0f};
}

std::array<glm::vec3, 3> corners(const Scene& scene, std::size_t t) {
    const auto& vertex = scene.triangles[t].vertex;
    return {scene.positions[vertex[0]], scene.positions[vertex[1]], scene.positions[vertex[2]]};
}

/// A part of a triangle with the light it gives.
struct Sample {
    glm::vec3 position;
    glm::vec3 normal;
    glm::vec3 power;  ///< radiance times area
    float area;
    std::size_t triangle;
};

float sum_of(glm::vec3 v) {
    return v.r + v.g + v.b;
}

/// Four parts of a triangle.
void add_samples(const Scene& scene, std::size_t t, std::vector<Sample>& samples) {
    constexpr float third = 1.0f / 3.0f;
    constexpr std::array<std::array<float, 2>, 4> places{{{third, third},
                                                          {1.0f / 6.0f, 1.0f / 6.0f},
                                                          {2.0f * third, 1.0f / 6.0f},
                                                          {1.0f / 6.0f, 2.0f * third}}};
    const auto [a, b, c] = corners(scene, t);
    const glm::vec3 normal = glm::cross(b - a, c - a);
    const float twice_area = glm::length(normal);
    if (!(twice_area > 0.0f))
        return;
    for (const auto& [u, v] : places) {
        const Surface surface = surface_at(scene, t, u, v);
        samples.push_back({(1.0f - u - v) * a + u * b + v * c, normal / twice_area,
                           surface.emission * (twice_area / 8.0f), twice_area / 8.0f, t});
    }
}

/// Samples that lie in one plane.
struct Patch {
    glm::vec3 normal;
    float height;
    std::vector<Sample> samples;
};

/// Sorts samples by their planes; no more than `most_patches`, else nothing.
std::optional<std::vector<Patch>> patches_of(const std::vector<Sample>& samples, float thickness) {
    std::vector<Patch> patches;
    for (const Sample& sample : samples) {
        const auto fits = [&](const Patch& patch) {
            return std::abs(glm::dot(patch.normal, sample.normal)) > 0.98f &&
                   std::abs(glm::dot(patch.normal, sample.position) - patch.height) < thickness;
        };
        auto found = std::ranges::find_if(patches, fits);
        if (found == patches.end()) {
            if (patches.size() == most_patches)
                return std::nullopt;
            patches.push_back({sample.normal, glm::dot(sample.normal, sample.position), {}});
            found = patches.end() - 1;
        }
        found->samples.push_back(sample);
    }
    return patches;
}

struct Extent {
    glm::vec3 low;
    glm::vec3 high;
    float size() const { return glm::length(high - low); }
};

Extent extent_of(const std::vector<Sample>& samples) {
    Extent extent{samples.front().position, samples.front().position};
    for (const Sample& sample : samples) {
        extent.low = glm::min(extent.low, sample.position);
        extent.high = glm::max(extent.high, sample.position);
    }
    return extent;
}

/// A rectangle in space.
struct Rectangle {
    glm::vec3 centre;
    glm::vec3 half_u;
    glm::vec3 half_v;
};

/// The smallest rectangle around a patch with a side along `along`, and the share of it that the triangles
/// fill.
std::pair<Rectangle, float> rectangle_along(const Scene& scene, const Patch& patch, const glm::vec3& along) {
    const glm::vec3 u = glm::normalize(along - glm::dot(along, patch.normal) * patch.normal);
    const glm::vec3 v = glm::cross(patch.normal, u);
    glm::vec2 low{INFINITY};
    glm::vec2 high{-INFINITY};
    float area = 0.0f;
    std::size_t last = scene.triangles.size();
    for (const Sample& sample : patch.samples) {
        if (sample.triangle == last)
            continue;
        last = sample.triangle;
        const auto [a, b, c] = corners(scene, last);
        area += 0.5f * glm::length(glm::cross(b - a, c - a));
        for (const glm::vec3& corner : {a, b, c}) {
            low = glm::min(low, glm::vec2(glm::dot(corner, u), glm::dot(corner, v)));
            high = glm::max(high, glm::vec2(glm::dot(corner, u), glm::dot(corner, v)));
        }
    }
    const glm::vec2 middle = 0.5f * (low + high);
    const glm::vec2 half = 0.5f * (high - low);
    return {{middle.x * u + middle.y * v + patch.height * patch.normal, half.x * u, half.y * v},
            area / (4.0f * half.x * half.y)};
}

/// The rectangle that a patch is; nothing for one of another form.
std::optional<Rectangle> rectangle_of(const Scene& scene, const Patch& patch) {
    constexpr float nearly_all = 0.98f;
    const auto [a, b, c] = corners(scene, patch.samples.front().triangle);
    for (const glm::vec3& side : {b - a, c - b, a - c}) {
        const auto [rectangle, share] = rectangle_along(scene, patch, side);
        if (share > nearly_all)
            return rectangle;
    }
    return std::nullopt;
}

/// A rectangle around any patch, with a side along the longest one of its box.
Rectangle box_of(const Scene& scene, const Patch& patch) {
    const Extent extent = extent_of(patch.samples);
    const glm::vec3 size = extent.high - extent.low;
    const int longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    glm::vec3 axis{0.0f};
    axis[longest] = 1.0f;
    return rectangle_along(scene, patch, axis).first;
}

/// Which sides of a patch light the scene.
enum class Sides { front, back, both };

/// A quarter of a patch, or all of it.
struct Part {
    glm::vec3 front{0.0f};  ///< the power of triangles that face as the patch does
    glm::vec3 back{0.0f};   ///< and of the others
    glm::vec3 weighted{0.0f};
    float weight = 0.0f;
    float area = 0.0f;

    void add(const Sample& sample, const glm::vec3& normal) {
        area += sample.area;
        (glm::dot(sample.normal, normal) > 0.0f ? front : back) += sample.power;
        weighted += sum_of(sample.power) * sample.position;
        weight += sum_of(sample.power);
    }
    /// Of each side: where triangles face one way only, they shine to both sides, as they are drawn.
    glm::vec3 power(bool of_front) const {
        if (front == glm::vec3(0.0f) || back == glm::vec3(0.0f))
            return front + back;
        return of_front ? front : back;
    }
};

/// Radiance L and area A give the intensity L A cos; pictures take intensities as divided by pi, since
/// surfaces reflect their colour, not a share of 1 / pi of it.
glm::vec3 intensity_of(const glm::vec3& power) {
    return power / std::numbers::pi_v<float>;
}

SceneLight pane_at(const Rectangle& place, bool of_front, const glm::vec3& power, const std::string& name) {
    SceneLight light;
    light.shape = of_front ? lightmesh::RectLight{place.centre, place.half_u, place.half_v}
                           : lightmesh::RectLight{place.centre, place.half_v, place.half_u};
    light.intensity = intensity_of(power);
    light.name = name;
    return light;
}

/// A patch as lamps in its plane: a quarter of it each, if it is large. Rectangles are lamps of their size,
/// one for each side that shines.
void add_patch(const Scene& scene, const Patch& patch, Sides sides, float diagonal, const std::string& name,
               std::vector<SceneLight>& lights) {
    const bool is_small = extent_of(patch.samples).size() < small_patch * diagonal;
    const std::optional<Rectangle> exact = rectangle_of(scene, patch);
    const Rectangle whole = exact ? *exact : box_of(scene, patch);
    std::array<Part, 4> parts;
    for (const Sample& sample : patch.samples) {
        const glm::vec3 way = sample.position - whole.centre;
        const bool is_right = glm::dot(way, whole.half_u) > 0.0f;
        const bool is_up = glm::dot(way, whole.half_v) > 0.0f;
        parts[is_small ? 0 : (is_right ? 1u : 0u) + (is_up ? 2u : 0u)].add(sample, patch.normal);
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const Part& part = parts[i];
        if (!(part.weight > 0.0f))
            continue;
        if (!exact) {
            SceneLight lamp;
            lamp.shape = lightmesh::PointLight{.position = part.weighted / part.weight,
                                               .radius = std::sqrt(part.area / std::numbers::pi_v<float>)};
            lamp.intensity = intensity_of(glm::max(part.power(true), part.power(false)));
            lamp.facing = patch.normal;
            lamp.name = name;
            lights.push_back(lamp);
            continue;
        }
        Rectangle place = whole;
        if (!is_small)
            place = {whole.centre + (i % 2 == 1 ? 0.5f : -0.5f) * whole.half_u +
                         (i / 2 == 1 ? 0.5f : -0.5f) * whole.half_v,
                     0.5f * whole.half_u, 0.5f * whole.half_v};
        for (const bool of_front : {true, false})
            if (sides == Sides::both || (sides == Sides::front) == of_front)
                lights.push_back(pane_at(place, of_front, part.power(of_front), name));
    }
}

/// Of a patch of a piece that lies wholly on one side of it, as of a box, only the other side lights the
/// scene.
Sides sides_of(const Patch& patch, const std::vector<Sample>& piece) {
    const float thickness = 0.01f * extent_of(piece).size();
    float low = 0.0f;
    float high = 0.0f;
    for (const Sample& sample : piece) {
        const float height = glm::dot(patch.normal, sample.position) - patch.height;
        low = (std::min)(low, height);
        high = (std::max)(high, height);
    }
    if (low < -thickness && high < thickness)
        return Sides::front;
    return high > thickness && low > -thickness ? Sides::back : Sides::both;
}

/// A convex piece shows a quarter of its surface to each side: a sphere of the same surface.
void add_round(const std::vector<Sample>& samples, const std::string& name, std::vector<SceneLight>& lights) {
    glm::vec3 power{0.0f};
    glm::vec3 weighted{0.0f};
    float weight = 0.0f;
    float area = 0.0f;
    for (const Sample& sample : samples) {
        area += sample.area;
        power += sample.power;
        weighted += sum_of(sample.power) * sample.position;
        weight += sum_of(sample.power);
    }
    SceneLight lamp;
    lamp.shape = lightmesh::PointLight{.position = weighted / weight,
                                       .radius = std::sqrt(area / (4.0f * std::numbers::pi_v<float>))};
    lamp.intensity = power / (4.0f * std::numbers::pi_v<float>);
    lamp.name = name;
    lights.push_back(lamp);
}

/// Joins what touches.
class Pieces {
public:
    explicit Pieces(std::size_t count) : parent_(count) {
        std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    }
    std::size_t find(std::size_t i) {
        while (parent_[i] != i)
            i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::size_t a, std::size_t b) { parent_[find(a)] = find(b); }

private:
    std::vector<std::size_t> parent_;
};

struct PositionHash {
    std::size_t operator()(const glm::vec3& p) const {
        std::uint64_t hash = 14695981039346656037ULL;
        for (int axis = 0; axis < 3; ++axis) {
            const float value = p[axis] + 0.0f;  // -0 is 0
            std::uint32_t bits = 0;
            std::memcpy(&bits, &value, sizeof bits);
            hash = (hash ^ bits) * 1099511628211ULL;
        }
        return hash;
    }
};

/// The triangles of a mesh that shine, by pieces that touch.
std::vector<std::vector<std::size_t>> shining_pieces(const Scene& scene, TriangleRange mesh) {
    std::vector<std::size_t> shining;
    for (std::size_t t = mesh.first; t < mesh.last; ++t)
        if (shines(scene.materials[scene.triangles[t].material]))
            shining.push_back(t);
    Pieces pieces(shining.size());
    std::unordered_map<glm::vec3, std::size_t, PositionHash> owners;
    for (std::size_t i = 0; i < shining.size(); ++i)
        for (const glm::vec3& corner : corners(scene, shining[i]))
            pieces.join(i, owners.emplace(corner, i).first->second);
    std::map<std::size_t, std::vector<std::size_t>> sorted;
    for (std::size_t i = 0; i < shining.size(); ++i)
        sorted[pieces.find(i)].push_back(shining[i]);
    std::vector<std::vector<std::size_t>> result;
    for (auto& [root, triangles] : sorted)
        result.push_back(std::move(triangles));
    return result;
}

/// The solid angle of a triangle seen from a point, signed by its side (van Oosterom and Strackee, "The Solid
/// Angle of a Plane Triangle", 1983).
double solid_angle(const std::array<glm::vec3, 3>& triangle, glm::vec3 from) {
    const glm::dvec3 a = glm::dvec3(triangle[0]) - glm::dvec3(from);
    const glm::dvec3 b = glm::dvec3(triangle[1]) - glm::dvec3(from);
    const glm::dvec3 c = glm::dvec3(triangle[2]) - glm::dvec3(from);
    const double la = glm::length(a);
    const double lb = glm::length(b);
    const double lc = glm::length(c);
    const double volume = glm::dot(a, glm::cross(b, c));
    return 2.0 *
           std::atan2(volume, la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
}

std::optional<glm::vec3> position_of(const SceneLight& light) {
    if (const auto* lamp = std::get_if<lightmesh::PointLight>(&light.shape))
        return lamp->position;
    if (const auto* spot = std::get_if<lightmesh::SpotLight>(&light.shape))
        return spot->position;
    return std::nullopt;
}

/// A copy of a material through which shadow rays pass.
std::uint32_t open_copy(Scene& scene, std::uint32_t material,
                        std::map<std::uint32_t, std::uint32_t>& copies) {
    const auto [found, is_new] = copies.emplace(material, static_cast<std::uint32_t>(scene.materials.size()));
    if (is_new) {
        Material copy = scene.materials[material];
        copy.shadow = ShadowBy::nothing;
        scene.materials.push_back(std::move(copy));
    }
    return found->second;
}

}  // namespace

std::size_t add_emitter_lights(Scene& scene, std::span<const TriangleRange> meshes) {
    const float diagonal = diagonal_of(bounds_of(scene));
    std::vector<SceneLight> lights;
    std::size_t count = 0;
    for (const TriangleRange& mesh : meshes) {
        for (const std::vector<std::size_t>& piece : shining_pieces(scene, mesh)) {
            std::vector<Sample> samples;
            for (const std::size_t t : piece)
                add_samples(scene, t, samples);
            std::erase_if(samples, [](const Sample& s) { return !(sum_of(s.power) > 0.0f); });
            if (samples.empty())
                continue;
            ++count;
            const std::string& name = scene.materials[scene.triangles[piece.front()].material].name;
            if (const auto patches =
                    patches_of(samples, 0.01f * extent_of(samples).size() + 1e-6f * diagonal))
                for (const Patch& patch : *patches)
                    add_patch(scene, patch, sides_of(patch, samples), diagonal, name, lights);
            else
                add_round(samples, name, lights);
        }
    }
    std::ranges::stable_sort(lights, [](const SceneLight& a, const SceneLight& b) {
        return sum_of(a.intensity) > sum_of(b.intensity);
    });
    if (lights.size() > most_emitter_lights) {
        const auto total = [](std::span<const SceneLight> some) {
            double sum = 0.0;
            for (const SceneLight& light : some)
                sum += static_cast<double>(sum_of(light.intensity));
            return sum;
        };
        const double all = total(lights);
        lights.resize(most_emitter_lights);
        const auto factor = static_cast<float>(all / total(lights));
        for (SceneLight& light : lights)
            light.intensity *= factor;
    }
    scene.lights.insert(scene.lights.end(), lights.begin(), lights.end());
    return count;
}

void open_bulbs(Scene& scene, std::span<const TriangleRange> meshes) {
    std::map<std::uint32_t, std::uint32_t> copies;
    for (const TriangleRange& mesh : meshes) {
        for (const std::vector<std::size_t>& piece : shining_pieces(scene, mesh)) {
            const bool is_around_a_lamp = std::ranges::any_of(scene.lights, [&](const SceneLight& light) {
                const auto lamp = position_of(light);
                if (!lamp || light.facing != glm::vec3{0.0f})
                    return false;
                double seen = 0.0;
                for (const std::size_t t : piece)
                    seen += solid_angle(corners(scene, t), *lamp);
                return std::abs(seen) > 2.0 * std::numbers::pi;
            });
            if (is_around_a_lamp)
                for (const std::size_t t : piece)
                    scene.triangles[t].material = open_copy(scene, scene.triangles[t].material, copies);
        }
    }
}

}  // namespace demo
