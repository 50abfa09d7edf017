// SPDX-License-Identifier: MIT
#include "mesh_queries.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/gpu/upload.hpp>

#include <algorithm>
#include <array>
#include <cstddef>

namespace demo {

namespace {

constexpr std::uint32_t query_of_quality_4[] = {
#include "spirv/mesh_query_4.inc"
};
constexpr std::uint32_t query_of_quality_16[] = {
#include "spirv/mesh_query_16.inc"
};
constexpr std::uint32_t footprints_of_quality_4[] = {
#include "spirv/mesh_query_footprints_4.inc"
};
constexpr std::uint32_t footprints_of_quality_16[] = {
#include "spirv/mesh_query_footprints_16.inc"
};
constexpr std::uint32_t exact_query[] = {
#include "spirv/mesh_query_exact.inc"
};

/// Without footprints and with them: for q up to 4, and up to 16. Then that of the exact short test.
constexpr std::array<std::span<const std::uint32_t>, 5> shaders{
    query_of_quality_4, query_of_quality_16, footprints_of_quality_4, footprints_of_quality_16, exact_query};

}  // namespace

MeshQueries::MeshQueries(const ComputeDevice& device, std::size_t request_capacity,
                         std::uint32_t rays_per_point)
    : device_(device), rays_per_point_(rays_per_point),
      no_requests_(lightmesh::empty_requests(request_capacity)), requests_(device, no_requests_) {}

std::size_t MeshQueries::upload(std::span<const std::byte> snapshot) {
    if (mesh_)
        return mesh_->update(snapshot);
    return mesh_.emplace(device_, snapshot).size();
}

MeshQueries::Answer MeshQueries::ask(std::span<const lightmesh::SurfacePoint> points,
                                     const TraceSegments& trace, bool is_timed) {
    const bool has_footprints =
        std::ranges::any_of(points, [](const auto& point) { return point.footprint != 0.0f; });
    const lightmesh::MeshUpload& upload = mesh_->upload();
    const std::size_t which =
        upload.is_exact() ? 4u : (upload.max_quality() <= 4 ? 0u : 1u) + (has_footprints ? 2u : 0u);
    HostRayQuery query{.shader = shaders[which],
                       .kernel = kernels_[which],
                       .bindings = mesh_->bindings(0),
                       .requests = requests_,
                       .no_requests = no_requests_,
                       .light_count = mesh_->light_count(),
                       .rays_per_point = rays_per_point_};
    query.bindings.push_back({0, lightmesh::MeshUpload::requests_binding, requests_});
    Answer answer;
    const auto take_requests = [&](std::span<const std::uint32_t>, std::span<const std::byte> bytes) {
        const lightmesh::UploadRequests asked = lightmesh::read_requests(bytes);
        answer.requests.insert(answer.requests.end(), asked.points.begin(), asked.points.end());
        answer.overflowed |= asked.overflowed;
    };
    static_cast<HostRayAnswer&>(answer) = query.ask(device_, points, trace, is_timed, take_requests);
    return answer;
}

}  // namespace demo
