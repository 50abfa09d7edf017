// SPDX-License-Identifier: MIT
#include "host_rays.hpp"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

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
    std::uint32_t kind;
};
enum class Kind : std::uint32_t { all, awaiting, settled, sums };
constexpr std::uint32_t ray_is_open = 1;
constexpr std::uint32_t ray_is_blocked = 2;
constexpr std::uint32_t ray_is_asked = 3;

/// Room for rays that is enough for most points.
constexpr std::uint32_t few_rays = 4;
/// Workgroups of 64 points of a dispatch.
constexpr std::size_t most_points = std::size_t{65535} * 64;

std::uint32_t answer_words(std::uint32_t rays_per_point) {
    return (rays_per_point + 31) / 32;
}

Point point_of(const lightmesh::SurfacePoint& point) {
    return {glm::vec4(point.position, point.footprint), glm::vec4(point.normal, 0.0f),
            glm::vec4(point.shading_normal, 0.0f)};
}

template <class T>
std::span<const std::byte> bytes_of(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

/// Points that are asked at once.
class Batch {
public:
    /// `values`: of each point. `answers`: of points of which sums are asked, else nothing.
    Batch(const ComputeDevice& on, const HostRayQuery& query, std::uint32_t rays_per_point,
          const std::vector<Point>& some, std::size_t values_each, const std::vector<std::uint32_t>& answers)
        : device_(on), point_count_(static_cast<std::uint32_t>(some.size())), rays_per_point_(rays_per_point),
          points_(on, bytes_of(some)), values_(on, some.size() * values_each * sizeof(float)),
          rays_(on, answers.empty() ? some.size() * rays_per_point * sizeof(Ray) : 0),
          awaiting_(on, some.size() * sizeof(std::uint32_t)), answers_(on, bytes_of(answers)),
          kernel_(bound(query)) {}

    double run(Kind kind) const {
        const Work work{point_count_, rays_per_point_, static_cast<std::uint32_t>(kind)};
        return device_.run([&](const ComputeCommands& commands) {
            commands.dispatch(kernel_, (point_count_ + 63) / 64, 1, 1, std::as_bytes(std::span(&work, 1)));
        });
    }

    /// Asks until all rays are known for which there is room. Returns how many were traced.
    std::size_t settle(const TraceSegments& trace) {
        std::size_t traced = 0;
        for (Kind kind = Kind::all;; kind = Kind::awaiting) {
            run(kind);
            known_ = rays_.read_all<Ray>();
            std::vector<lightmesh::Segment> segments;
            std::vector<std::size_t> which;
            for (std::size_t i = 0; i < known_.size(); ++i) {
                if (known_[i].state != ray_is_asked)
                    continue;
                segments.push_back({glm::vec3(known_[i].from), known_[i].to});
                which.push_back(i);
            }
            if (segments.empty())
                return traced;
            std::vector<std::uint8_t> hit(segments.size());
            trace(segments, hit);
            for (std::size_t k = 0; k < which.size(); ++k)
                known_[which[k]].state = hit[k] != 0 ? ray_is_blocked : ray_is_open;
            rays_.write(0, bytes_of(known_));
            traced += segments.size();
        }
    }

    std::vector<float> values() const { return values_.read_all<float>(); }
    /// 1 for points that need more rays than there is room for.
    std::vector<std::uint32_t> awaiting() const { return awaiting_.read_all<std::uint32_t>(); }

    /// Which rays of a point are open, a bit each.
    void write_answers(std::size_t point, std::span<std::uint32_t> words) const {
        for (std::uint32_t number = 0; number < rays_per_point_; ++number)
            if (known_[point * rays_per_point_ + number].state == ray_is_open)
                words[number / 32] |= 1u << number % 32;
    }

private:
    /// The query's kernel, with these buffers.
    const ComputeKernel& bound(const HostRayQuery& query) const {
        std::vector<ComputeBinding> bindings = query.bindings;
        std::uint32_t place = 0;
        for (const ComputeBuffer& buffer : {points_, values_, rays_, awaiting_, answers_})
            bindings.push_back({1, place++, buffer});
        if (!query.kernel)
            return query.kernel.emplace(device_, query.shader, bindings, sizeof(Work));
        for (const ComputeBinding& binding : bindings)
            query.kernel->bind(binding);
        return *query.kernel;
    }

    const ComputeDevice& device_;
    std::uint32_t point_count_;
    std::uint32_t rays_per_point_;
    ComputeBuffer points_;
    ComputeBuffer values_;
    ComputeBuffer rays_;
    ComputeBuffer awaiting_;
    ComputeBuffer answers_;
    ComputeKernel kernel_;
    std::vector<Ray> known_;  ///< what was read last
};

/// The time that the device takes for points whose rays are known.
double time_of_sums(const ComputeDevice& device, const HostRayQuery& query,
                    std::span<const lightmesh::SurfacePoint> points, std::span<const std::uint32_t> answers) {
    const std::uint32_t words = answer_words(query.rays_per_point);
    double seconds = 0.0;
    for (std::size_t first = 0; first < points.size(); first += most_points) {
        const std::size_t count = (std::min)(most_points, points.size() - first);
        std::vector<Point> some;
        std::ranges::transform(points.subspan(first, count), std::back_inserter(some), point_of);
        const auto of_these = answers.subspan(first * words, count * words);
        const Batch batch(device, query, query.rays_per_point, some, 1, {of_these.begin(), of_these.end()});
        seconds += device.least_time([&] { return batch.run(Kind::sums); });
    }
    return seconds;
}

}  // namespace

