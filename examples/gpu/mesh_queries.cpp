// SPDX-License-Identifier: MIT
#include "mesh_queries.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/gpu/upload.hpp>

namespace demo {

namespace {

constexpr std::uint32_t query_of_quality_4[] = {
#include "spirv/mesh_query_4.inc"
};
constexpr std::uint32_t query_of_quality_16[] = {
#include "spirv/mesh_query_16.inc"
};

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
                                     const TraceSegments& trace, int timed_runs) {
    const bool is_coarse = mesh_->max_quality() <= 4;
    HostRayQuery query{.shader = is_coarse ? std::span<const std::uint32_t>(query_of_quality_4)
                                           : query_of_quality_16,
                       .kernel = kernels_[is_coarse ? 0 : 1],
                       .bindings = mesh_->bindings(0),
                       .requests = requests_,
                       .no_requests = no_requests_,
                       .light_count = mesh_->light_count(),
                       .rays_per_point = rays_per_point_};
    query.bindings.push_back({0, lightmesh::MeshUpload::requests_binding, requests_});
    Answer answer;
    const auto take_requests = [&](std::size_t, std::span<const std::byte> bytes) {
        const lightmesh::UploadRequests asked = lightmesh::read_requests(bytes);
        answer.requests.insert(answer.requests.end(), asked.points.begin(), asked.points.end());
        answer.overflowed |= asked.overflowed;
    };
    static_cast<HostRayAnswer&>(answer) = query.ask(device_, points, trace, timed_runs, take_requests);
    return answer;
}

}  // namespace demo
