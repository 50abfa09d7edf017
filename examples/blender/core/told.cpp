// SPDX-License-Identifier: MIT
#include "blender/core/session.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace demo {

namespace {

constexpr std::uint32_t none = (std::numeric_limits<std::uint32_t>::max)();

std::string named(const char* name) {
    return name == nullptr ? std::string("a thing without a name") : "'" + std::string(name) + "'";
}

bool is_finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Of length 0 where there is none: the triangle's own is taken then.
glm::vec3 normal_of(const float* normals, std::size_t number) {
    if (normals == nullptr)
        return glm::vec3(0.0f);
    const float* n = normals + 3 * number;
    const glm::vec3 normal{n[0], n[1], n[2]};
    return is_finite(normal) ? normal : glm::vec3(0.0f);
}

/// Makes one vertex of corners that are the same, in the order in which they come. Normals are the same by
/// what is told of them and not by their values, so that a mesh that bends keeps its vertices.
class Welder {
public:
    Welder(const LmMesh& mesh, ToldMesh& made) : mesh_(mesh), made_(made), first_(mesh.vertex_count, none) {
        made_.positions.reserve(mesh.vertex_count);
        made_.normals.reserve(mesh.vertex_count);
    }

    std::uint32_t vertex_at(std::size_t corner) {
        const auto place = static_cast<std::uint32_t>(mesh_.corners[corner]);
        const auto smoothing = smoothing_at(corner);
        const glm::vec2 uv = uv_at(corner);
        for (std::uint32_t v = first_[place]; v != none; v = next_[v])
            if (smoothing_[v] == smoothing && (mesh_.uvs == nullptr || made_.uvs[v] == uv))
                return v;
        const auto made = static_cast<std::uint32_t>(made_.positions.size());
        const float* p = mesh_.positions + 3 * std::size_t{place};
        made_.positions.emplace_back(p[0], p[1], p[2]);
        made_.normals.push_back(normal_at(corner));
        smoothing_.push_back(smoothing);
        if (mesh_.uvs != nullptr)
            made_.uvs.push_back(uv);
        next_.push_back(first_[place]);
        first_[place] = made;
        return made;
    }

private:
    glm::vec3 normal_at(std::size_t corner) const {
        return mesh_.normals != nullptr
                   ? normal_of(mesh_.normals, corner)
                   : normal_of(mesh_.vertex_normals, static_cast<std::size_t>(mesh_.corners[corner]));
    }
    std::int64_t smoothing_at(std::size_t corner) const {
        if (mesh_.normals == nullptr)
            return 0;
        return mesh_.smoothing != nullptr ? mesh_.smoothing[corner] : static_cast<std::int64_t>(corner);
    }
    glm::vec2 uv_at(std::size_t corner) const {
        if (mesh_.uvs == nullptr)
            return glm::vec2(0.0f);
        const glm::vec2 uv{mesh_.uvs[2 * corner], mesh_.uvs[2 * corner + 1]};
        return std::isfinite(uv.x) && std::isfinite(uv.y) ? uv : glm::vec2(0.0f);
    }

    const LmMesh& mesh_;
    ToldMesh& made_;
    std::vector<std::uint32_t> first_;  ///< made of each vertex that was told
    std::vector<std::uint32_t> next_;   ///< made of the same one
    std::vector<std::int64_t> smoothing_;
};

void require_finite(const LmLight& light, const char* what, const glm::vec3& value) {
    if (!is_finite(value))
        throw std::invalid_argument("the " + std::string(what) + " of light " + named(light.name) +
                                    " is not finite");
}

bool has_size(const LmLight& light) {
    return light.kind == LM_AREA || light.size > 0.0f;
}

}  // namespace

