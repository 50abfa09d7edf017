// SPDX-License-Identifier: MIT
#include "cache_queries.hpp"

#include <lightmesh/snapshot.hpp>

#include <utility>

namespace demo {

namespace {

constexpr std::uint32_t shader[] = {
#include "spirv/cache_query.comp.inc"
};

}  // namespace

CacheQueries::CacheQueries(const ComputeDevice& device, std::uint32_t rays_per_point)
    : device_(device), rays_per_point_(rays_per_point) {}

std::size_t CacheQueries::upload(std::span<const std::byte> snapshot) {
    const lightmesh::SnapshotView view(snapshot);
    const lightmesh::CacheUpload cache(view);
    std::vector<ComputeBuffer> buffers;
    std::size_t written = 0;
    for (const lightmesh::UploadBuffer& buffer : cache.buffers()) {
        buffers.emplace_back(device_, buffer.bytes);
        written += buffer.bytes.size();
    }
    buffers_ = std::move(buffers);
    light_count_ = view.light_count();
    return written;
}

CacheQueries::Answer CacheQueries::ask(std::span<const lightmesh::SurfacePoint> points,
                                       const TraceSegments& trace, int timed_runs,
                                       std::size_t request_capacity) {
    const std::vector<std::byte> no_requests = lightmesh::CacheUpload::empty_requests(request_capacity);
    HostRayQuery query{.shader = shader,
                       .kernel = kernel_,
                       .bindings = {},
                       .requests = ComputeBuffer(device_, no_requests),
                       .no_requests = no_requests,
                       .light_count = light_count_,
                       .rays_per_point = rays_per_point_};
    for (std::uint32_t i = 0; i < buffers_.size(); ++i)
        query.bindings.push_back({0, i, buffers_[i]});
    query.bindings.push_back({0, lightmesh::CacheUpload::requests_binding, query.requests});
    Answer answer;
    const auto take_requests = [&](std::size_t first, std::span<const std::byte> bytes) {
        answer.asked += lightmesh::CacheUpload::request_count(bytes);
        for (lightmesh::CacheRequest request : lightmesh::CacheUpload::requests(bytes)) {
            request.id += static_cast<std::uint32_t>(first);
            answer.requests.push_back(request);
        }
    };
    static_cast<HostRayAnswer&>(answer) = query.ask(device_, points, trace, timed_runs, take_requests);
    return answer;
}

}  // namespace demo
