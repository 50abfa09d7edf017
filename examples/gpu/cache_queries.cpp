// SPDX-License-Identifier: MIT
#include "cache_queries.hpp"

#include <lightmesh/segment.hpp>
#include <lightmesh/snapshot.hpp>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cstring>
#include <limits>

namespace demo {

namespace {

constexpr std::uint32_t query[] = {
#include "spirv/cache_query.comp.inc"
};

// As in cache_query.comp.
struct Point {
    glm::vec4 position;
    glm::vec4 normal;
    glm::vec4 shading_normal;
};
struct Ray {
    glm::vec4 from;
    glm::vec3 to;
    std::uint32_t state;
};
struct Work {
    std::uint32_t point_count;
    std::uint32_t rays_per_point;
    std::uint32_t only_awaiting;
    std::uint32_t sums_only;
};
constexpr std::uint32_t ray_is_open = 1;
constexpr std::uint32_t ray_is_blocked = 2;
constexpr std::uint32_t ray_is_asked = 3;

std::vector<Point> points_of(std::span<const lightmesh::SurfacePoint> points) {
    std::vector<Point> all;
    all.reserve(points.size());
    for (const lightmesh::SurfacePoint& point : points)
        all.push_back({glm::vec4(point.position, point.footprint), glm::vec4(point.normal, 0.0f),
                       glm::vec4(point.shading_normal, 0.0f)});
    return all;
}

}  // namespace

/// Points that are asked at once.
struct CacheQueries::Batch {
    Batch(CacheQueries& from, std::span<const lightmesh::SurfacePoint> some, std::size_t request_capacity)
        : work{static_cast<std::uint32_t>(some.size()), from.rays_per_point_, 0, 0},
          points(from.device_, std::as_bytes(std::span<const Point>(points_of(some)))),
          values(from.device_, some.size() * (std::max)(from.light_count_, std::size_t{1}) * sizeof(float)),
          rays(from.device_, some.size() * from.rays_per_point_ * sizeof(Ray)),
          awaiting(from.device_, some.size() * sizeof(std::uint32_t)),
          requests(from.device_, lightmesh::CacheUpload::empty_requests(request_capacity)),
          kernel(bound(from)) {}

    const ComputeKernel& bound(CacheQueries& from) const {
        std::vector<ComputeBinding> bindings;
        for (std::uint32_t i = 0; i < from.buffers_.size(); ++i)
            bindings.push_back({0, i, from.buffers_[i]});
        bindings.push_back({0, lightmesh::CacheUpload::requests_binding, requests});
        bindings.push_back({1, 0, points});
        bindings.push_back({1, 1, values});
        bindings.push_back({1, 2, rays});
        bindings.push_back({1, 3, awaiting});
        if (!from.kernel_)
            return from.kernel_.emplace(from.device_, query, bindings, sizeof(Work));
        for (const ComputeBinding& binding : bindings)
            from.kernel_->bind(binding);
        return *from.kernel_;
    }

    double run(const ComputeDevice& device, bool only_awaiting, bool sums_only) const {
        Work now = work;
        now.only_awaiting = only_awaiting ? 1 : 0;
        now.sums_only = sums_only ? 1 : 0;
        return device.run([&](const ComputeCommands& commands) {
            commands.dispatch(kernel, (now.point_count + 63) / 64, 1, 1, std::as_bytes(std::span(&now, 1)));
        });
    }

    /// Traces the rays that were asked for. Returns how many that were.
    std::size_t trace_asked(const TraceSegments& trace) const {
        auto all = rays.read_all<Ray>();
        std::vector<lightmesh::Segment> segments;
        std::vector<std::size_t> which;
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (all[i].state != ray_is_asked)
                continue;
            segments.push_back({glm::vec3(all[i].from), all[i].to});
            which.push_back(i);
        }
        if (segments.empty())
            return 0;
        std::vector<std::uint8_t> hit(segments.size());
        trace(segments, hit);
        for (std::size_t k = 0; k < which.size(); ++k)
            all[which[k]].state = hit[k] != 0 ? ray_is_blocked : ray_is_open;
        rays.write(0, std::as_bytes(std::span(all)));
        return segments.size();
    }

    Work work;
    ComputeBuffer points;
    ComputeBuffer values;
    ComputeBuffer rays;
    ComputeBuffer awaiting;
    ComputeBuffer requests;
    ComputeKernel kernel;
};

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
    constexpr std::size_t most_bytes = std::size_t{1} << 27;
    const std::size_t most =
        (std::min)(most_bytes / (sizeof(float) * (std::max)(light_count_, std::size_t{1})),
                   (std::min)(most_bytes / (sizeof(Ray) * rays_per_point_), std::size_t{65535} * 64));
    Answer answer;
    for (std::size_t first = 0; first < points.size(); first += most) {
        const auto some = points.subspan(first, (std::min)(most, points.size() - first));
        const Batch batch(*this, some, request_capacity);
        for (bool only_awaiting = false;; only_awaiting = true) {
            batch.run(device_, only_awaiting, false);
            const std::size_t traced = batch.trace_asked(trace);
            answer.rays += traced;
            if (traced == 0)
                break;
        }
        // Once more, since what was guessed of rays may have led to requests.
        batch.requests.write(0, lightmesh::CacheUpload::empty_requests(request_capacity));
        batch.run(device_, false, false);
        const auto values = batch.values.read_all<float>();
        answer.values.insert(answer.values.end(), values.begin(),
                             values.begin() + static_cast<std::ptrdiff_t>(some.size() * light_count_));
        const auto bytes = batch.requests.read_all<std::byte>();
        answer.asked += lightmesh::CacheUpload::request_count(bytes);
        for (lightmesh::CacheRequest request : lightmesh::CacheUpload::requests(bytes)) {
            request.id += static_cast<std::uint32_t>(first);
            answer.requests.push_back(request);
        }
        for (const std::uint32_t awaits : batch.awaiting.read_all<std::uint32_t>())
            answer.points_without_rays += awaits;
        double least = timed_runs > 0 ? std::numeric_limits<double>::infinity() : 0.0;
        for (int i = 0; i < timed_runs; ++i)
            least = (std::min)(least, batch.run(device_, false, true));
        answer.seconds += least;
    }
    return answer;
}

}  // namespace demo
