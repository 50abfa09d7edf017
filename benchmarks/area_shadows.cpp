// SPDX-License-Identifier: MIT
#include "contestant.hpp"
#include "embree_rays.hpp"
#include "scene/random.hpp"
#include "surface_end.hpp"

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <array>
#include <cmath>
#include <stdexcept>

namespace bench {

namespace {

constexpr std::size_t samples = 16;
using Pattern = std::array<glm::vec2, samples>;

/// Patterns on the unit disc, of 4 rings of equal area by 4 turns with a random place in each. Made before,
/// as a renderer that is in a hurry would.
const std::array<Pattern, 64>& patterns() {
    static const std::array<Pattern, 64> all = [] {
        std::array<Pattern, 64> made;
        demo::Random random(1);
        for (Pattern& pattern : made) {
            for (std::size_t s = 0; s < samples; ++s) {
                const float radius = std::sqrt((static_cast<float>(s / 4) + random.uniform()) / 4.0f);
                const float turn = (static_cast<float>(s % 4) + random.uniform()) / 4.0f;
                pattern[s] = radius * demo::circle_point(turn);
            }
        }
        return made;
    }();
    return all;
}

/// A round lamp that faces a point.
class Disc {
public:
    Disc(const glm::vec3& light, const glm::vec3& point, float size) : light_(light) {
        const glm::vec3 axis = glm::normalize(light - point);
        const glm::vec3 other = std::abs(axis.z) < 0.9f ? glm::vec3(0, 0, 1) : glm::vec3(1, 0, 0);
        right_ = size * glm::normalize(glm::cross(axis, other));
        up_ = glm::cross(right_, axis);
    }

    glm::vec3 at(const glm::vec2& place) const { return light_ + place.x * right_ + place.y * up_; }

private:
    glm::vec3 light_, right_, up_;
};

class AreaShadows : public Contestant {
public:
    explicit AreaShadows(const Workload& workload) : workload_(workload) {}

    void find(const Points& points, std::span<float> lit) const override {
        Occlusion occlusion(workload_.scene.handle(), false);
        const std::vector<glm::vec3>& lights = workload_.lights;
        std::size_t turn = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const glm::vec3 origin = surface_end(points.positions[i], points.normals[i]);
            for (std::size_t l = 0; l < lights.size(); ++l) {
                float& value = lit[i * lights.size() + l];
                value = 0.0f;
                if (!workload_.faces(l, points.positions[i], points.normals[i]))
                    continue;
                const Pattern& pattern = patterns()[turn++ % patterns().size()];
                const Disc disc(lights[l], origin, 0.1f * workload_.radius);
                value = static_cast<float>(count_open(occlusion, origin, disc, pattern)) / samples;
            }
        }
    }

    std::uint64_t rays(const Points& points) const override {
        return samples * make_hard_shadows(workload_, "single")->rays(points);
    }

protected:
    virtual int count_open(Occlusion& occlusion, const glm::vec3& origin, const Disc& disc,
                           const Pattern& pattern) const = 0;

private:
    const Workload& workload_;
};

class SingleRays final : public AreaShadows {
public:
    using AreaShadows::AreaShadows;

protected:
    int count_open(Occlusion& occlusion, const glm::vec3& origin, const Disc& disc,
                   const Pattern& pattern) const override {
        int open = 0;
        for (const glm::vec2& place : pattern) {
            RTCRay ray = make_ray(origin, disc.at(place));
            occlusion.trace(ray);
            open += ray.tfar < 0.0f ? 0 : 1;
        }
        return open;
    }
};

class Packets final : public AreaShadows {
public:
    using AreaShadows::AreaShadows;

protected:
    int count_open(Occlusion& occlusion, const glm::vec3& origin, const Disc& disc,
                   const Pattern& pattern) const override {
        alignas(64) RTCRay16 rays;
        alignas(64) std::array<int, samples> valid;
        valid.fill(-1);
        for (std::size_t s = 0; s < samples; ++s)
            set_ray(rays, s, origin, disc.at(pattern[s]));
        occlusion.trace(valid.data(), rays);
        int open = 0;
        for (const float end : rays.tfar)
            open += end < 0.0f ? 0 : 1;
        return open;
    }
};

}  // namespace

const std::vector<std::string>& area_forms() {
    static const std::vector<std::string> names{"single", "packet16"};
    return names;
}

std::unique_ptr<Contestant> make_area_shadows(const Workload& workload, const std::string& form) {
    if (form == "single")
        return std::make_unique<SingleRays>(workload);
    if (form == "packet16")
        return std::make_unique<Packets>(workload);
    throw std::invalid_argument("there is no form '" + form + "' of area light rays");
}

}  // namespace bench
