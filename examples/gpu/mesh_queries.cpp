// SPDX-License-Identifier: MIT
#include "mesh_queries.hpp"

#include <lightmesh/snapshot.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace demo {

namespace {

constexpr std::uint32_t query_of_quality_4[] = {
#include "spirv/mesh_query_4.inc"
};
constexpr std::uint32_t query_of_quality_16[] = {
#include "spirv/mesh_query_16.inc"
};

struct Ray {
    std::array<float, 3> end;
    std::uint32_t state;
};
constexpr std::uint32_t ray_is_open = 1;
constexpr std::uint32_t ray_is_blocked = 2;
constexpr std::uint32_t ray_is_asked = 3;

struct Work {
    std::uint32_t point_count;
    std::uint32_t rays_per_point;
    std::uint32_t only_awaiting;
    std::uint32_t sums_only;
};

std::vector<float> floats_of(std::span<const lightmesh::SurfacePoint> points) {
    std::vector<float> floats;
    floats.reserve(6 * points.size());
    for (const auto& point : points)
        for (const auto& v : {point.position, point.normal})
            floats.insert(floats.end(), {v.x, v.y, v.z});
    return floats;
}

}  // namespace

/// Points that are asked at once.
struct MeshQueries::Batch {
    Batch(MeshQueries& from, std::span<const lightmesh::SurfacePoint> points)
        : work{static_cast<std::uint32_t>(points.size()), from.rays_per_point_, 0, 0},
          positions(from.device_, std::as_bytes(std::span<const float>(floats_of(points)))),
          values(from.device_, points.size() * (std::max)(from.light_count_, std::size_t{1}) * sizeof(float)),
          rays(from.device_, points.size() * from.rays_per_point_ * sizeof(Ray)),
          ends(from.device_, points.size() * 4 * sizeof(float)), kernel(kernel_of(from)) {}

    /// The kernel that serves the mesh, with these buffers.
    ComputeKernel kernel_of(MeshQueries& from) const {
        std::vector<ComputeBinding> bindings;
        for (std::uint32_t i = 0; i < from.buffers_.size(); ++i)
            bindings.push_back({0, i, from.buffers_[i]});
        bindings.push_back({0, lightmesh::MeshUpload::requests_binding, *from.requests_});
        bindings.push_back({1, 0, positions});
        bindings.push_back({1, 1, values});
        bindings.push_back({1, 2, rays});
        bindings.push_back({1, 3, ends});
        const bool is_coarse = from.upload_->max_quality() <= 4;
        std::optional<ComputeKernel>& made = from.kernels_[is_coarse ? 0 : 1];
        if (made) {
            for (const ComputeBinding& binding : bindings)
                made->bind(binding);
        } else {
            made.emplace(from.device_,
                         is_coarse ? std::span<const std::uint32_t>(query_of_quality_4) : query_of_quality_16,
                         bindings, sizeof(Work));
        }
        return *made;
    }

    enum class Kind { all, awaiting, sums };

    double run(const ComputeDevice& device, Kind kind) const {
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
        const auto begin = ends.read_all<std::array<float, 4>>();
        std::vector<lightmesh::Segment> segments;
        std::vector<std::size_t> which;
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (all[i].state != ray_is_asked)
                continue;
            const auto& from = begin[i / work.rays_per_point];
            segments.push_back({{from[0], from[1], from[2]}, {all[i].end[0], all[i].end[1], all[i].end[2]}});
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
    ComputeBuffer positions;
    ComputeBuffer values;
    ComputeBuffer rays;
    ComputeBuffer ends;
    ComputeKernel kernel;
};

MeshQueries::MeshQueries(const ComputeDevice& device, std::size_t request_capacity,
                         std::uint32_t rays_per_point)
    : device_(device), request_capacity_(request_capacity), rays_per_point_(rays_per_point) {}

std::size_t MeshQueries::upload(std::span<const std::byte> snapshot) {
    const lightmesh::SnapshotView view(snapshot);
    light_count_ = view.light_count();
    std::size_t written = 0;
    if (!upload_) {
        upload_.emplace(view);
        requests_.emplace(device_, lightmesh::empty_requests(request_capacity_));
        for (const lightmesh::UploadBuffer& buffer : upload_->buffers()) {
            buffers_.emplace_back(device_, buffer.bytes);
            written += buffer.bytes.size();
        }
        return written;
    }
    for (const lightmesh::UploadRange& range : upload_->update(view)) {
        ComputeBuffer& buffer = buffers_[range.binding];
        if (buffer.size() != upload_->buffers()[range.binding].bytes.size())
            buffer = ComputeBuffer(device_, range.bytes);
        else
            buffer.write(range.offset, range.bytes);
        written += range.bytes.size();
    }
    return written;
}

MeshQueries::Answer MeshQueries::ask(std::span<const lightmesh::SurfacePoint> points,
                                     const TraceSegments& trace, int timed_runs) {
    constexpr std::size_t most_bytes = std::size_t{1} << 27;
    const std::size_t most =
        (std::min)(most_bytes / (sizeof(float) * (std::max)(light_count_, std::size_t{1})),
                   (std::min)(most_bytes / (sizeof(Ray) * rays_per_point_), std::size_t{65535} * 64));
    Answer answer;
    for (std::size_t first = 0; first < points.size(); first += most) {
        const auto some = points.subspan(first, (std::min)(most, points.size() - first));
        const Batch batch(*this, some);
        const std::vector<std::byte> no_requests = lightmesh::empty_requests(request_capacity_);
        for (auto kind = Batch::Kind::all;; kind = Batch::Kind::awaiting) {
            batch.run(device_, kind);
            const std::size_t traced = batch.trace_asked(trace);
            answer.rays += traced;
            if (traced == 0)
                break;
        }
        // Once more, since what was guessed of rays may have led to requests.
        requests_->write(0, no_requests);
        batch.run(device_, Batch::Kind::all);
        const auto values = batch.values.read_all<float>();
        answer.values.insert(answer.values.end(), values.begin(),
                             values.begin() + static_cast<std::ptrdiff_t>(some.size() * light_count_));
        const auto requests = lightmesh::read_requests(requests_->read_all<std::byte>());
        answer.requests.insert(answer.requests.end(), requests.points.begin(), requests.points.end());
        answer.overflowed |= requests.overflowed;
        for (const auto& end : batch.ends.read_all<std::array<float, 4>>())
            answer.points_without_rays += end[3] != 0.0f ? 1u : 0u;
        double least = timed_runs > 0 ? std::numeric_limits<double>::infinity() : 0.0;
        for (int i = 0; i < timed_runs; ++i)
            least = (std::min)(least, batch.run(device_, Batch::Kind::sums));
        answer.seconds += least;
    }
    return answer;
}

}  // namespace demo
