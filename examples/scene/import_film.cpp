// SPDX-License-Identifier: MIT
#include "animation.hpp"
#include "import_pose.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace demo {
namespace {

namespace fs = std::filesystem;

using Corners = std::array<glm::dvec3, 3>;

Corners corners_of(const Scene& scene, std::size_t triangle) {
    const auto& vertex = scene.triangles[triangle].vertex;
    return {scene.positions[vertex[0]], scene.positions[vertex[1]], scene.positions[vertex[2]]};
}

double distance_to_side(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 side = b - a;
    const double squared = glm::dot(side, side);
    const double share = squared > 0.0 ? glm::clamp(glm::dot(p - a, side) / squared, 0.0, 1.0) : 0.0;
    return glm::length(p - a - share * side);
}

double distance_to(const Corners& c, const glm::dvec3& p) {
    const glm::dvec3 normal = glm::cross(c[1] - c[0], c[2] - c[0]);
    const double size = glm::length(normal);
    double least = std::numeric_limits<double>::infinity();
    bool is_above = size > 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec3& a = c[i];
        const glm::dvec3& b = c[(i + 1) % 3];
        least = (std::min)(least, distance_to_side(p, a, b));
        is_above = is_above && glm::dot(glm::cross(b - a, p - a), normal) >= 0.0;
    }
    return is_above ? std::abs(glm::dot(p - c[0], normal)) / size : least;
}

/// Axes of unit length that turn with a triangle; the world's for one without area.
glm::dmat3 axes_of(const Corners& c) {
    const glm::dvec3 normal = glm::cross(c[1] - c[0], c[2] - c[0]);
    if (!(glm::length(normal) > 0.0))
        return glm::dmat3(1.0);
    const glm::dvec3 along = glm::normalize(c[1] - c[0]);
    return {along, glm::cross(glm::normalize(normal), along), glm::normalize(normal)};
}

/// A light that belongs to a surface that shines, with a triangle of it.
struct Carried {
    std::size_t light;
    std::size_t triangle;
    SceneLight first;  ///< at 0 s, as the corners
    Corners corners;
};

glm::dvec3 place_of(const lightmesh::Light& light) {
    return std::visit(
        [](const auto& kind) -> glm::dvec3 {
            if constexpr (std::is_same_v<std::remove_cvref_t<decltype(kind)>, lightmesh::DirectionalLight>)
                return glm::dvec3(0.0);
            else
                return kind.position;
        },
        light);
}

/// The light where its triangle has gone.
SceneLight carried_to(const Carried& from, const Corners& to) {
    const glm::dmat3 turn = axes_of(to) * glm::transpose(axes_of(from.corners));
    const auto turned = [&](const glm::vec3& v) {
        return glm::vec3(turn * glm::dvec3(v));
    };
    SceneLight light = from.first;
    light.facing = turned(light.facing);
    std::visit(
        [&](auto& kind) {
            using Kind = std::remove_cvref_t<decltype(kind)>;
            if constexpr (!std::is_same_v<Kind, lightmesh::DirectionalLight>)
                kind.position = glm::vec3(to[0] + turn * (glm::dvec3(kind.position) - from.corners[0]));
            if constexpr (std::is_same_v<Kind, lightmesh::RectLight>) {
                kind.half_u = turned(kind.half_u);
                kind.half_v = turned(kind.half_v);
            }
        },
        light.shape);
    return light;
}

class FileAnimation final : public Animation {
public:
    FileAnimation(fs::path file, ImportOptions options, const FilmOfFile& film, const Scene& first)
        : file_(std::move(file)), options_(std::move(options)), film_(film) {
        if (first.has_own_lights)
            for (std::size_t light = film.lamps; light < first.lights.size(); ++light)
                carry(first, light);
    }

    double length() const override { return film_.length; }

    void pose(Scene& scene, double seconds, const Moving& moving) const override {
        ImportOptions options = options_;
        options.time = seconds;
        FilmOfFile film = film_;
        Scene posed = import_pose(file_, options, film);
        if (posed.positions.size() != scene.positions.size() ||
            posed.triangles.size() != scene.triangles.size() || posed.lights.size() != film_.lamps) {
            char time[32];
            std::snprintf(time, sizeof time, "%.6g", seconds);
            throw std::runtime_error(file_.string() + ": has other meshes or lights at " + time +
                                     " s than at 0 s");
        }
        if (moving.lights)
            pose_lights(scene, posed);
        if (moving.objects) {
            scene.positions = std::move(posed.positions);
            scene.normals = std::move(posed.normals);
        }
        if (moving.camera && scene.has_own_camera)
            scene.camera = posed.camera;
    }

private:
    /// Finds the triangle that a light belongs to: the one of those that shine that is closest to it.
    void carry(const Scene& scene, std::size_t light) {
        const glm::dvec3 place = place_of(scene.lights[light].shape);
        double least = std::numeric_limits<double>::infinity();
        std::size_t closest = 0;
        for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
            const Material& material = scene.materials[scene.triangles[t].material];
            if (material.emission == glm::vec3(0.0f) || material.is_unlit)
                continue;
            const double distance = distance_to(corners_of(scene, t), place);
            if (distance < least) {
                least = distance;
                closest = t;
            }
        }
        if (least < std::numeric_limits<double>::infinity())
            carried_.push_back({light, closest, scene.lights[light], corners_of(scene, closest)});
    }

    void pose_lights(Scene& scene, const Scene& posed) const {
        for (std::size_t i = 0; i < film_.lamps && i < scene.lights.size(); ++i)
            scene.lights[i].shape = posed.lights[i].shape;
        for (const Carried& carried : carried_) {
            const Corners now = corners_of(posed, carried.triangle);
            SceneLight& light = scene.lights[carried.light];
            const SceneLight there = now == carried.corners ? carried.first : carried_to(carried, now);
            light.shape = there.shape;
            light.facing = there.facing;
        }
    }

    fs::path file_;
    ImportOptions options_;
    FilmOfFile film_;
    std::vector<Carried> carried_;
};

}  // namespace

AnimatedScene import_animated(const fs::path& file, const ImportOptions& options) {
    ImportOptions first = options;
    first.time = 0.0;
    FilmOfFile film;
    Scene scene = import_pose(file, first, film);
    if (!(film.length > 0.0))
        throw std::runtime_error(file.string() + ": has no animation; films are of glTF files that have one");
    for (std::string& remark : scene.remarks)
        if (const std::size_t at = remark.find(" is drawn at 0 s"); at != std::string::npos)
            remark.replace(at, std::string(" is drawn at 0 s").size(), " is filmed");
    auto animation = std::make_shared<const FileAnimation>(file, options, film, scene);
    return {std::move(scene), std::move(animation)};
}

}  // namespace demo