HostRayAnswer HostRayQuery::ask(const ComputeDevice& device, std::span<const lightmesh::SurfacePoint> points,
                                const TraceSegments& trace, bool is_timed,
                                const TakeRequests& take_requests) const {
    constexpr std::size_t most_bytes = std::size_t{1} << 27;
    HostRayAnswer answer;
    answer.values.resize(points.size() * light_count);
    const std::uint32_t words = answer_words(rays_per_point);
    std::vector<std::uint32_t> answers(is_timed ? points.size() * words : 0);
    std::vector<std::uint32_t> left(points.size());
    std::iota(left.begin(), left.end(), 0u);
    for (std::uint32_t room = (std::min)(few_rays, rays_per_point);; room = rays_per_point) {
        const std::vector<std::uint32_t> asked = std::exchange(left, {});
        const std::size_t most = (std::min)(
            most_points,
            most_bytes / (std::max)({sizeof(float) * light_count, sizeof(Ray) * room, sizeof(float)}));
        for (std::size_t first = 0; first < asked.size(); first += most) {
            const auto which = std::span(asked).subspan(first, (std::min)(most, asked.size() - first));
            std::vector<Point> some;
            for (const std::uint32_t number : which)
                some.push_back(point_of(points[number]));
            Batch batch(device, *this, room, some, light_count, {});
            answer.rays += batch.settle(trace);
            // Once more, since what was guessed of rays may have led to requests.
            requests.write(0, no_requests);
            batch.run(room < rays_per_point ? Kind::settled : Kind::all);
            take_requests(which, requests.read_all<std::byte>());
            const std::vector<float> values = batch.values();
            const std::vector<std::uint32_t> awaiting = batch.awaiting();
            for (std::size_t i = 0; i < which.size(); ++i) {
                std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(i * light_count), light_count,
                            answer.values.begin() + static_cast<std::ptrdiff_t>(which[i] * light_count));
                if (awaiting[i] != 0)
                    left.push_back(which[i]);
                else if (is_timed)
                    batch.write_answers(i, std::span(answers).subspan(which[i] * words, words));
            }
        }
        if (left.empty() || room == rays_per_point)
            break;
    }
    answer.points_without_rays = left.size();
    if (is_timed)
        answer.seconds = time_of_sums(device, *this, points, answers);
    return answer;
}

}  // namespace demo
