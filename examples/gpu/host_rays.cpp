// SPDX-License-Identifier: MIT
#include "host_rays.hpp"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <limits>

namespace demo {

namespace {

// As in host_rays.glsl.
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

/// Points that are asked at once.
struct Batch {
    Batch(const ComputeDevice& on, const HostRayQuery& query, std::span<const lightmesh::SurfacePoint> some)
        : device(on), work{static_cast<std::uint32_t>(some.size()), query.rays_per_point, 0, 0},
          points(on, std::as_bytes(std::span<const Point>(points_of(some)))),
          values(on, some.size() * (std::max)(query.light_count, std::size_t{1}) * sizeof(float)),
          rays(on, some.size() * query.rays_per_point * sizeof(Ray)),
          awaiting(on, some.size() * sizeof(std::uint32_t)), kernel(bound(query)) {}

    /// The query's kernel, with these buffers.
    const ComputeKernel& bound(const HostRayQuery& query) const {
        std::vector<ComputeBinding> bindings = query.bindings;
        std::uint32_t place = 0;
        for (const ComputeBuffer& buffer : {points, values, rays, awaiting})
            bindings.push_back({1, place++, buffer});
        if (!query.kernel)
            return query.kernel.emplace(device, query.shader, bindings, sizeof(Work));
        for (const ComputeBinding& binding : bindings)
            query.kernel->bind(binding);
        return *query.kernel;
    }

    enum class Kind { all, awaiting, sums };

    double run(Kind kind) const {
        Work now = work;
        now.only_awaiting = kind == Kind::awaiting ? 1 : 0;
        now.sums_only = kind == Kind::sums ? 1 : 0;
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

    const ComputeDevice& device;
    Work work;
    ComputeBuffer points;
    ComputeBuffer values;
    ComputeBuffer rays;
    ComputeBuffer awaiting;
    ComputeKernel kernel;
};

}  // namespace

HostRayAnswer HostRayQuery::ask(
    const ComputeDevice& device, std::span<const lightmesh::SurfacePoint> points, const TraceSegments& trace,
    int timed_runs,
    const std::function<void(std::size_t first, std::span<const std::byte>)>& take_requests) const {
    constexpr std::size_t most_bytes = std::size_t{1} << 27;
    const std::size_t most =
        (std::min)(most_bytes / (sizeof(float) * (std::max)(light_count, std::size_t{1})),
                   (std::min)(most_bytes / (sizeof(Ray) * rays_per_point), std::size_t{65535} * 64));
    HostRayAnswer answer;
    for (std::size_t first = 0; first < points.size(); first += most) {
        const auto some = points.subspan(first, (std::min)(most, points.size() - first));
        const Batch batch(device, *this, some);
        for (auto kind = Batch::Kind::all;; kind = Batch::Kind::awaiting) {
            batch.run(kind);
            const std::size_t traced = batch.trace_asked(trace);
            answer.rays += traced;
            if (traced == 0)
                break;
        }
        // Once more, since what was guessed of rays may have led to requests.
        requests.write(0, no_requests);
        batch.run(Batch::Kind::all);
        const auto values = batch.values.read_all<float>();
        answer.values.insert(answer.values.end(), values.begin(),
                             values.begin() + static_cast<std::ptrdiff_t>(some.size() * light_count));
        take_requests(first, requests.read_all<std::byte>());
        for (const std::uint32_t awaits : batch.awaiting.read_all<std::uint32_t>())
            answer.points_without_rays += awaits;
        double least = timed_runs > 0 ? std::numeric_limits<double>::infinity() : 0.0;
        for (int i = 0; i < timed_runs; ++i)
            least = (std::min)(least, batch.run(Batch::Kind::sums));
        answer.seconds += least;
    }
    return answer;
}

}  // namespace demo
