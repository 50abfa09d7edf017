// SPDX-License-Identifier: MIT
#include "adapters/embree_depth_renderer.hpp"
#include "adapters/vulkan_depth_renderer.hpp"
#include "render/depth_renderers.hpp"
#include "render/follow_scene.hpp"
#include "render/scene_occluders.hpp"
#include "render/stopwatch.hpp"
#include "render/visibility.hpp"

#include <lightmesh/lightmesh.hpp>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace demo {

namespace {

using LightNumbers = std::optional<std::vector<std::size_t>>;

/// The making of a mesh, and what it cannot be told.
template <class Mesh>
struct MeshSource {
    std::function<Mesh(const EmbreeScene& scene)> make;  ///< of the scene as it is
    /// The lights of the scene as it is that the mesh has.
    std::function<std::vector<lightmesh::Light>(const EmbreeScene& scene)> lights;
    std::shared_ptr<LightNumbers> numbers;  ///< that `make` and `lights` look at
    /// Brings what finds the mesh's long tests to where the triangles are; false if it cannot.
    std::function<bool(const EmbreeScene& scene)> follow = [](const EmbreeScene&) {
        return true;
    };
};

auto lights_source(const std::shared_ptr<LightNumbers>& numbers) {
    return [numbers](const EmbreeScene& now) {
        return shapes_of_lights(now.scene(), *numbers);
    };
}

template <class Mesh>
class MeshVisibility final : public Visibility {
public:
    MeshVisibility(Mesh mesh, MeshSource<Mesh> source) : mesh_(std::move(mesh)), source_(std::move(source)) {}

    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost& cost) const override {
        const Stopwatch watch;
        lightmesh::QueryStatistics statistics;
        mesh_.visibility(points.points, lit, &statistics);
        cost.short_rays += statistics.short_rays;
        cost.shadow_rays += statistics.shadow_rays;
        cost.seconds += watch.seconds();
    }

    void update(const EmbreeScene& scene, const SceneChange& change) override {
        if (change.changes_triangles() && !source_.follow(scene))
            mesh_ = source_.make(scene);
        else
            follow_scene(mesh_, source_.lights(scene), change);
    }
    bool set_lights(const std::vector<std::size_t>& numbers) override {
        *source_.numbers = numbers;
        return true;
    }
    void begin_frame() override { mesh_.begin_frame(); }
    void compact() override { mesh_.compact(); }

    std::optional<lightmesh::MeshStatistics> mesh() const override { return mesh_.statistics(); }
    std::vector<std::byte> snapshot() const override { return mesh_.snapshot(); }
    void merge(std::span<const std::byte> known) override { mesh_.merge(known); }

private:
    Mesh mesh_;
    MeshSource<Mesh> source_;
};

/// By shadow maps of renderers that are made by `make_depth_renderer`; `first` is one.
template <class Renderer>
std::unique_ptr<Visibility> mesh_by_maps(Renderer first, const EmbreeScene& scene,
                                         const VisibilityOptions& options,
                                         const lightmesh::Settings& settings) {
    using Mesh = lightmesh::LightMesh<EmbreeIntersector, Renderer>;
    const auto numbers = std::make_shared<LightNumbers>(options.lights);
    const auto lights = lights_source(numbers);
    const auto make = [by = options.depth, device = options.device, lights,
                       settings](const EmbreeScene& now) {
        VisibilityOptions again;
        again.depth = by;
        again.device = device;
        return Mesh{now.intersector(), make_depth_renderer<Renderer>(now, again), lights(now), settings};
    };
    // Embree's scene is shared, as long as it is the same, while Vulkan has a copy of the triangles.
    const auto follow = [blockers = scene.blockers()](const EmbreeScene& now) mutable {
        return std::is_same_v<Renderer, EmbreeDepthRenderer> &&
               std::exchange(blockers, now.blockers()) == now.blockers();
    };
    return std::make_unique<MeshVisibility<Mesh>>(
        Mesh{scene.intersector(), std::move(first), lights(scene), settings},
        MeshSource<Mesh>{make, lights, numbers, follow});
}

std::unique_ptr<Visibility> mesh_by_volumes(const EmbreeScene& scene, const VisibilityOptions& options,
                                            const lightmesh::Settings& settings) {
    using Mesh = lightmesh::LightMesh<EmbreeIntersector, SceneOccluders>;
    SceneOccluders occluders(scene.scene());
    const auto numbers = std::make_shared<LightNumbers>(options.lights);
    const auto lights = lights_source(numbers);
    const auto make = [occluders, lights, settings](const EmbreeScene& now) {
        return Mesh{now.intersector(), occluders, lights(now), settings};
    };
    const auto follow = [occluders](const EmbreeScene&) mutable {
        occluders.update();
        return true;
    };
    return std::make_unique<MeshVisibility<Mesh>>(make(scene),
                                                  MeshSource<Mesh>{make, lights, numbers, follow});
}

}  // namespace

std::unique_ptr<Visibility> make_light_mesh(const EmbreeScene& scene, const VisibilityOptions& options,
                                            lightmesh::LongTest long_test) {
    const lightmesh::Settings settings = mesh_settings_of(options);
    switch (long_test) {
    case lightmesh::LongTest::shadow_maps:
    case lightmesh::LongTest::refined_shadow_maps:
        return with_depth_renderer(scene, options, [&](auto renderer) {
            return mesh_by_maps(std::move(renderer), scene, options, settings);
        });
    case lightmesh::LongTest::shadow_volumes:
        return mesh_by_volumes(scene, options, settings);
    case lightmesh::LongTest::rays:
        break;
    }
    using Mesh = lightmesh::LightMesh<EmbreeIntersector>;
    const auto numbers = std::make_shared<LightNumbers>(options.lights);
    const auto lights = lights_source(numbers);
    const auto make = [lights, settings](const EmbreeScene& now) {
        return Mesh{now.intersector(), lights(now), settings};
    };
    Mesh mesh = make(scene);
    if (!options.known.empty())
        mesh.merge(options.known);
    return std::make_unique<MeshVisibility<Mesh>>(std::move(mesh), MeshSource<Mesh>{make, lights, numbers});
}

}  // namespace demo
