// SPDX-License-Identifier: MIT
#include "render/depth_renderers.hpp"
#include "render/illumination.hpp"
#include "render/scene_occluders.hpp"
#include "render/stopwatch.hpp"
#include "render/visibility.hpp"

#include <lightmesh/shadows/shadow_map.hpp>
#include <lightmesh/shadows/shadow_volume.hpp>

#include <glm/geometric.hpp>

#include <cstddef>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace demo {

namespace {

/// Makes the look-up for a light, by its number.
template <class Lookup>
using MakeLookup = std::function<std::unique_ptr<const Lookup>(std::size_t light)>;

/// Hard shadows by a `Lookup` for each light, which knows whether it sees a point.
template <class Lookup>
class LookupVisibility final : public Visibility {
public:
    /// Takes the triangles as they are.
    using Open = std::function<MakeLookup<Lookup>(const EmbreeScene& scene)>;

    /// Makes by `first` until triangles move. Points are asked for `offsets` times the scene's offset above
    /// their surface.
    LookupVisibility(const EmbreeScene& scene, MakeLookup<Lookup> first, Open open, float offsets)
        : scene_(scene), open_(std::move(open)), make_(std::move(first)), offsets_(offsets) {
        make_all();
    }

    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost& cost) const override {
        const Stopwatch watch;
        const std::vector<SceneLight>& lights = scene_.scene().lights;
        const float offset = offsets_ * scene_.offset();
        for (std::size_t i = 0; i < points.points.size(); ++i) {
            const lightmesh::SurfacePoint& at = points.points[i];
            const glm::vec3 lifted = at.position + offset * at.normal;
            for (std::size_t l = 0; l < lights.size(); ++l) {
                const Illumination light = illuminate(lights[l], at.position);
                const bool faces =
                    glm::dot(at.normal, light.to_light) >= 0.0f && light.irradiance != glm::vec3(0.0f);
                lit[i * lights.size() + l] = faces && lookups_[l]->visible(lifted) ? 1.0f : 0.0f;
            }
        }
        cost.seconds += watch.seconds();
    }

    void update(const EmbreeScene& scene, const SceneChange& change) override {
        if (change.changes_triangles()) {
            lookups_.clear();
            make_ = open_(scene);
            make_all();
            return;
        }
        for (const std::size_t light : change.lights)
            lookups_[light] = make_(light);
    }

    std::size_t bytes() const override {
        std::size_t sum = 0;
        for (const auto& lookup : lookups_)
            sum += lookup->bytes();
        return sum;
    }

private:
    void make_all() {
        for (std::size_t light = 0; light < scene_.scene().lights.size(); ++light)
            lookups_.push_back(make_(light));
    }

    const EmbreeScene& scene_;
    Open open_;
    MakeLookup<Lookup> make_;
    std::vector<std::unique_ptr<const Lookup>> lookups_;
    float offsets_;
};

}  // namespace

std::unique_ptr<Visibility> make_shadow_maps(const EmbreeScene& scene, const VisibilityOptions& options) {
    return with_depth_renderer(scene, options, [&](auto first) -> std::unique_ptr<Visibility> {
        using Renderer = decltype(first);
        const auto open = [options](const EmbreeScene& now) {
            return maps_by(make_depth_renderer<Renderer>(now, options), now, options);
        };
        return std::make_unique<LookupVisibility<lightmesh::ShadowMap<Renderer>>>(
            scene, maps_by(std::move(first), scene, options), open, 0.0f);
    });
}

std::unique_ptr<Visibility> make_shadow_volumes(const EmbreeScene& scene) {
    using lightmesh::ShadowVolumes;
    const auto open = [](const EmbreeScene& now) {
        const auto triangles =
            std::make_shared<const lightmesh::OccluderTriangles>(SceneOccluders(now.scene()));
        return [triangles, &lights = now.scene().lights](std::size_t light) {
            return std::make_unique<const ShadowVolumes>(triangles, lights[light].shape);
        };
    };
    // A point as found by a ray may lie within rounding behind its own triangle.
    return std::make_unique<LookupVisibility<ShadowVolumes>>(scene, open(scene), open, 1.0f);
}

}  // namespace demo
