// SPDX-License-Identifier: MIT
#include "render/depth_renderers.hpp"
#include "render/illumination.hpp"
#include "render/scene_occluders.hpp"
#include "render/visibility.hpp"

#include <lightmesh/shadows/shadow_map.hpp>
#include <lightmesh/shadows/shadow_volume.hpp>

#include <glm/geometric.hpp>

#include <chrono>
#include <string>
#include <utility>

namespace demo {

namespace {

/// Hard shadows by a `Lookup` for each light, which knows whether it sees a point.
template <class Lookup>
class LookupVisibility final : public Visibility {
public:
    LookupVisibility(const EmbreeScene& scene, std::vector<std::unique_ptr<const Lookup>> lookups,
                     float offset)
        : lights_(scene.scene().lights), lookups_(std::move(lookups)), offset_(offset) {}

    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost& cost) const override {
        const auto start = std::chrono::steady_clock::now();
        for (std::size_t i = 0; i < points.positions.size(); ++i) {
            const glm::vec3 point = points.positions[i] + offset_ * points.normals[i];
            for (std::size_t l = 0; l < lights_.size(); ++l) {
                const Illumination light = illuminate(lights_[l], points.positions[i]);
                const bool faces = glm::dot(points.normals[i], light.to_light) >= 0.0f &&
                                   light.irradiance != glm::vec3(0.0f);
                lit[i * lights_.size() + l] = faces && lookups_[l]->visible(point) ? 1.0f : 0.0f;
            }
        }
        cost.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }

    std::size_t bytes() const override {
        std::size_t sum = 0;
        for (const auto& lookup : lookups_)
            sum += lookup->bytes();
        return sum;
    }

private:
    const std::vector<SceneLight>& lights_;
    std::vector<std::unique_ptr<const Lookup>> lookups_;
    float offset_;
};

template <class Renderer>
std::unique_ptr<Visibility> maps_by(Renderer renderer, const EmbreeScene& scene,
                                    const VisibilityOptions& options) {
    using Map = lightmesh::ShadowMap<Renderer>;
    const auto shared = std::make_shared<lightmesh::SharedDepthRenderer<Renderer>>(std::move(renderer));
    lightmesh::ShadowMapSettings settings;
    settings.resolution = options.settings.shadow_map_size;
    std::vector<std::unique_ptr<const Map>> maps;
    for (const SceneLight& light : scene.scene().lights)
        maps.push_back(std::make_unique<const Map>(shared, light.shape, settings,
                                                   "light " + std::to_string(maps.size())));
    return std::make_unique<LookupVisibility<Map>>(scene, std::move(maps), 0.0f);
}

}  // namespace

std::unique_ptr<Visibility> make_shadow_maps(const EmbreeScene& scene, const VisibilityOptions& options) {
    return with_depth_renderer(scene, options,
                               [&](auto renderer) { return maps_by(std::move(renderer), scene, options); });
}

std::unique_ptr<Visibility> make_shadow_volumes(const EmbreeScene& scene) {
    using lightmesh::ShadowVolumes;
    const auto triangles =
        std::make_shared<const lightmesh::OccluderTriangles>(SceneOccluders(scene.scene()));
    std::vector<std::unique_ptr<const ShadowVolumes>> volumes;
    for (const SceneLight& light : scene.scene().lights)
        volumes.push_back(std::make_unique<const ShadowVolumes>(triangles, light.shape));
    // A point as found by a ray may lie within rounding behind its own triangle.
    return std::make_unique<LookupVisibility<ShadowVolumes>>(scene, std::move(volumes), scene.offset());
}

}  // namespace demo
