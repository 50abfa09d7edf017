// SPDX-License-Identifier: MIT
#include "gpu/mesh_shadows.hpp"

#include "gpu/host_visibility.hpp"
#include "gpu/listed_words.hpp"
#include "gpu/listing.hpp"
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
#include <variant>
#include <vector>

namespace demo {

namespace {

/// Points that shaders can ask for at once.
constexpr std::size_t request_capacity = std::size_t{1} << 16;

/// Whether an algorithm's long tests are rays.
bool is_by_rays(const std::string& algorithm) {
    return algorithm.find('+') == std::string::npos;
}

}  // namespace

/// A mesh whose links and long tests shaders trace.
class MeshByRays {
public:
    MeshByRays(const ComputeDevice& device, const EmbreeScene& scene, const GpuScene& copy,
               const VisibilityOptions& options)
        : mesh_(scene.intersector(), shapes_of_lights(scene.scene()), mesh_settings_of(options)),
          link_tests_(device, copy), long_tests_(device, copy) {
        if (!options.known.empty())
            mesh_.merge(options.known);
    }

    /// Lets shaders see the mesh as they have it, for `fill`.
    void bind(const UploadedMesh& uploaded) {
        link_tests_.bind(uploaded.bindings(LinkTests::set));
        long_tests_.bind(uploaded.bindings(LongTests::set));
    }

    /// Finds what shaders lack at points.
    void fill(std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel) {
        const auto links = list_on_all_threads<lightmesh::LinkList>(
            points, [&](auto some, auto& list) { mesh_.list_links(some, list); });
        mesh_.fill_links(links, [&](auto words, auto open) { link_tests_(words, open, cancel); });
        const auto missing = list_on_all_threads<lightmesh::LongTestList>(
            points, [&](auto some, auto& list) { mesh_.list_long_tests(some, list); });
        mesh_.fill(missing, [&](auto words, auto seen) { long_tests_(words, seen, cancel); });
    }

    void update(const EmbreeScene& scene, const SceneChange& change) {
        follow_scene(mesh_, shapes_of_lights(scene.scene()), change);
        mesh_.compact();
    }

    void begin_frame() {
        mesh_.begin_frame();
        mesh_.compact();
    }
    void merge(std::span<const std::byte> known) { mesh_.merge(known); }

    std::vector<std::byte> snapshot() const { return mesh_.snapshot(); }
    lightmesh::MeshStatistics mesh() const { return mesh_.statistics(); }
    DeviceFill spent() const {
        DeviceFill sum = link_tests_.spent();
        sum += long_tests_.spent();
        return sum;
    }

private:
    lightmesh::LightMesh<EmbreeIntersector> mesh_;
    LinkTests link_tests_;
    LongTests long_tests_;
};

/// The mesh that shaders have a copy of. After an update it knows what its snapshots know: they have the
/// lights in the order of a new mesh, and know them by whole groups. Where the mesh knew more, it would find
/// nothing to fill for a point that lacks something in a shader.
using HostMesh = std::variant<MeshByRays, HostVisibility>;

struct MeshShadows::Parts {
    Parts(const ComputeDevice& device, const std::string& algorithm, const EmbreeScene& scene,
          const GpuScene& copy, const VisibilityOptions& options)
        : mesh(mesh_of(device, algorithm, scene, copy, options)), uploaded(device, snapshot()),
          has_budget(options.settings.memory_budget != lightmesh::Settings{}.memory_budget),
          no_requests(lightmesh::empty_requests(request_capacity)), requests(device, no_requests) {}

    static HostMesh mesh_of(const ComputeDevice& device, const std::string& algorithm,
                            const EmbreeScene& scene, const GpuScene& copy,
                            const VisibilityOptions& options) {
        if (is_by_rays(algorithm))
            return HostMesh(std::in_place_type<MeshByRays>, device, scene, copy, options);
        return HostMesh(std::in_place_type<HostVisibility>, algorithm, scene, options);
    }

    std::vector<std::byte> snapshot() const {
        return std::visit([](const auto& host) { return host.snapshot(); }, mesh);
    }

    void find(std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel) {
        if (auto* by_rays = std::get_if<MeshByRays>(&mesh))
            by_rays->bind(uploaded);
        std::visit([&](auto& host) { host.fill(points, cancel); }, mesh);
    }

    void fill(std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel) {
        find(points, cancel);
        uploaded.update(snapshot());
    }

    /// Before shaders see the mesh.
    void upload_changes() {
        if (has_changed)
            uploaded.update(snapshot());
        has_changed = false;
    }

    HostMesh mesh;
    UploadedMesh uploaded;
    bool has_budget;
    bool has_changed = false;  ///< between pictures, since the last upload
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
    parts_->has_changed = true;
    std::visit([&](auto& host) { host.update(scene, change); }, parts_->mesh);
}

void MeshShadows::begin_frame() {
    if (!parts_->has_budget)
        return;
    parts_->has_changed = true;
    std::visit([](auto& host) { host.begin_frame(); }, parts_->mesh);
}

bool MeshShadows::has_budget() const {
    return parts_->has_budget;
}

void MeshShadows::note_use(std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel) {
    parts_->find(points, cancel);
}

void MeshShadows::merge(std::span<const std::byte> known) {
    parts_->has_changed = true;
    std::visit([&](auto& host) { host.merge(known); }, parts_->mesh);
}

std::vector<ComputeBinding> MeshShadows::bindings() const {
    std::vector<ComputeBinding> made = parts_->uploaded.bindings(set);
    made.push_back(
        {.set = set, .binding = lightmesh::MeshUpload::requests_binding, .buffer = parts_->requests});
    return made;
}

void MeshShadows::bind(const ComputeKernel& kernel) const {
    parts_->upload_changes();
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
    return std::visit([](const auto& host) { return host.mesh(); }, parts_->mesh);
}

std::vector<std::byte> MeshShadows::snapshot() const {
    return parts_->snapshot();
}

DeviceFill MeshShadows::spent() const {
    return std::visit([](const auto& host) { return host.spent(); }, parts_->mesh);
}

}  // namespace demo
