// SPDX-License-Identifier: MIT
#include "gpu/mesh_shadows.hpp"

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
#include <span>
#include <utility>
#include <vector>

namespace demo {

namespace {

/// Points that shaders can ask for at once.
constexpr std::size_t request_capacity = std::size_t{1} << 16;

}  // namespace

struct MeshShadows::Parts {
    Parts(const ComputeDevice& device, const EmbreeScene& scene, const GpuScene& copy,
          const VisibilityOptions& options)
        : mesh(scene.intersector(), shapes_of_lights(scene.scene()), options.settings),
          uploaded(device, mesh.snapshot()), long_tests(device, copy),
          no_requests(lightmesh::empty_requests(request_capacity)), requests(device, no_requests) {}

    void fill(std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel) {
        const auto missing = list_on_all_threads<lightmesh::LongTestList>(
            points, [&](auto some, auto& list) { mesh.list_long_tests(some, list); });
        long_tests.bind(uploaded.bindings(LongTests::set));
        mesh.fill(missing, [&](auto words, auto seen) { long_tests(words, seen, cancel); });
        uploaded.update(mesh.snapshot());
    }

    lightmesh::LightMesh<EmbreeIntersector> mesh;
    UploadedMesh uploaded;
    LongTests long_tests;
    std::vector<std::byte> no_requests;
    ComputeBuffer requests;
    std::vector<std::array<float, 7>> asked_before;  ///< positions, normals and footprints, sorted
};

MeshShadows::MeshShadows(const ComputeDevice& device, const EmbreeScene& scene, const GpuScene& copy,
                         const VisibilityOptions& options)
    : parts_(std::make_unique<Parts>(device, scene, copy, options)) {}

MeshShadows::~MeshShadows() = default;

void MeshShadows::update(const EmbreeScene& scene, const SceneChange& change) {
    parts_->asked_before.clear();
    if (!change.changes_shadows())
        return;
    follow_scene(parts_->mesh, shapes_of_lights(scene.scene()), change);
    // Snapshots have the lights in the order of a new mesh, and know them by whole groups: where the mesh
    // knew more, it would find nothing to fill for a point that lacks something in a shader.
    parts_->mesh.compact();
    parts_->uploaded.update(parts_->mesh.snapshot());
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
    return parts_->mesh.statistics();
}

const DeviceFill& MeshShadows::spent() const {
    return parts_->long_tests.spent();
}

}  // namespace demo
