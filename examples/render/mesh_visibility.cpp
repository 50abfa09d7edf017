// SPDX-License-Identifier: MIT
#include "adapters/embree_depth_renderer.hpp"
#include "adapters/vulkan_depth_renderer.hpp"
#include "render/depth_renderers.hpp"
#include "render/scene_occluders.hpp"
#include "render/visibility.hpp"

#include <lightmesh/lightmesh.hpp>

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace demo {

namespace {

/// Makes a mesh of the scene as it is.
template <class Mesh>
using MakeMesh = std::function<Mesh(const EmbreeScene& scene)>;

template <class Mesh>
class MeshVisibility final : public Visibility {
public:
    MeshVisibility(Mesh mesh, MakeMesh<Mesh> make) : mesh_(std::move(mesh)), make_(std::move(make)) {}

    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost& cost) const override {
        const auto start = std::chrono::steady_clock::now();
        lightmesh::QueryStatistics spent;
        mesh_.visibility(as_library_points(points), lit, &spent);
        cost.short_rays += spent.short_rays;
        cost.shadow_rays += spent.shadow_rays;
        cost.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }

    void update(const EmbreeScene& scene, const SceneChange& change) override {
        if (change.changes_shadows())
            mesh_ = make_(scene);
    }

    std::optional<lightmesh::MeshStatistics> mesh() const override { return mesh_.statistics(); }
    std::vector<std::byte> snapshot() const override { return mesh_.snapshot(); }

private:
    Mesh mesh_;
    MakeMesh<Mesh> make_;
};

/// `make` makes the mesh from the scene, now and whenever that is needed again.
template <class Make>
std::unique_ptr<MeshVisibility<std::invoke_result_t<Make, const EmbreeScene&>>>
visibility_by(const EmbreeScene& scene, Make make) {
    auto mesh = make(scene);
    return std::make_unique<MeshVisibility<decltype(mesh)>>(std::move(mesh), std::move(make));
}

}  // namespace

std::unique_ptr<Visibility> make_light_mesh(const EmbreeScene& scene, const VisibilityOptions& options,
                                            lightmesh::LongTest long_test) {
    lightmesh::Settings settings = options.settings;
    // The references that others are held against, as published, have no levels.
    if (settings.short_test == lightmesh::ShortTest::exact)
        settings.footprint_scale = 0.0f;
    switch (long_test) {
    case lightmesh::LongTest::shadow_maps:
    case lightmesh::LongTest::refined_shadow_maps:
        return with_depth_renderer(scene, options, [&](auto first) -> std::unique_ptr<Visibility> {
            using Renderer = decltype(first);
            const auto make = [options, settings](const EmbreeScene& now) {
                return lightmesh::LightMesh{now.intersector(), make_depth_renderer<Renderer>(now, options),
                                            shapes_of_lights(now.scene()), settings};
            };
            using Mesh = decltype(make(scene));
            return std::make_unique<MeshVisibility<Mesh>>(
                Mesh{scene.intersector(), std::move(first), shapes_of_lights(scene.scene()), settings}, make);
        });
    case lightmesh::LongTest::shadow_volumes:
        return visibility_by(scene, [settings](const EmbreeScene& now) {
            return lightmesh::LightMesh{now.intersector(), SceneOccluders(now.scene()),
                                        shapes_of_lights(now.scene()), settings};
        });
    case lightmesh::LongTest::rays:
        break;
    }
    const auto make = [settings](const EmbreeScene& now) {
        return lightmesh::LightMesh{now.intersector(), shapes_of_lights(now.scene()), settings};
    };
    auto mesh = make(scene);
    if (!options.known.empty())
        mesh.merge(options.known);
    return std::make_unique<MeshVisibility<decltype(mesh)>>(std::move(mesh), make);
}

}  // namespace demo
