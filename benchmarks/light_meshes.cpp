// SPDX-License-Identifier: MIT
#include "contestant.hpp"

#include <lightmesh/lightmesh.hpp>

#include <stdexcept>

namespace bench {

namespace {

using Mesh = lightmesh::LightMesh<demo::EmbreeIntersector>;

class LightMeshes final : public Contestant {
public:
    LightMeshes(std::shared_ptr<const Mesh> mesh, Query query) : mesh_(std::move(mesh)), query_(query) {}

    void find(const Points& points, std::span<float> lit) const override { find(points, lit, nullptr); }

    std::uint64_t rays(const Points& points) const override {
        std::vector<float> lit(points.size() * mesh_->light_count());
        find(points, lit, nullptr);
        lightmesh::QueryStatistics statistics;
        find(points, lit, &statistics);
        return statistics.short_rays + statistics.shadow_rays;
    }

    std::uint64_t cached_rays() const override { return mesh_->statistics().kept_rays(); }
    std::size_t light_points() const override { return mesh_->statistics().light_points; }
    std::size_t bytes() const override { return mesh_->statistics().bytes; }

    const std::shared_ptr<const Mesh>& mesh() const { return mesh_; }

private:
    void find(const Points& points, std::span<float> lit, lightmesh::QueryStatistics* statistics) const {
        if (query_ == Query::tile)
            return mesh_->visibility(points.positions, points.normals, lit, statistics);
        const std::size_t row = mesh_->light_count();
        for (std::size_t i = 0; i < points.size(); ++i)
            mesh_->visibility(points.positions[i], points.normals[i], lit.subspan(i * row, row), statistics);
    }

    std::shared_ptr<const Mesh> mesh_;
    Query query_;
};

}  // namespace

std::unique_ptr<Contestant> make_light_mesh(const Workload& workload, float quality,
                                            lightmesh::ShortTest short_test, Query query) {
    std::vector<lightmesh::Light> lights;
    for (const glm::vec3& position : workload.lights)
        lights.emplace_back(lightmesh::PointLight{.position = position});
    const lightmesh::Settings settings{
        .radius = workload.radius, .quality = quality, .short_test = short_test};
    auto mesh = std::make_shared<const Mesh>(workload.scene.intersector(), lights, settings);
    return std::make_unique<LightMeshes>(std::move(mesh), query);
}

std::unique_ptr<Contestant> share_light_mesh(const Contestant& mesh, Query query) {
    return std::make_unique<LightMeshes>(dynamic_cast<const LightMeshes&>(mesh).mesh(), query);
}

}  // namespace bench
