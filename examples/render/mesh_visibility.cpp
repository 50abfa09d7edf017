// SPDX-License-Identifier: MIT
#include "adapters/embree_depth_renderer.hpp"
#include "adapters/vulkan_depth_renderer.hpp"
#include "render/depth_renderers.hpp"
#include "render/scene_occluders.hpp"
#include "render/visibility.hpp"

#include <lightmesh/lightmesh.hpp>

#include <chrono>
#include <cstddef>
#include <utility>
#include <vector>

namespace demo {

namespace {

template <class Mesh>
class MeshVisibility final : public Visibility {
public:
    explicit MeshVisibility(Mesh mesh) : mesh_(std::move(mesh)) {}

    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost& cost) const override {
        const auto start = std::chrono::steady_clock::now();
        lightmesh::QueryStatistics spent;
        mesh_.visibility(as_library_points(points), lit, &spent);
        cost.short_rays += spent.short_rays;
        cost.shadow_rays += spent.shadow_rays;
        cost.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }

    std::optional<lightmesh::MeshStatistics> mesh() const override { return mesh_.statistics(); }
    std::vector<std::byte> snapshot() const override { return mesh_.snapshot(); }

private:
    Mesh mesh_;
};

template <class Mesh>
std::unique_ptr<Visibility> visibility_of(Mesh mesh) {
    return std::make_unique<MeshVisibility<Mesh>>(std::move(mesh));
}

}  // namespace

std::unique_ptr<Visibility> make_light_mesh(const EmbreeScene& scene, const VisibilityOptions& options,
                                            lightmesh::LongTest long_test) {
    const std::vector<lightmesh::Light> lights = shapes_of_lights(scene.scene());
    lightmesh::Settings settings = options.settings;
    // The references that others are held against, as published, have no levels.
    if (settings.short_test == lightmesh::ShortTest::exact)
        settings.footprint_scale = 0.0f;
    switch (long_test) {
    case lightmesh::LongTest::shadow_maps:
    case lightmesh::LongTest::refined_shadow_maps:
        return with_depth_renderer(scene, options, [&](auto renderer) {
            return visibility_of(
                lightmesh::LightMesh{scene.intersector(), std::move(renderer), lights, settings});
        });
    case lightmesh::LongTest::shadow_volumes:
        return visibility_of(
            lightmesh::LightMesh{scene.intersector(), SceneOccluders(scene.scene()), lights, settings});
    case lightmesh::LongTest::rays:
        break;
    }
    lightmesh::LightMesh mesh{scene.intersector(), lights, settings};
    if (!options.known.empty())
        mesh.merge(options.known);
    return visibility_of(std::move(mesh));
}

}  // namespace demo
