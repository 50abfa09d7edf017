// SPDX-License-Identifier: MIT
#include "gpu/mesh_levels.hpp"

#include "gpu/uploaded_mesh.hpp"
#include "render/follow_scene.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/lightmesh.hpp>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace demo {

namespace {

/// Points that shaders can ask for at once.
constexpr std::size_t request_capacity = std::size_t{1} << 16;

lightmesh::Settings settings_at(lightmesh::Settings settings, int level) {
    settings.radius = std::ldexp(settings.radius, level);
    settings.footprint_scale = 0.0f;
    return settings;
}

}  // namespace

struct MeshLevels::Level {
    Level(const ComputeDevice& device, const EmbreeScene& scene, const VisibilityOptions& options, int level)
        : mesh(scene.intersector(), shapes_of_lights(scene.scene()), settings_at(options.settings, level)),
          uploaded(device, mesh.snapshot()) {}

    void fill(std::span<const lightmesh::SurfacePoint> points, LongTests& long_tests,
              const std::atomic<bool>* cancel) {
        constexpr std::size_t at_once = 256;
        const lightmesh::LongTestList missing = tbb::parallel_deterministic_reduce(
            tbb::blocked_range<std::size_t>(0, points.size(), at_once), lightmesh::LongTestList(),
            [&](const auto& part, lightmesh::LongTestList list) {
                mesh.list_long_tests(points.subspan(part.begin(), part.size()), list);
                return list;
            },
            [](lightmesh::LongTestList list, const lightmesh::LongTestList& other) {
                list.add(other);
                return list;
            });
        long_tests.bind(uploaded.bindings(LongTests::set));
        mesh.fill(missing, [&](auto words, auto seen) { long_tests(words, seen, cancel); });
        uploaded.update(mesh.snapshot());
    }

    void update(const EmbreeScene& scene, const SceneChange& change) {
        follow_scene(mesh, shapes_of_lights(scene.scene()), change);
        // Snapshots have the lights in the order of a new mesh.
        mesh.compact();
        uploaded.update(mesh.snapshot());
    }

    lightmesh::LightMesh<EmbreeIntersector> mesh;
    UploadedMesh uploaded;
};

MeshLevels::MeshLevels(const ComputeDevice& device, const EmbreeScene& scene, const GpuScene& copy,
                       const VisibilityOptions& options)
    : device_(device), scene_(scene), options_(options), long_tests_(device, copy),
      levels_(lightmesh::most_mesh_levels), nothing_(device, std::size_t{16}),
      requests_(device, lightmesh::empty_requests(request_capacity)) {}

MeshLevels::~MeshLevels() = default;

MeshLevels::Level& MeshLevels::at(int level) {
    std::unique_ptr<Level>& found = levels_.at(static_cast<std::size_t>(level));
    if (!found)
        found = std::make_unique<Level>(device_, scene_, options_, level);
    return *found;
}

void MeshLevels::update(const SceneChange& change) {
    for (const std::unique_ptr<Level>& level : levels_)
        if (level && change.changes_shadows())
            level->update(scene_, change);
    asked_before_.clear();
}

std::vector<ComputeBinding> MeshLevels::bindings() const {
    std::vector<ComputeBinding> made;
    for (std::uint32_t i = 0; i < lightmesh::MeshUpload::buffer_count; ++i)
        made.push_back({.set = set, .binding = i, .buffer = nothing_});
    made.push_back({.set = set, .binding = lightmesh::MeshUpload::requests_binding, .buffer = requests_});
    return made;
}

void MeshLevels::bind(const ComputeKernel& kernel, int level) {
    for (const ComputeBinding& binding : at(level).uploaded.bindings(set))
        kernel.bind(binding);
    requests_.write(0, lightmesh::empty_requests(request_capacity));
}

MeshLevels::Asked MeshLevels::fill(int level, const std::atomic<bool>* cancel) {
    const lightmesh::UploadRequests asked = lightmesh::read_requests(requests_.read_all<std::byte>());
    if (asked.points.empty() && !asked.overflowed) {
        asked_before_.clear();
        return Asked::nothing;
    }
    std::vector<std::array<float, 6>> sorted;
    for (const lightmesh::SurfacePoint& point : asked.points)
        sorted.push_back({point.position.x, point.position.y, point.position.z, point.normal.x,
                          point.normal.y, point.normal.z});
    std::ranges::sort(sorted);
    if (sorted == asked_before_)
        return Asked::same_points;
    asked_before_ = std::move(sorted);
    at(level).fill(asked.points, long_tests_, cancel);
    return Asked::points;
}

lightmesh::MeshStatistics MeshLevels::statistics() const {
    lightmesh::MeshStatistics sum;
    for (std::size_t k = 0; k < levels_.size(); ++k)
        if (levels_[k])
            sum.add_level(k, levels_[k]->mesh.statistics());
    return sum;
}

}  // namespace demo
