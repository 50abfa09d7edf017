// SPDX-License-Identifier: MIT
#include "gpu/mesh_shadows.hpp"

#include "gpu/ask_host.hpp"
#include "gpu/listing.hpp"
#include "gpu/long_tests.hpp"
#include "gpu/uploaded.hpp"
#include "render/follow_scene.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/lightmesh.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace demo {

namespace {

/// Points that shaders can ask for at once.
constexpr std::size_t request_capacity = std::size_t{1} << 16;

/// The mesh that shaders have a copy of.
class HostMesh {
public:
    virtual ~HostMesh() = default;

    /// Finds what shaders lack at points, of which `uploaded` is the copy.
    virtual void fill(std::span<const lightmesh::SurfacePoint> points, const UploadedMesh& uploaded,
                      const std::atomic<bool>* cancel) = 0;
    /// As of `MeshShadows`. Then it knows what its snapshots know: they have the lights in the order of a new
    /// mesh, and know them by whole groups. Where the mesh knew more, it would find nothing to fill for a
    /// point that lacks something in a shader.
    virtual void update(const EmbreeScene& scene, const SceneChange& change) = 0;
    virtual std::vector<std::byte> snapshot() const = 0;
    virtual lightmesh::MeshStatistics statistics() const = 0;
    /// By shaders.
    virtual DeviceFill spent() const { return {}; }
};

/// Links by the host, long rays by shaders.
class MeshByRays final : public HostMesh {
public:
    MeshByRays(const ComputeDevice& device, const EmbreeScene& scene, const GpuScene& copy,
               const VisibilityOptions& options)
        : mesh_(scene.intersector(), shapes_of_lights(scene.scene()), options.settings),
          long_tests_(device, copy) {
        if (!options.known.empty())
            mesh_.merge(options.known);
    }

    void fill(std::span<const lightmesh::SurfacePoint> points, const UploadedMesh& uploaded,
              const std::atomic<bool>* cancel) override {
        const auto missing = list_on_all_threads<lightmesh::LongTestList>(
            points, [&](auto some, auto& list) { mesh_.list_long_tests(some, list); });
        long_tests_.bind(uploaded.bindings(LongTests::set));
        mesh_.fill(missing, [&](auto words, auto seen) { long_tests_(words, seen, cancel); });
    }

    void update(const EmbreeScene& scene, const SceneChange& change) override {
        follow_scene(mesh_, shapes_of_lights(scene.scene()), change);
        mesh_.compact();
    }

    std::vector<std::byte> snapshot() const override { return mesh_.snapshot(); }
    lightmesh::MeshStatistics statistics() const override { return mesh_.statistics(); }
    DeviceFill spent() const override { return long_tests_.spent(); }

private:
    lightmesh::LightMesh<EmbreeIntersector> mesh_;
    LongTests long_tests_;
};

/// All by the host: a mesh with long tests by shadow maps, which a Vulkan device may render, or by shadow
/// volumes.
class MeshByHost final : public HostMesh {
public:
    MeshByHost(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& options)
        : shadows_(make_visibility(algorithm, scene, options)), light_count_(scene.scene().lights.size()) {}

    void fill(std::span<const lightmesh::SurfacePoint> points, const UploadedMesh&,
              const std::atomic<bool>* cancel) override {
        ask_host(*shadows_, light_count_, points, cancel, [](std::size_t, std::span<const float>) {});
    }

    void update(const EmbreeScene& scene, const SceneChange& change) override {
        light_count_ = scene.scene().lights.size();
        shadows_->update(scene, change);
        shadows_->compact();
    }

    std::vector<std::byte> snapshot() const override { return shadows_->snapshot(); }
    lightmesh::MeshStatistics statistics() const override { return shadows_->mesh().value(); }

private:
    std::unique_ptr<Visibility> shadows_;
    std::size_t light_count_;
};

/// Whether an algorithm's long tests are rays.
bool is_by_rays(const std::string& algorithm) {
    return algorithm.find('+') == std::string::npos;
}

}  // namespace

struct MeshShadows::Parts {
    Parts(const ComputeDevice& device, const std::string& algorithm, const EmbreeScene& scene,
          const GpuScene& copy, const VisibilityOptions& options)
        : mesh(mesh_of(device, algorithm, scene, copy, options)), uploaded(device, mesh->snapshot()),
          no_requests(lightmesh::empty_requests(request_capacity)), requests(device, no_requests) {}

    static std::unique_ptr<HostMesh> mesh_of(const ComputeDevice& device, const std::string& algorithm,
                                             const EmbreeScene& scene, const GpuScene& copy,
                                             const VisibilityOptions& options) {
        if (is_by_rays(algorithm))
            return std::make_unique<MeshByRays>(device, scene, copy, options);
        return std::make_unique<MeshByHost>(algorithm, scene, options);
    }

    void fill(std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel) {
        mesh->fill(points, uploaded, cancel);
        uploaded.update(mesh->snapshot());
    }

    std::unique_ptr<HostMesh> mesh;
    UploadedMesh uploaded;
    std::vector<std::byte> no_requests;
    ComputeBuffer requests;
    std::vector<std::array<float, 7>> asked_before;  ///< positions, normals and footprints, sorted
};

MeshShadows::MeshShadows(const ComputeDevice& device, const std::string& algorithm, const EmbreeScene& scene,
                         const GpuScene& copy, const VisibilityOptions& options)
    : parts_(std::make_unique<Parts>(device, algorithm, scene, copy, options)) {}

MeshShadows::~MeshShadows() = default;

void MeshShadows::update(const EmbreeScene& scene, const SceneChange& change) {
    parts_->asked_before.clear();
    if (!change.changes_shadows())
        return;
    parts_->mesh->update(scene, change);
    parts_->uploaded.update(parts_->mesh->snapshot());
}

std::vector<ComputeBinding> MeshShadows::bindings() const {
    std::vector<ComputeBinding> made = parts_->uploaded.bindings(set);
    made.push_back(
        {.set = set, .binding = lightmesh::MeshUpload::requests_binding, .buffer = parts_->requests});
    return made;
}

void MeshShadows::bind(const ComputeKernel& kernel) const {
    for (const ComputeBinding& binding : bindings())
        kernel.bind(binding);
    parts_->requests.write(0, parts_->no_requests);
}

MeshShadows::Asked MeshShadows::fill(const std::atomic<bool>* cancel) {
    const lightmesh::UploadRequests asked = lightmesh::read_requests(parts_->requests.read_all<std::byte>());
    if (asked.points.empty() && !asked.overflowed) {
        parts_->asked_before.clear();
        return Asked::nothing;
    }
    std::vector<std::array<float, 7>> sorted;
    for (const lightmesh::SurfacePoint& point : asked.points)
        sorted.push_back({point.position.x, point.position.y, point.position.z, point.normal.x,
                          point.normal.y, point.normal.z, point.footprint});
    std::ranges::sort(sorted);
    if (sorted == parts_->asked_before)
        return Asked::same_points;
    parts_->asked_before = std::move(sorted);
    parts_->fill(asked.points, cancel);
    return Asked::points;
}

lightmesh::MeshStatistics MeshShadows::statistics() const {
    return parts_->mesh->statistics();
}

std::vector<std::byte> MeshShadows::snapshot() const {
    return parts_->mesh->snapshot();
}

DeviceFill MeshShadows::spent() const {
    return parts_->mesh->spent();
}

}  // namespace demo