ToldMesh told_mesh(const LmMesh& mesh) {
    for (std::size_t i = 0; i < 3 * std::size_t{mesh.vertex_count}; ++i)
        if (!std::isfinite(mesh.positions[i]))
            throw std::invalid_argument("vertex " + std::to_string(i / 3) + " of mesh " + named(mesh.name) +
                                        " is not finite");
    ToldMesh made;
    Welder welder(mesh, made);
    // The vertices as they are, if all corners of each are the same.
    const bool is_welded = mesh.normals == nullptr && mesh.uvs == nullptr;
    for (std::size_t v = 0; is_welded && v < mesh.vertex_count; ++v) {
        made.positions.emplace_back(mesh.positions[3 * v], mesh.positions[3 * v + 1],
                                    mesh.positions[3 * v + 2]);
        made.normals.push_back(normal_of(mesh.vertex_normals, v));
    }
    made.triangles.reserve(mesh.triangle_count);
    for (std::size_t t = 0; t < mesh.triangle_count; ++t) {
        Triangle triangle{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int32_t vertex = mesh.corners[3 * t + k];
            if (vertex < 0 || static_cast<std::uint32_t>(vertex) >= mesh.vertex_count)
                throw std::out_of_range("triangle " + std::to_string(t) + " of mesh " + named(mesh.name) +
                                        " has vertex " + std::to_string(vertex) + " of " +
                                        std::to_string(mesh.vertex_count));
            triangle.vertex[k] = is_welded ? static_cast<std::uint32_t>(vertex) : welder.vertex_at(3 * t + k);
        }
        if (mesh.slots[t] < 0)
            throw std::out_of_range("triangle " + std::to_string(t) + " of mesh " + named(mesh.name) +
                                    " has material slot " + std::to_string(mesh.slots[t]));
        triangle.material = static_cast<std::uint32_t>(mesh.slots[t]);
        made.slot_count = (std::max)(made.slot_count, triangle.material + 1);
        made.triangles.push_back(triangle);
    }
    glm::vec3 farthest(0.0f);
    glm::vec3 low((std::numeric_limits<float>::max)());
    glm::vec3 high(-low);
    for (const glm::vec3& position : made.positions) {
        farthest = glm::max(farthest, glm::abs(position));
        low = glm::min(low, position);
        high = glm::max(high, position);
    }
    made.is_near_origin = !(glm::length(farthest) > 16.0f * glm::length(high - low));
    return made;
}

SceneLight told_light(const LmLight& light) {
    const glm::vec3 position = vector(light.position);
    const glm::vec3 axis = vector(light.axis);
    require_finite(light, "position", position);
    require_finite(light, "direction", axis);
    require_finite(light, "strength", vector(light.strength));
    if (!std::isfinite(light.size) || light.size < 0.0f)
        throw std::invalid_argument("the size of light " + named(light.name) + " is " +
                                    std::to_string(light.size));
    SceneLight made;
    made.name = light.name == nullptr ? "" : light.name;
    made.intensity = vector(light.strength);
    made.fall_off = FallOff::lamps;
    constexpr float infinity = std::numeric_limits<float>::infinity();
    switch (light.kind) {
    case LM_POINT:
        made.shape = lightmesh::PointLight{position, infinity, light.size};
        break;
    case LM_SUN:
        made.shape = lightmesh::DirectionalLight{axis, light.size};
        break;
    case LM_SPOT: {
        made.shape = lightmesh::SpotLight{position, axis, light.cone, infinity, light.size};
        const float outer = std::cos(light.cone);
        made.inner_cone =
            std::acos(glm::clamp(outer + (1.0f - outer) * glm::clamp(light.blend, 0.0f, 1.0f), -1.0f, 1.0f));
        break;
    }
    case LM_AREA:
        made.shape = lightmesh::RectLight{position, vector(light.half_u), vector(light.half_v)};
        break;
    default:
        throw std::invalid_argument("light " + named(light.name) + " is of kind " +
                                    std::to_string(light.kind));
    }
    return made;
}

LightGroup told_group(const LmLight& light, std::size_t memory_budget) {
    LightGroup group;
    VisibilityOptions& options = group.options;
    options.depth = DepthSource::embree;
    options.settings.memory_budget = options.cache.memory_budget = memory_budget;
    const auto number = [](float value) {
        std::uint32_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        return " " + std::to_string(bits);
    };
    switch (light.shadow) {
    case LM_REAL_LAMP:
        if (!has_size(light)) {
            group.algorithm = group.settings = "whitted";
            break;
        }
        group.algorithm = "cache";
        options.cache.spacing = light.spacing;
        options.cache.detail = light.detail;
        group.settings = "cache" + number(light.spacing) + " " + std::to_string(light.detail);
        break;
    case LM_MESH:
    case LM_MESH_ATK:
        group.algorithm = light.express != 0 ? "express" : "linked";
        options.settings.radius = light.radius;
        options.settings.quality = light.quality;
        if (light.shadow == LM_MESH_ATK) {
            group.algorithm += "+map";
            options.settings.shadow_map_size = light.map_size;
        }
        group.settings = group.algorithm + number(light.radius) + number(light.quality) + " " +
                         std::to_string(options.settings.shadow_map_size);
        break;
    case LM_HARD_RAYS:
        group.algorithm = group.settings = "whitted";
        break;
    default:
        throw std::invalid_argument("light " + named(light.name) + " has a shadow of kind " +
                                    std::to_string(light.shadow));
    }
    return group;
}

}  // namespace demo
