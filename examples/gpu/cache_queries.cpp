// SPDX-License-Identifier: MIT
#include "cache_queries.hpp"

namespace demo {

namespace {

constexpr std::uint32_t shader[] = {
#include "spirv/cache_query.comp.inc"
};

}  // namespace

CacheQueries::CacheQueries(const ComputeDevice& device, std::uint32_t rays_per_point)
    : device_(device), rays_per_point_(rays_per_point) {}

std::size_t CacheQueries::upload(std::span<const std::byte> snapshot) {
    if (cache_)
        return cache_->update(snapshot);
    return cache_.emplace(device_, snapshot).size();
}

CacheQueries::Answer CacheQueries::ask(std::span<const lightmesh::SurfacePoint> points,
                                       const TraceSegments& trace, bool is_timed,
                                       std::size_t request_capacity) {
    const std::vector<std::byte> no_requests = lightmesh::CacheUpload::empty_requests(request_capacity);
    HostRayQuery query{.shader = shader,
                       .kernel = kernel_,
                       .bindings = cache_->bindings(0),
                       .requests = ComputeBuffer(device_, no_requests),
                       .no_requests = no_requests,
                       .light_count = cache_->light_count(),
                       .rays_per_point = rays_per_point_};
    query.bindings.push_back({0, lightmesh::CacheUpload::requests_binding, query.requests});
    Answer answer;
    const auto take_requests = [&](std::span<const std::uint32_t> which, std::span<const std::byte> bytes) {
        answer.asked += lightmesh::CacheUpload::request_count(bytes);
        for (lightmesh::CacheRequest request : lightmesh::CacheUpload::requests(bytes)) {
            request.id = which[request.id];
            answer.requests.push_back(request);
        }
    };
    static_cast<HostRayAnswer&>(answer) = query.ask(device_, points, trace, is_timed, take_requests);
    return answer;
}

}  // namespace demo
