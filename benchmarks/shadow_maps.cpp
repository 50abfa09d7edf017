// SPDX-License-Identifier: MIT
#include "adapters/embree_depth_renderer.hpp"
#include "contestant.hpp"

#include <lightmesh/shadows/shadow_map.hpp>

#include <memory>

namespace bench {

namespace {

class ShadowMaps final : public Contestant {
public:
    using Map = lightmesh::ShadowMap<demo::EmbreeDepthRenderer>;

    explicit ShadowMaps(const Workload& workload) : workload_(workload) {
        lightmesh::ShadowMapSettings settings;
        settings.resolution = shadow_map_side;
        const auto renderer =
            std::make_shared<Map::Shared>(demo::EmbreeDepthRenderer(workload.scene.handle()));
        for (const glm::vec3& light : workload.lights)
            maps_.push_back(
                std::make_unique<Map>(renderer, lightmesh::PointLight{.position = light}, settings));
    }

    void find(const Points& points, std::span<float> lit) const override {
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (std::size_t l = 0; l < maps_.size(); ++l) {
                const bool faces = workload_.faces(l, points.positions[i], points.normals[i]);
                lit[i * maps_.size() + l] =
                    faces ? maps_[l]->visibility(points.positions[i], shadow_map_filter) : 0.0f;
            }
        }
    }

    std::uint64_t rays(const Points&) const override { return 0; }

    std::size_t bytes() const override {
        std::size_t sum = 0;
        for (const auto& map : maps_)
            sum += map->bytes();
        return sum;
    }

private:
    const Workload& workload_;
    std::vector<std::unique_ptr<Map>> maps_;
};

}  // namespace

std::unique_ptr<Contestant> make_shadow_maps(const Workload& workload) {
    return std::make_unique<ShadowMaps>(workload);
}

}  // namespace bench
